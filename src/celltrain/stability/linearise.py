"""The exact linear dynamics of a steady train, block by block.

A disturbance of the train's cells by exp(i q p), p the number of the cell, and of azimuthal number
m keeps its form: the derivative of the rates falls apart into one small matrix A_m(q) for each q
and m. With u = K[x, y] F(y), x the targets and y the sources,

    A_m(q) = d/ds own + d/dx outer(q = 0) + d/d(y, F) outer(q),

in which only the last part depends on q. One derivative carries all m at once, since the answers
separate: 3 M directions give everything. Directions are taken in batches of bounded size.

That is for a viscosity ratio lam of 1. For any other, u solves B(s) u = v(s), with
B = (1 + lam)/2 - (1 - lam) K (see `InteriorFlow`). In a steady train u is a rigid motion, and B u =
u for rigid motions whatever the shape, so dB u = 0 and the dynamics is

    A_m(q; lam) = B_m(q)^-1 A_m(q; 1),

one more small matrix for each q and m.
"""

from collections.abc import Callable, Sequence

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Complex, Float, Int

from celltrain.clock import timed
from celltrain.harmonics import azimuthal_basis, azimuthal_families
from celltrain.parameters import Train
from celltrain.train import TrainOperator, clearance, close_distance, train_operator

BATCH = 12

Directions = Float[Array, "direction 3 coefficient"]
Blocks = dict[int, Complex[np.ndarray, "wave size size"]]
Progress = Callable[[int, int], None]


def combined_directions(
    degree: int, azimuthal_numbers: Sequence[int]
) -> tuple[Float[np.ndarray, "direction 3 coefficient"], list[list[tuple[int, int]]]]:
    """Sums of basis members, one of each azimuthal number, and what each sum holds.

    **Returns:** the directions, and for each a list of (m, column of A_m). The swirl (m = 0) rides
    along with the radial members: it is odd under the mirror image, they are even.
    """
    directions: list[np.ndarray] = []
    contents: list[list[tuple[int, int]]] = []
    places: dict[tuple[int, int], int] = {}
    for m in azimuthal_numbers:
        column = 0
        for kind, family in enumerate(azimuthal_families(degree, m)):
            kind = 1 if m == 0 and kind == 2 else kind
            for row, member in enumerate(family):
                place = places.setdefault((kind, row), len(directions))
                if place == len(directions):
                    directions.append(np.zeros((3, degree * degree)))
                    contents.append([])
                directions[place] += member
                contents[place].append((m, column))
                column += 1
    return np.stack(directions), contents


def _mirror_parity(degree: int, m: int) -> Int[np.ndarray, " member"]:
    """+1 for members that are even under y -> -y, -1 for the swirl, which is odd."""
    even, rising, third = (len(family) for family in azimuthal_families(degree, m))
    return np.repeat([1, 1, -1 if m == 0 else 1], [even, rising, third])


def _batch(directions: Directions) -> int:
    """Directions at a time: of fewer than one batch, all, or whole batches would be compiled."""
    return min(BATCH, directions.shape[0])


@eqx.filter_jit
def _fixed_part(
    operator: TrainOperator, shape: Float[Array, "3 coefficient"], directions: Directions
) -> tuple[Directions, Directions, Directions]:
    """What does not depend on q: own and carried change of the rates, change of the force, and the
    change of the rates' volume-conserving part at fixed rates.
    """
    shapes = shape[None]
    forces = operator.forces(shapes)
    targets = operator.targets(shapes)

    def own(shapes: Array) -> tuple[Array, Array]:
        forces = operator.forces(shapes)
        return operator.own_velocity(operator.targets(shapes), shapes, forces), forces

    def outer(targets: Array) -> Array:
        return operator.outer_velocity(targets, shapes, forces)

    # Derivatives along x, y, z at every target at once: du = sum_k dx_k (du/dx_k).
    along = jnp.broadcast_to(jnp.eye(3)[:, None, None, None], (3, *targets.shape))
    velocity, gradient = jax.vmap(
        lambda step: jax.jvp(outer, (targets,), (step,)), out_axes=(None, 0)
    )(along)
    rates = operator.project(own(shapes)[0] + velocity)

    def change(direction: Array) -> tuple[Array, Array, Array]:
        step = (direction[None],)
        velocity, force = jax.jvp(own, (shapes,), step)[1]
        carried = jnp.einsum("crak,kcrai->crai", operator.targets(step[0]), gradient)
        turned = jax.jvp(lambda s: operator.conserve_volume(s, rates), (shapes,), step)[1]
        return operator.project(velocity + carried)[0], force[0], turned[0]

    return jax.lax.map(change, directions, batch_size=_batch(directions))


@eqx.filter_jit
def _wave_part(
    operator: TrainOperator,
    shape: Float[Array, "3 coefficient"],
    directions: Directions,
    force_changes: Directions,
) -> Complex[Array, "direction 3 coefficient"]:
    """The part of dv that the sources and their images with phase exp(i q p) give."""
    shapes = shape[None]
    forces, targets = operator.forces(shapes), operator.targets(shapes)

    def outer(shapes: Array, forces: Array) -> Array:
        return operator.outer_velocity(targets, shapes, forces)

    def change(pair: tuple[Array, Array]) -> Array:
        steps = (pair[0][None], pair[1][None])
        return operator.project(jax.jvp(outer, (shapes, forces), steps)[1])[0]

    pairs = (directions, force_changes)
    return jax.lax.map(change, pairs, batch_size=_batch(directions))


@eqx.filter_jit
def interior_action(
    operator: TrainOperator, shape: Float[Array, "3 coefficient"], directions: Directions
) -> Complex[Array, "direction 3 coefficient"]:
    """K u for motions u of each cell that change by exp(i q) from one cell to the next."""
    shapes = shape[None]
    interior, outer = operator.interior_flow(shapes), operator.outer_motion(shapes)

    def flow(motion: Array) -> Array:
        return interior.apply(outer, motion[None])[0]

    return jax.lax.map(flow, directions, batch_size=_batch(directions))


@eqx.filter_jit
def _conserve(
    operator: TrainOperator, shape: Float[Array, "3 coefficient"], changes: Array
) -> Array:
    """Changes of the rates without their component along the volume's gradient."""

    def one(change: Array) -> Array:
        return operator.conserve_volume(shape[None], change[None])[0]

    return jax.vmap(one)(changes)


def linear_action(
    still: TrainOperator,
    wave: TrainOperator,
    shape: Float[Array, "3 coefficient"],
    directions: Directions,
) -> Complex[Array, "direction 3 coefficient"]:
    """A(q) d for some directions d, at a viscosity ratio of 1 (see the module).

    **Arguments:** the operators for disturbances alike in all cells (`still`) and for those that
    change by exp(i q) (`wave`), for q = 0 also a quasi-periodic one.
    """
    fixed, force_changes, turned = _fixed_part(still, shape, directions)
    changes = _wave_part(wave, shape, directions, force_changes)
    return _conserve(wave, shape, fixed + changes) + turned


def linear_blocks(
    train: Train,
    shape: Float[np.ndarray, "3 coefficient"],
    phases: Float[np.ndarray, " phase"],
    azimuthal_numbers: Sequence[int],
    *,
    seconds: dict[str, float] | None = None,
    progress: Progress | None = None,
) -> Blocks:
    """Matrices A_m(q) of the linear dynamics about an axisymmetric steady train, in U/r0.

    **Arguments:**

    - `shape`: coefficients of one cell of the steady train.
    - `phases`: q, in radians per cell.
    - `azimuthal_numbers`: m >= 0; -m has the same matrix.
    - `seconds`: takes the time spent, under "linearise" and "compile".
    - `progress`: called with (phases done, all).

    **Returns:** for each m the matrices in the basis `azimuthal_basis(degree, m)`, one per q. The
    column of a disturbance holds its rate of change; `A_m(-q)` is the complex conjugate of
    `A_m(q)`.
    """
    degree = train.degree
    directions, contents = combined_directions(degree, azimuthal_numbers)
    bases = {m: azimuthal_basis(degree, m) for m in azimuthal_numbers}
    blocks: Blocks = {
        m: np.zeros((len(phases), len(basis), len(basis)), dtype=complex)
        for m, basis in bases.items()
    }
    # Whole batches only: a remainder would be compiled as a second program.
    missing = -len(directions) % BATCH
    base, steps = jnp.asarray(shape), jnp.pad(directions, ((0, missing), (0, 0), (0, 0)))
    ratio = train.flow.viscosity_ratio
    train = train.changed(viscosity_ratio=1.0)
    close = clearance(shape, train.period, train.radius) < close_distance(train)
    seconds = {} if seconds is None else seconds

    def assembled(answers: Array) -> dict[int, Complex[np.ndarray, "size size"]]:
        """Matrix for each m from what the combined directions give."""
        parts = {m: np.zeros((len(basis),) * 2, dtype=complex) for m, basis in bases.items()}
        for answer, members in zip(np.asarray(answers), contents, strict=False):
            for m, column in members:
                parity = _mirror_parity(degree, m)
                part = np.einsum("uik,ik->u", bases[m], answer)
                parts[m][:, column] = np.where(parity == parity[column], part, 0.0)
        return parts

    with timed(seconds, "linearise"):
        fixed, force_changes, turned = jax.block_until_ready(
            _fixed_part(train_operator(train, close=close), base, steps)
        )
    for number, q in enumerate(phases):
        with timed(seconds, "linearise"):
            operator = train_operator(train, phase=float(q), close=close)
            changes = _wave_part(operator, base, steps, force_changes)
            matrices = assembled(_conserve(operator, base, fixed + changes) + turned)
            if ratio != 1.0:
                interior = assembled(interior_action(operator, base, steps))
        for m, matrix in matrices.items():
            if ratio != 1.0:
                equation = 0.5 * (1.0 + ratio) * np.eye(len(matrix)) - (1.0 - ratio) * interior[m]
                matrix = np.linalg.solve(equation, matrix)
            blocks[m][number] = matrix
        if progress is not None:
            progress(number + 1, len(phases))
    return blocks
