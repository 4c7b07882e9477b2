"""Targets that are too close to a cell for its ordinary grid, and what replaces it there.

Which pairs are close is found once for a set of targets and a set of cells; every sum over the same
cells then leaves these pairs out and adds the graded rule's integrals. Pairs are listed up to a
capacity; if there are more, velocities are NaN rather than wrong.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from celltrain.flow.close import CloseRule
from celltrain.flow.sources import Sources
from celltrain.harmonics.jax_shapes import JaxShapes
from celltrain.proximity.close_pairs import ClosePairs, close_pairs

# Pairs whose matrices are applied together.
PAIRS_AT_ONCE = 64


class CloseTargets(eqx.Module):
    """Close pairs of one set of targets; `rows` are the double layer's matrices, if prepared."""

    pairs: ClosePairs
    rows: Float[Array, "pair 3 3 coefficient"] | None = None


class CloseEvaluation(eqx.Module):
    """When a pair is close, and the rule that then serves it.

    `angles` are colatitude and longitude of the points of the ordinary grid.
    """

    rule: CloseRule
    angles: Float[Array, "source 2"]
    distance: float = eqx.field(static=True)

    def find(
        self,
        targets: Float[Array, "group target 3"],
        owners: Int[Array, " group"],
        points: Float[Array, "cell source 3"],
        *,
        period: Float[Array, ""],
        images: int,
        share: float,
    ) -> CloseTargets:
        """The close pairs of these targets and cells: `share` for each target, or 64 in all."""
        capacity = max(64, round(share * targets.shape[0] * targets.shape[1]))
        return CloseTargets(
            close_pairs(
                targets,
                owners,
                points,
                distance=self.distance,
                period=period,
                images=images,
                capacity=capacity,
            )
        )

    def prepared(
        self,
        close: CloseTargets,
        targets: Float[Array, "group target 3"],
        shapes: JaxShapes,
        period: Float[Array, ""],
    ) -> CloseTargets:
        """The same pairs with the double layer's matrices, for many densities."""
        pairs = close.pairs
        rows = self.rule.double_layer(
            pairs.points(targets, period), pairs.cell, self.angles[pairs.node], pairs.valid, shapes
        )
        return CloseTargets(pairs, rows)

    def velocity(
        self,
        close: CloseTargets,
        targets: Float[Array, "group target 3"],
        sources: Sources,
        period: Float[Array, ""],
    ) -> Float[Array, "group target 3"]:
        """Velocities by the close pairs."""
        pairs, surface = close.pairs, sources.surface
        assert surface is not None
        if close.rows is not None and surface.forces is None:
            assert surface.densities is not None
            found = _products(close.rows, surface.densities, pairs)
        else:
            found = self.rule.velocity(
                pairs.points(targets, period),
                pairs.cell,
                self.angles[pairs.node],
                pairs.valid,
                surface.shapes,
                surface.forces,
                surface.densities,
            )
        found = jnp.where(pairs.valid[:, None], found, 0.0)
        total = jnp.zeros_like(targets).at[pairs.group, pairs.target].add(found)
        return jnp.where(jax.lax.stop_gradient(pairs.overflow), jnp.nan, total)


def _products(
    rows: Float[Array, "pair 3 3 coefficient"], densities: JaxShapes, pairs: ClosePairs
) -> Float[Array, "pair 3"]:
    """What the matrices of the pairs make of their cells' densities, for those that are valid."""

    def add(number: Array, found: Array) -> Array:
        # What is beyond the last pair repeats it.
        pair = jnp.minimum(PAIRS_AT_ONCE * number + jnp.arange(PAIRS_AT_ONCE), listed - 1)
        part = jnp.einsum("pijk,pjk->pi", rows[pair], densities[pairs.cell[pair]])
        return found.at[pair].set(part)

    listed = jnp.minimum(pairs.count, len(rows))
    start = jnp.zeros(rows.shape[:2])
    return jax.lax.fori_loop(0, -(-listed // PAIRS_AT_ONCE), add, start)
