"""A search for further steady trains of the same parameters, by deflation.

A steady train that is known is the one which the flow reaches from rest, or its branch's; others
may exist. From each of several first guesses Newton's method with all known trains deflated (see
`deflation`) looks for another, and again from the same guess when it has found one. Nothing proves
that there are no more trains: what a search says is what it tried and what it found.

Guesses are, in this order: the resting shape, the cell bent forwards and backwards (z + b cos^2
theta), the known one pointing the other way, the trains at other packings, and the known one
disturbed in its lower harmonics. A root whose meridian crosses itself or the axis is the shape of
no cell; it is deflated, too, and counted apart.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import jax.numpy as jnp
import numpy as np
import xarray as xr
from jaxtyping import Float

from celltrain.continuation.arclength import Evaluation, NoSolution, Problem, Unknowns
from celltrain.continuation.deflation import Tries, deflated_newton
from celltrain.continuation.equations import evaluate_steady, to_unknowns
from celltrain.harmonics import axisymmetric_basis, coefficient_index, degrees_and_orders
from celltrain.parameters import CaseError, Train
from celltrain.stability import stability
from celltrain.steady import Base, NotConverged, steady
from celltrain.steady.solve import comes_close
from celltrain.steady.system import SteadySystem, steady_system
from celltrain.train import meridian, resting_shapes

#: Tries unless told otherwise: one for each guess, and some for what is found.
MOST_TRIES = 16
# Factors of the packing at which other trains are guesses.
PACKINGS = (0.7, 1.4)
# Displacements of the poles (r0) of a bent cell, and sizes of random disturbances (r0).
BENT = (0.6, -0.6, 1.2, -1.2)
DISTURBED = (0.2, 0.2, 0.5, 0.5)
# Harmonics up to this degree are disturbed.
LOWEST = 5
# Two trains nearer than this, in a/sqrt(4 pi), are the same (r0).
SAME = 1e-4

Shape = Float[np.ndarray, "3 coefficient"]


@dataclass(frozen=True)
class SearchTry:
    """One try: the guess, how it ended, and the train if it has led to one."""

    guess: str
    steps: int
    outcome: str
    residual: float
    base: Base | None


@dataclass(frozen=True)
class FoundTrain:
    """A further steady train, the guess that led to it, its distance from the known one in r0.

    `axisymmetric_rate` is the largest growth rate (U/r0) of its axisymmetric disturbances (m = 0,
    the waves of the train's N cells), neutral ones set aside.
    """

    base: Base
    guess: str
    distance: float
    axisymmetric_rate: float


@dataclass(frozen=True)
class BranchSearch:
    """What was tried and what was found beside a known train."""

    known: Base
    tries: tuple[SearchTry, ...]
    found: tuple[FoundTrain, ...]

    @property
    def statement(self) -> str:
        """The outcome in words."""
        count = len(self.tries)
        guesses = len({each.guess for each in self.tries})
        tried = f"{count} {'try' if count == 1 else 'tries'}"
        tried += f" from {guesses} {'guess' if guesses == 1 else 'guesses'}"
        if not self.found:
            return f"no further steady train was found in {tried}"
        number = len(self.found)
        trains = "train was" if number == 1 else "trains were"
        return f"{number} further steady {trains} found in {tried}"

    def to_dataset(self) -> xr.Dataset:
        """The known train and those found, first the known one, ready for netCDF."""
        bases = [self.known, *(each.base for each in self.found)]
        columns = {
            "cell_velocity": ("U", [base.cell_velocity for base in bases]),
            "gap": ("r0", [base.gap for base in bases]),
            "effective_viscosity": ("mu", [base.effective_viscosity for base in bases]),
            "residual": ("U", [base.residual for base in bases]),
            "distance": ("r0", [0.0, *(each.distance for each in self.found)]),
            "axisymmetric_rate": (
                "U/r0",
                [math.nan, *(each.axisymmetric_rate for each in self.found)],
            ),
        }
        data = {
            name: xr.Variable("train", values, {"units": unit})
            for name, (unit, values) in columns.items()
        }
        shapes = np.stack([base.coefficients for base in bases])
        dims = ("train", "axis", "coefficient")
        data["coefficients"] = xr.Variable(dims, shapes, {"units": "r0"})
        return xr.Dataset(
            data,
            attrs={
                "title": "steady trains of the same parameters",
                "case": self.known.train.to_toml(),
                "statement": self.statement,
            },
        )


def search_trains(
    known: Base,
    *,
    guesses: Sequence[tuple[str, Shape]] | None = None,
    most_tries: int = MOST_TRIES,
    tries: Tries | None = None,
    progress: Callable[[SearchTry], None] | None = None,
) -> BranchSearch:
    """Further steady trains of the parameters of a known one, or the statement that none was found.

    **Arguments:**

    - `known`: a steady train; its number of cells matters for the growth rates only.
    - `guesses`: names and axisymmetric shapes to begin from, those of the module if not given.
    - `most_tries`: bound on the number of tries; each takes up to `tries.most_steps` steps, a step
      a fraction of a second at degree 12.
    - `progress`: called with every try.

    **Raises:** `CaseError` for a number of tries that is not allowed.
    """
    check_tries(most_tries)
    tries = Tries() if tries is None else tries
    train = known.train
    problem = steady_problem(train)
    system = steady_system(train, close=False)
    first = to_unknowns(system, known.coefficients)
    roots, done, found = [first], list[SearchTry](), list[FoundTrain]()
    for name, shape in first_guesses(known) if guesses is None else guesses:
        while len(done) < most_tries:
            start = to_unknowns(system, _with_volume(system, shape))
            each, root = _try(problem, name, start, known, roots, tries)
            done.append(each)
            if progress is not None:
                progress(each)
            if root is None:
                break
            roots.append(root)
            if each.base is not None:
                found.append(_describe(each.base, name, float(np.linalg.norm(root - first))))
    return BranchSearch(known, tuple(done), tuple(found))


def check_tries(most_tries: int) -> None:
    """See to it that there is something to try.

    **Raises:** `CaseError` if not.
    """
    if most_tries < 1:
        raise CaseError(f"most_tries = {most_tries} is not allowed; allowed: whole numbers >= 1")


def first_guesses(known: Base) -> Iterator[tuple[str, Shape]]:
    """The guesses of the module with their names; trains at other packings as they are needed."""
    train, shape = known.train, known.coefficients
    degree = train.degree
    n, _ = degrees_and_orders(degree)
    rest = resting_shapes(train, 1)[0]
    yield "the resting shape", rest
    for bend in BENT:
        bent = rest.copy()
        # z of Y_20 at the pole, less that at the equator, is the bend.
        bent[2, coefficient_index(2, 0)] += bend / (1.5 * math.sqrt(5.0 / (4.0 * math.pi)))
        yield f"the resting shape bent by {bend:+g} r0", bent
    yield "the known one pointing the other way", reversed_shape(shape)
    for factor in PACKINGS:
        packing = factor * train.packing
        try:
            other = steady(train.changed(packing=packing), start=known, estimate_error=False)
        except (CaseError, NotConverged):
            continue
        yield f"the train at packing {packing:.3g}", other.coefficients
    random = np.random.default_rng(0)
    basis = axisymmetric_basis(degree)[1:]
    low = [bool((np.abs(each).max(axis=0) * (n > LOWEST)).max() == 0.0) for each in basis]
    for number, size in enumerate(DISTURBED, 1):
        amounts = random.normal(size=len(basis)) * low
        amounts *= size * math.sqrt(4.0 * math.pi) / np.linalg.norm(amounts)
        disturbance = np.tensordot(amounts, basis, axes=1)
        yield f"the known one disturbed by {size:g} r0 (draw {number})", shape + disturbance


def reversed_shape(shape: Shape) -> Shape:
    """The mirror image z -> -z of an axisymmetric shape, front pole to rear pole."""
    # Y_nm(pi - theta) = (-1)^(n + m) Y_nm(theta), and z changes its sign.
    n, order = degrees_and_orders(math.isqrt(shape.shape[-1]))
    parity = np.where((n + order) % 2 == 0, 1.0, -1.0)
    return shape * parity * np.array([[1.0], [1.0], [-1.0]])


def is_a_cell(shape: Shape) -> bool:
    """Whether the meridian of an axisymmetric shape crosses neither the axis nor itself."""
    radius, axial = meridian(shape, 201)
    if (radius[1:-1] <= 0.0).any():
        return False
    points = np.stack([radius, axial], axis=-1)
    starts, along = points[:-1], np.diff(points, axis=0)
    between = starts[None] - starts[:, None]
    turned = _cross(along[:, None], along[None])
    with np.errstate(divide="ignore", invalid="ignore"):
        here = _cross(between, along[None]) / turned
        there = _cross(between, along[:, None]) / turned
    meet = (here > 0.0) & (here < 1.0) & (there > 0.0) & (there < 1.0)
    return not bool(np.triu(meet, 2).any())


def steady_problem(train: Train) -> Problem[Base]:
    """The steady equations of a train; cells that come close get the rules for that."""
    systems: dict[bool, SteadySystem] = {}

    def evaluate(unknowns: Unknowns, near: Base) -> Evaluation[Base]:
        close = comes_close(train, near.coefficients)
        if close not in systems:
            systems[close] = steady_system(train, close=close)
        return evaluate_steady(systems[close], train, unknowns, "a search by deflation")

    return evaluate


def _try(
    problem: Problem[Base],
    name: str,
    start: Unknowns,
    known: Base,
    roots: Sequence[Unknowns],
    tries: Tries,
) -> tuple[SearchTry, Unknowns | None]:
    """One try; the root that it found, if it is another one."""
    if min(float(np.linalg.norm(start - root)) for root in roots) < SAME:
        return SearchTry(name, 0, "the guess is a known train", math.nan, None), None
    try:
        attempt = deflated_newton(problem, start, known, roots, tries)
    except NoSolution as failure:
        return SearchTry(name, 0, str(failure), math.nan, None), None
    error = attempt.evaluation.error
    if not attempt.converged:
        return SearchTry(name, attempt.steps, attempt.reason, error, None), None
    root = attempt.unknowns
    if min(float(np.linalg.norm(root - each)) for each in roots) < SAME:
        return SearchTry(name, attempt.steps, "came back to a known one", error, None), None
    base = attempt.evaluation.state
    if not is_a_cell(base.coefficients):
        return SearchTry(name, attempt.steps, "found the shape of no cell", error, None), root
    return SearchTry(name, attempt.steps, "found another train", error, base), root


def _describe(base: Base, guess: str, distance: float) -> FoundTrain:
    base = replace(base, origin=f"{base.origin} from {guess}")
    found = stability(base, azimuthal_numbers=[0], estimate_error=False)
    return FoundTrain(base, guess, distance, found.spectral_abscissa)


def _with_volume(system: SteadySystem, shape: Shape) -> Shape:
    """The shape scaled to the volume of the cell."""
    membrane = system.operator.membrane
    volume, target = (
        float(membrane.volume(each)) for each in (jnp.asarray(shape), membrane.reference_shape)
    )
    return shape * np.cbrt(target / volume) if volume > 0.0 else shape


def _cross(
    first: Float[np.ndarray, "... 2"], second: Float[np.ndarray, "... 2"]
) -> Float[np.ndarray, "..."]:
    return first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]
