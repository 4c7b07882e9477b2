"""The point of a surface that is nearest to a given point, and the distance with its sign.

On the unit sphere of the parameters, with u the frame's pole, (xi_1, xi_2) = alpha (cos beta, sin
beta) are coordinates without singularity. In them f = |x(u) - p|^2/2 has the gradient x_i . (x - p)
and the Hessian x_i . x_j + x_ij . (x - p), which follow from the coefficients seen from the pole;
only those of orders 0, 1 and 2 take part. Each step moves the pole.

`NearestPointSearch.of_valid` runs the iteration inside programs of JAX, for as many pairs as are
valid: by a compiled loop where these serve (`compiled.nearest_loop`), and by the formulas here
elsewhere. `nearest_points` runs the same loop outside programs.
"""

import math

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from celltrain.compiled import compiled_or_plain, loop
from celltrain.compiled.loops import NEAREST
from celltrain.compiled.nearest_search import (
    FOUND,
    LONGEST_STEP,
    MAX_ITERATIONS,
    SHORTEST_STEP,
)
from celltrain.compiled.on_host import call_on_host
from celltrain.harmonics import Shapes, degrees_and_orders
from celltrain.harmonics.jax_shapes import JaxShapes
from celltrain.harmonics.rotation import PoleRotation, pole_rotation
from celltrain.runtime import constant

# Pairs at once; with many more their coefficients leave the cache.
CHUNK = 64

# Count of steps; pole, jet there, squared distance, shortening of steps, end of each pair.
State = tuple[Array, Array, Array, Array, Array, Array]


class NearestPoints(eqx.Module):
    """Where surfaces are nearest to points: one pair of them each.

    `theta`, `phi`: the point of the surface, on the parameter sphere. `distance`: from it, in r0,
    negative inside the cell. `stretch`: largest length of the surface for a unit of angle there.
    `converged`: the last step was below 1e-9 of a radian.
    """

    theta: Float[Array, " pair"]
    phi: Float[Array, " pair"]
    distance: Float[Array, " pair"]
    stretch: Float[Array, " pair"]
    converged: Bool[Array, " pair"]


class NearestPointSearch(eqx.Module):
    """Newton's method for the nearest point, for shapes below one degree."""

    rotation: PoleRotation
    jet: Float[Array, "6 coefficient"]

    def __call__(
        self,
        points: Float[Array, "pair 3"],
        shapes: Float[Array, "pair 3 coefficient"],
        guesses: Float[Array, "pair 2"],
    ) -> NearestPoints:
        """Nearest point of each shape to its point, from guesses (theta, phi).

        A step that does not come closer is undone and shortened to a quarter, so the result is
        never farther than the guess. It finds a local minimum: the guess decides which. Derivatives
        do not pass through.
        """
        points, shapes, guesses = jax.lax.stop_gradient((points, shapes, guesses))

        def at(pole: Array) -> tuple[Array, Array]:
            theta, phi = pole[:, 0], pole[:, 1]
            seen = self.rotation.seen_from_equator(shapes, theta, phi)
            jet = jnp.einsum("jk,pik->pji", self.jet, seen)
            away = jet[:, 0] - points
            return jet, jnp.sum(away * away, axis=-1)

        def step(state: State) -> State:
            count, pole, jet, square, shortening, _ = state
            move = _newton_step(jet, jet[:, 0] - points) * shortening[:, None]
            trial = _moved_pole(pole, move)
            trial_jet, trial_square = at(trial)
            closer = trial_square <= square
            return (
                count + 1,
                jnp.where(closer[:, None], trial, pole),
                jnp.where(closer[:, None, None], trial_jet, jet),
                jnp.where(closer, trial_square, square),
                jnp.where(closer, 1.0, 0.25 * shortening),
                jnp.sqrt(jnp.sum(move * move, axis=-1)) < SHORTEST_STEP,
            )

        def goes_on(state: State) -> Array:
            return (state[0] < MAX_ITERATIONS) & ~jnp.all(state[-1])

        jet, square = at(guesses)
        ones = jnp.ones_like(square)
        start = (jnp.array(0), guesses, jet, square, ones, ones < 0.0)
        _, pole, jet, square, _, converged = jax.lax.while_loop(goes_on, step, start)
        first, second = jet[:, 1], jet[:, 2]
        outside = jnp.sum(jnp.cross(first, second) * (points - jet[:, 0]), axis=-1) >= 0.0
        distance = jnp.sqrt(square)
        return NearestPoints(
            theta=pole[:, 0],
            phi=pole[:, 1],
            distance=jnp.where(outside, distance, -distance),
            stretch=_largest_stretch(first, second),
            converged=converged,
        )

    def of_valid(
        self,
        points: Float[Array, "pair 3"],
        cells: Int[Array, " pair"],
        shapes: JaxShapes,
        guesses: Float[Array, "pair 2"],
        valid: Bool[Array, " pair"],
    ) -> NearestPoints:
        """Nearest point of each valid pair's cell; the cost follows the number of these.

        The distance of pairs that are not valid is infinite. Derivatives do not pass through.
        """
        given = jax.lax.stop_gradient((points, shapes, guesses))

        def compiled(search: NearestPointSearch, cells: Array, valid: Array, *rest: Array) -> Array:
            del search
            points, shapes, guesses = rest
            shape = (len(points), FOUND)
            return loop(NEAREST, shape, points, cells.astype(int), shapes, guesses, valid)

        plain = NearestPointSearch._in_chunks
        found = compiled_or_plain(compiled, plain, self, cells, valid, *given)
        theta, phi, distance, stretch, converged = found.T
        return NearestPoints(theta, phi, distance, stretch, converged > 0.0)

    def _in_chunks(
        self, cells: Array, valid: Array, points: Array, shapes: Array, guesses: Array
    ) -> Float[Array, "pair found"]:
        """What the loop gives, by the formulas."""
        order = jnp.argsort(~valid)
        count = jnp.sum(valid)

        def add(number: Array, found: Array) -> Array:
            place = CHUNK * number + jnp.arange(CHUNK)
            # What is beyond the last pair repeats it.
            pair = order[jnp.minimum(place, count - 1)]
            here = self(points[pair], shapes[cells[pair]], guesses[pair])
            columns = (here.theta, here.phi, here.distance, here.stretch, here.converged)
            return found.at[pair].set(jnp.stack(columns, axis=-1))

        nothing = jnp.array([0.0, 0.0, jnp.inf, 1.0, 1.0])
        start = jnp.broadcast_to(nothing, (len(points), FOUND))
        return jax.lax.fori_loop(0, -(-count // CHUNK), add, start)


def nearest_points(
    points: Float[np.ndarray, "point 3"],
    cells: Int[np.ndarray, " point"],
    shapes: Shapes,
    guesses: Float[np.ndarray, "point 2"],
) -> tuple[Float[np.ndarray, "point 2"], Float[np.ndarray, " point"]]:
    """Nearest points (theta, phi) of cells to points, and the distances, negative inside.

    For points outside compiled programs, any number of them.

    **Arguments:** `cells`: that of each point; `guesses`: where the search begins.
    """
    if len(points) == 0:
        return np.zeros((0, 2)), np.zeros(0)
    at, of, near = (np.asarray(each, float) for each in (points, shapes, guesses))
    given = (at, cells.astype(np.int64), of, near, np.ones(len(at), dtype=bool))
    found = call_on_host(NEAREST, (len(at), FOUND), *given)
    return found[:, :2], found[:, 2]


def _dot(a: Array, b: Array) -> Array:
    return jnp.sum(a * b, axis=-1)


def _newton_step(
    jet: Float[Array, "pair 6 3"], away: Float[Array, "pair 3"]
) -> Float[Array, "pair 2"]:
    """Newton's step where the Hessian is positive, Gauss and Newton's where it is not."""
    first, second = jet[:, 1], jet[:, 2]
    gradient = jnp.stack([_dot(first, away), _dot(second, away)], axis=-1)
    metric = (_dot(first, first), _dot(first, second), _dot(second, second))
    bend = (_dot(jet[:, 3], away), _dot(jet[:, 4], away), _dot(jet[:, 5], away))
    full = (metric[0] + bend[0], metric[1] + bend[1], metric[2] + bend[2])
    # Far from positive: a quarter of the metric's determinant would already double the step.
    area = metric[0] * metric[2] - metric[1] ** 2
    convex = (full[0] * full[2] - full[1] ** 2 > 0.05 * area) & (full[0] + full[2] > 0.0)
    a, b, c = (jnp.where(convex, whole, part) for whole, part in zip(full, metric, strict=True))
    step = -jnp.stack(
        [c * gradient[:, 0] - b * gradient[:, 1], a * gradient[:, 1] - b * gradient[:, 0]], axis=-1
    )
    step = step / (a * c - b * b)[:, None]
    length = jnp.sqrt(jnp.sum(step * step, axis=-1, keepdims=True))
    return step * jnp.minimum(1.0, LONGEST_STEP / jnp.maximum(length, 1e-300))


def _moved_pole(
    pole: Float[Array, "pair 2"], move: Float[Array, "pair 2"]
) -> Float[Array, "pair 2"]:
    """The pole (theta, phi) moved by (xi_1, xi_2) along a great circle."""
    theta, phi = pole[:, 0], pole[:, 1]
    angle = jnp.sqrt(jnp.sum(move * move, axis=-1))
    ratio = jnp.sinc(angle / math.pi)
    across, along, up = ratio * move[:, 0], ratio * move[:, 1], jnp.cos(angle)
    x = jnp.cos(theta) * across + jnp.sin(theta) * up
    z = jnp.cos(theta) * up - jnp.sin(theta) * across
    turned = phi + jnp.arctan2(along, x)
    return jnp.stack([jnp.arctan2(jnp.hypot(x, along), z), turned], axis=-1)


def _largest_stretch(
    first: Float[Array, "pair 3"], second: Float[Array, "pair 3"]
) -> Float[Array, " pair"]:
    mean = 0.5 * (_dot(first, first) + _dot(second, second))
    half = 0.5 * (_dot(first, first) - _dot(second, second))
    return jnp.sqrt(mean + jnp.hypot(half, _dot(first, second)))


def nearest_point_search(degree: int) -> NearestPointSearch:
    """The search for shapes with the harmonics below `degree`."""
    rotation = pole_rotation(degree)
    n, order = degrees_and_orders(degree)
    scale = np.sqrt((2 * n + 1) / (4.0 * math.pi))
    slope = scale * np.sqrt(0.5 * n * (n + 1))
    level = -0.5 * scale * n * (n + 1)
    # sqrt(2) P_n2 = scale sqrt(2 (n + 2)(n + 1) n (n - 1))/8 alpha^2 + ...
    twist = 0.25 * scale * np.sqrt(2.0 * (n + 2) * (n + 1) * n * np.maximum(n - 1, 0))
    zero = np.zeros_like(scale)
    at_pole = np.stack(
        [
            np.where(order == 0, scale, zero),
            np.where(order == 1, slope, zero),
            np.where(order == -1, slope, zero),
            np.where(order == 0, level, np.where(order == 2, twist, zero)),
            np.where(order == -2, twist, zero),
            np.where(order == 0, level, np.where(order == 2, -twist, zero)),
        ]
    )
    return NearestPointSearch(rotation, constant(at_pole @ np.asarray(rotation.quarter).T))
