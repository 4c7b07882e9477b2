"""Stokes flow in unbounded space driven by surface densities, with a linear background.

    u(x) = (1/8 pi) sum_s [ G(x - y_s) f_s + T(y_s - x) D_s/2 ] + A x

in units of U and mu, with the kernels in free space, D = w n + n w (see `Sources`) and the velocity
gradient A, A_ij = du_i/dx_j. All pairs are summed: that is meant for few cells.
"""

import math
from collections.abc import Callable

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from celltrain.flow.cell_sums import CELL_SHARE, CellSums
from celltrain.flow.close_targets import CloseEvaluation
from celltrain.flow.sources import Sources
from celltrain.flow.surrounding_flow import CloseTargetSets, SurroundingFlow
from celltrain.harmonics.jax_shapes import JaxShapes


class UnboundedFlow(SurroundingFlow):
    """Flow in unbounded space; `gradient` is A, in U/r0."""

    near: CellSums
    gradient: Float[Array, "3 3"]

    @property
    def near_parameter(self) -> float:
        """See `SurroundingFlow`."""
        return self.near.parameter

    def velocity(
        self,
        targets: Float[Array, "group ring azimuth 3"],
        owners: Int[Array, " group"],
        sources: Sources,
        *,
        close_targets: CloseTargetSets | None = None,
        background: bool = True,
    ) -> Float[Array, "group ring azimuth 3"]:
        """See `SurroundingFlow`."""
        if close_targets is None and sources.surface is not None:
            close_targets = self.close_targets(targets, owners, sources.points)
        groups = targets.reshape(targets.shape[0], -1, 3)
        by_cells = None if close_targets is None else close_targets[0]
        total = self.near.velocity(groups, owners, sources, by_cells).reshape(targets.shape)
        return total + targets @ self.gradient.T if background else total

    def close_targets(
        self,
        targets: Float[Array, "group ring azimuth 3"],
        owners: Int[Array, " group"],
        points: Float[Array, "cell source_ring source_azimuth 3"],
        *,
        shapes: JaxShapes | None = None,
    ) -> CloseTargetSets | None:
        """See `SurroundingFlow`."""
        groups = targets.reshape(targets.shape[0], -1, 3)
        found = self.near.close_targets(groups, owners, points, CELL_SHARE, shapes=shapes)
        return None if found is None else (found,)


def unbounded_flow(
    gradient: Float[np.ndarray, "3 3"],
    *,
    close: Callable[[float], CloseEvaluation] | None = None,
    coarse_beyond: float = math.inf,
) -> UnboundedFlow:
    """Unbounded space with a velocity gradient, in U/r0.

    **Arguments:** `close`, `coarse_beyond`: as for `periodic_tube`.
    """
    free_space = 0.0
    return UnboundedFlow(
        near=CellSums(
            parameter=free_space,
            cutoff=math.inf,
            # Nothing recurs: without images no period counts.
            period=jnp.ones(()),
            images=0,
            close=None if close is None else close(free_space),
            coarse_beyond=coarse_beyond,
        ),
        gradient=jnp.asarray(gradient, dtype=float),
    )
