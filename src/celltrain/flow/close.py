"""Velocity at points close to a surface, by polar quadrature about the surface's nearest point.

With alpha the angle on the parameter sphere from the point nearest to the target, the distance to
the target behaves as sqrt(d^2 + h^2 alpha^2), h the local stretch: the kernels are smooth on the
scale eps = d/h near alpha = 0, and on that of the shape elsewhere. The radial nodes are
Gauss-Legendre's in t, with

    t = (asinh(alpha/eps) + k alpha)/(asinh(pi/eps) + k pi),   0 < alpha < pi,

so their spacing is that of sinh(t) close to the target, which takes only O(log(1/eps)) nodes, and
uniform beyond alpha = 1/k. The azimuth beta is uniform.

Tables of harmonics at the nodes exist for distances a factor of two apart. Pairs are sorted by that
level, and evaluated in chunks of one level and a fixed size, as many as there are pairs: memory is
bounded, and the cost follows the number of pairs. What forces give is a compiled loop where loops
serve.
"""

import math
from collections.abc import Callable
from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from celltrain.compiled import compiled_or_plain, loop
from celltrain.compiled.loops import CLOSE_FORCES
from celltrain.flow.polar import PolarRule, density_rows, polar_velocity
from celltrain.harmonics.jax_shapes import JaxShapes
from celltrain.harmonics.polar import PolarTables, polar_tables
from celltrain.proximity.nearest import NearestPointSearch, nearest_point_search
from celltrain.runtime import constant

CHUNK = 16
UNIFORMITY = 8.0
CLOSEST = 1e-4


class LevelledPairs(eqx.Module):
    """Pairs of a point and a cell, sorted by the level of their distance.

    `poles`: (theta, phi) of the cell's point that is nearest. `order`: numbers of the pairs, level
    by level, which begin at `bounds`; those that are not valid last.
    """

    cells: Int[Array, " pair"]
    poles: Float[Array, "pair 2"]
    valid: Bool[Array, " pair"]
    order: Int[Array, " pair"]
    bounds: Int[Array, " bound"]


class CloseRule(eqx.Module):
    """Graded polar rules, one for each level of distance over stretch."""

    parameter: float = eqx.field(static=True)
    nearest: NearestPointSearch
    levels: Float[Array, " level"]
    tables: PolarTables
    weights: Float[Array, "level radial"]
    areas: Float[Array, "level radial"]

    def velocity(
        self,
        points: Float[Array, "pair 3"],
        cells: Int[Array, " pair"],
        guesses: Float[Array, "pair 2"],
        valid: Bool[Array, " pair"],
        shapes: JaxShapes,
        forces: JaxShapes | None,
        densities: JaxShapes | None,
    ) -> Float[Array, "pair 3"]:
        """(1/8 pi) int G_near F dOmega + (1/8 pi) int T_near(y - x)_ijk w_j n_k dS, in U.

        Zero where a pair is not valid. Derivatives hold the rule (its pole and level) fixed, since
        the integral does not depend on it; forward derivatives only.

        **Arguments:**

        - `points`: targets, in r0, where the images of the cells are brought back to the cells.
        - `cells`: the cell of each pair, whose surface is integrated.
        - `guesses`: colatitude and longitude near the cell's point nearest to the target.
        - `forces`: coefficients of the force per solid angle, in mu U r0.
        - `densities`: coefficients of w, in U. The integral of what is absent is not computed.
        """
        pairs = self._pairs(points, cells, guesses, valid, shapes)
        if densities is None:
            assert forces is not None
            return force_velocity(self, pairs, points, shapes, forces)
        return self._over_levels(polar_velocity, pairs, points, (shapes, forces, densities), (3,))

    def double_layer(
        self,
        points: Float[Array, "pair 3"],
        cells: Int[Array, " pair"],
        guesses: Float[Array, "pair 2"],
        valid: Bool[Array, " pair"],
        shapes: JaxShapes,
    ) -> Float[Array, "pair 3 3 coefficient"]:
        """Matrices from the coefficients of w on each pair's cell to the second integral above.

        For many densities on the same shapes: they cost about as much as two of its evaluations.
        Arguments as for `velocity`; zero where a pair is not valid.
        """
        pairs = self._pairs(points, cells, guesses, valid, shapes)
        return self._over_levels(density_rows, pairs, points, (shapes,), (3, 3, shapes.shape[-1]))

    def _pairs(
        self,
        points: Float[Array, "pair 3"],
        cells: Int[Array, " pair"],
        guesses: Float[Array, "pair 2"],
        valid: Bool[Array, " pair"],
        shapes: JaxShapes,
    ) -> LevelledPairs:
        near = self.nearest.of_valid(points, cells, shapes, guesses, valid)
        scaled = jnp.abs(near.distance) / near.stretch
        level = jnp.minimum(jnp.sum(scaled[:, None] < self.levels, axis=1), self.levels.size - 1)
        level = jnp.where(valid, level, self.levels.size)
        order = jnp.argsort(level)
        bounds = jnp.searchsorted(level[order], jnp.arange(self.levels.size + 1))
        poles = jnp.stack([near.theta, near.phi], axis=-1)
        return LevelledPairs(cells, poles, valid, order, bounds)

    def _over_levels(
        self,
        integral: Callable[..., Array],
        pairs: LevelledPairs,
        points: Float[Array, "pair 3"],
        channels: tuple[JaxShapes | None, ...],
        shape: tuple[int, ...],
    ) -> Float[Array, "pair ..."]:
        """The integral of each valid pair, in chunks of pairs of one level; zero elsewhere.

        **Arguments:** `integral`: of a polar rule, poles, points and the channels of their cells;
        `shape`: of what it gives for one pair.
        """
        chunks = -(-jnp.diff(pairs.bounds) // CHUNK)
        before = jnp.cumsum(chunks) - chunks

        def add(number: Array, total: Array) -> Array:
            here = jnp.searchsorted(before + chunks, number, side="right")
            place = pairs.bounds[here] + CHUNK * (number - before[here]) + jnp.arange(CHUNK)
            pair = pairs.order[jnp.minimum(place, pairs.order.size - 1)]
            tables, weights, areas = jax.tree.map(
                lambda leaf: leaf[here], (self.tables, self.weights, self.areas)
            )
            rule = PolarRule(self.parameter, self.nearest.rotation, tables, weights, areas)
            cells = pairs.cells[pair]
            chosen = (None if each is None else each[cells] for each in channels)
            part = integral(rule, pairs.poles[pair], points[pair], *chosen)
            inside = (place < pairs.bounds[here + 1]).reshape(-1, *(1,) * len(shape))
            return total.at[pair].add(jnp.where(inside, part, 0.0))

        start = jnp.zeros((points.shape[0], *shape))
        return jax.lax.fori_loop(0, jnp.sum(chunks), add, start)


@jax.custom_jvp
def force_velocity(
    rule: CloseRule,
    pairs: LevelledPairs,
    points: Float[Array, "pair 3"],
    shapes: JaxShapes,
    forces: JaxShapes,
) -> Float[Array, "pair 3"]:
    """(1/8 pi) int G_near F dOmega of each pair, by a compiled loop where there is one.

    Derivatives are those of the formula.
    """
    return compiled_or_plain(_force_loop, _force_formula, rule, pairs, points, shapes, forces)


@force_velocity.defjvp
def _force_velocity_jvp(primals, tangents):  # type: ignore[no-untyped-def]
    rule, pairs, *inputs = primals
    formula = partial(_force_formula, rule, pairs)
    _, moved = jax.jvp(formula, tuple(inputs), tuple(tangents[2:]))
    return force_velocity(rule, pairs, *inputs), moved


def _force_loop(
    rule: CloseRule, pairs: LevelledPairs, points: Array, shapes: JaxShapes, forces: JaxShapes
) -> Array:
    found = loop(
        CLOSE_FORCES,
        points.shape,
        points,
        pairs.poles,
        pairs.cells.astype(int),
        jnp.concatenate([shapes, forces], axis=1),
        pairs.order.astype(int),
        pairs.bounds.astype(int),
        rule.nearest.rotation.quarter,
        rule.weights,
        rule.tables.latitude,
        # That of all levels.
        rule.tables.longitude[0],
        jnp.asarray(rule.parameter),
    )
    return jnp.where(pairs.valid[:, None], found, 0.0)


def _force_formula(
    rule: CloseRule, pairs: LevelledPairs, points: Array, shapes: JaxShapes, forces: JaxShapes
) -> Array:
    """What `force_velocity` computes."""
    return rule._over_levels(polar_velocity, pairs, points, (shapes, forces, None), (3,))


def close_rule(
    degree: int,
    *,
    parameter: float,
    farthest: float,
    radial: int | None = None,
    azimuthal: int | None = None,
) -> CloseRule:
    """Rules for shapes below `degree`, with xi = `parameter` (0: the kernels in free space).

    With the usual numbers of nodes, 32 + M by 2 (16 + M), the largest errors are 1e-6 in the single
    layer and 3e-5 (M = 6) or 4e-6 (M = 12, 16) in the double layer, at any distance from 0.3 to
    1e-4 r0, outside or inside; their medians are ten to a hundred times smaller. That is relative
    to the largest velocity in free space, on the biconcave cell and deformed ones, for densities
    with all degrees alike, the roughest there are. At sharp folds (radius of curvature below 0.1
    r0) it may be 1e-4 and 1e-3. A second part of the same surface that is as close to the target as
    the nearest one is not resolved better than by a polar rule about a point of the surface.

    **Arguments:** `farthest`: largest distance, in r0, for which the rule is used; `radial`,
    `azimuthal`: numbers of nodes.
    """
    radial = 32 + degree if radial is None else radial
    azimuthal = 2 * (16 + degree) if azimuthal is None else azimuthal
    count = 1 + max(0, math.ceil(math.log2(farthest / CLOSEST)))
    levels = farthest * 0.5 ** np.arange(count)
    beta = (np.arange(azimuthal) + 0.5) * 2.0 * np.pi / azimuthal
    tables, weights, areas = [], [], []
    for level in levels:
        alpha, weight = graded_nodes(0.8 * level, radial)
        tables.append(polar_tables(degree, alpha, beta))
        # Over 8 pi, times the step 2 pi/azimuthal in beta.
        areas.append(weight / (4.0 * azimuthal))
        weights.append(areas[-1] * np.sin(alpha))
    return CloseRule(
        parameter=parameter,
        nearest=nearest_point_search(degree),
        levels=constant(levels),
        tables=jax.tree.map(lambda *leaves: constant(np.stack(leaves)), *tables),
        weights=constant(np.stack(weights)),
        areas=constant(np.stack(areas)),
    )


def graded_nodes(
    scale: float, count: int
) -> tuple[Float[np.ndarray, " radial"], Float[np.ndarray, " radial"]]:
    """Nodes alpha in (0, pi), graded to alpha = 0 on the given scale eps, and their weights."""
    nodes, gauss = np.polynomial.legendre.leggauss(count)
    length = math.asinh(math.pi / scale) + UNIFORMITY * math.pi
    goal = 0.5 * length * (nodes + 1.0)
    low, high = np.zeros(count), np.full(count, math.pi)
    for _ in range(60):
        alpha = 0.5 * (low + high)
        below = np.arcsinh(alpha / scale) + UNIFORMITY * alpha < goal
        low, high = np.where(below, alpha, low), np.where(below, high, alpha)
    return alpha, 0.5 * length * gauss / (1.0 / np.hypot(alpha, scale) + UNIFORMITY)
