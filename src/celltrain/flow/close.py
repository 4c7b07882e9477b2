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
bounded, and the cost follows the number of pairs.
"""

import math
from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from celltrain.flow.polar import PolarRule, density_rows, polar_velocity
from celltrain.harmonics.jax_shapes import JaxShapes
from celltrain.harmonics.polar import PolarTables, polar_tables
from celltrain.proximity.nearest import (
    NearestPoints,
    NearestPointSearch,
    nearest_point_search,
)
from celltrain.runtime import constant

CHUNK = 16
UNIFORMITY = 8.0
CLOSEST = 1e-4


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
        channels = (shapes, forces, densities)

        def found(rule: PolarRule, poles: Array, pair: Array) -> Array:
            chosen = (None if each is None else each[cells[pair]] for each in channels)
            return polar_velocity(rule, poles, points[pair], *chosen)

        nearest = self.nearest.of_valid(points, cells, shapes, guesses, valid)
        return self._over_levels(found, nearest, valid, jnp.zeros_like(points))

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

        def found(rule: PolarRule, poles: Array, pair: Array) -> Array:
            return density_rows(rule, poles, points[pair], shapes[cells[pair]])

        nearest = self.nearest.of_valid(points, cells, shapes, guesses, valid)
        start = jnp.zeros((points.shape[0], 3, 3, shapes.shape[-1]))
        return self._over_levels(found, nearest, valid, start)

    def _over_levels(
        self,
        found: Callable[[PolarRule, Array, Array], Array],
        nearest: NearestPoints,
        valid: Bool[Array, " pair"],
        start: Array,
    ) -> Array:
        """What is found for the valid pairs added to `start`, in chunks of pairs of one level."""
        poles = jnp.stack([nearest.theta, nearest.phi], axis=-1)
        level = self._level(nearest, valid)
        order = jnp.argsort(level)
        bounds = jnp.searchsorted(level[order], jnp.arange(self.levels.size + 1))
        chunks = -(-jnp.diff(bounds) // CHUNK)
        before = jnp.cumsum(chunks) - chunks

        def add(number: Array, total: Array) -> Array:
            here = jnp.searchsorted(before + chunks, number, side="right")
            place = bounds[here] + CHUNK * (number - before[here]) + jnp.arange(CHUNK)
            pair = order[jnp.minimum(place, order.size - 1)]
            tables, weights, areas = jax.tree.map(
                lambda leaf: leaf[here], (self.tables, self.weights, self.areas)
            )
            rotation = self.nearest.rotation
            rule = PolarRule(self.parameter, rotation, tables, weights, areas)
            part = found(rule, poles[pair], pair)
            inside = (place < bounds[here + 1]).reshape(-1, *(1,) * (part.ndim - 1))
            return total.at[pair].add(jnp.where(inside, part, 0.0))

        return jax.lax.fori_loop(0, jnp.sum(chunks), add, start)

    def _level(self, nearest: NearestPoints, valid: Array) -> Int[Array, " pair"]:
        """Number of the level of each pair; that of pairs that are not valid is one too many."""
        scaled = jnp.abs(nearest.distance) / nearest.stretch
        level = jnp.sum(scaled[:, None] < self.levels, axis=1)
        return jnp.where(valid, jnp.minimum(level, self.levels.size - 1), self.levels.size)


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
