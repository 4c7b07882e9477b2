"""Long cells in a dense train in a tube of 4.2 um, whose noses are inside the rims before them.

The packing rises in small steps along the branch, each from the tangent of the one before: one mode
of the train hardly decays there, so that small errors move it far. Kept as a small file; from
nothing five minutes.
"""

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass

import numpy as np
from page import FOLDER, Page

from celltrain import Base, Train, steady
from celltrain.harmonics.grading import regraded
from celltrain.steady.iterate import Iterated, march, newton
from celltrain.steady.path import change_degree
from celltrain.steady.problem import SteadyProblem, SteadyState, change_of_profile
from celltrain.steady.solve import describe

FILE = FOLDER / "data" / "capillaries-dense.json"
#: Tube (r0), speed (m/s) and the packing that is asked for.
DIAMETER, SPEED, PACKING, CELL_RADIUS = 1.5, 1e-3, 0.3, 2.8e-6
#: Packings along the branch, and the tube in which it begins at the first.
PACKINGS = (0.25, 0.27, 0.28, 0.285, 0.2909, 0.293, 0.296, 0.298, PACKING)
WIDE = 2.0
#: Degrees, the number of their targets, and gradings: the first along the branch.
RESOLUTIONS = (
    (48, 50, 1.0),
    (48, 72, 1.0),
    (56, 84, 1.0),
    (64, 96, 1.0),
    (64, 128, 1.0),
    (64, 96, 0.5),
    (64, 66, 0.0),
    (64, 96, 0.0),
)
#: From this degree on a resolution counts for the error.
FINE = 56
# Change of the packing whose difference gives the tangent, and Newton's steps.
STEP, TOLERANCE, MOST = 2e-4, 1e-9, 60


@dataclass(frozen=True)
class Dense:
    """One train: its resolution, numbers in r0, U and mu, and the slowest mode with m = 0, q = 0.

    `slowest` is the largest eigenvalue of the steady problem's Jacobian but for the volume's, U/r0.
    """

    packing: float
    degree: int
    targets: int
    grading: float
    film: float
    gap: float
    cell_velocity: float
    viscosity: float
    residual: float
    truncation_error: float
    slowest: float


def dense(page: Page) -> list[Dense]:
    """All that is kept, or computed anew: along the packings, then at the other resolutions."""
    if FILE.is_file():
        return [Dense(**each) for each in json.loads(FILE.read_text())]
    found = []
    for each in _computed():
        found.append(each)
        page.log(f"packing {each.packing:g}, M = {each.degree}: film {each.film:.5f}")
    FILE.write_text("[\n" + ",\n".join(json.dumps(asdict(each)) for each in found) + "\n]\n")
    return found


def _case(
    packing: float, degree: int, targets: int, grading: float, diameter: float = DIAMETER
) -> Train:
    return Train.from_si(
        radius=CELL_RADIUS,
        diameter=diameter * CELL_RADIUS,
        mean_velocity=SPEED,
        packing=packing,
        cells=1,
        degree=degree,
        target_order=targets,
        grading=grading,
    )


def _computed() -> Iterator[Dense]:
    first = RESOLUTIONS[0]
    base: Base | None = None
    for diameter in (WIDE, DIAMETER):
        train = _case(PACKINGS[0], *first, diameter)
        base = steady(train, start=base, estimate_error=False)
    assert base is not None
    problem = SteadyProblem(base.train)
    state = problem.state(base.profile)
    yield _described(problem, state)
    for packing in PACKINGS[1:]:
        following = SteadyProblem(_case(packing, *first))
        change = (packing - problem.train.packing) * _tangent(problem, state)
        guess = state.profile + change_of_profile(change)
        found = newton(following, guess, tolerance=TOLERANCE, most=MOST)
        state = _steady(found)
        problem = following
        yield _described(problem, state)
    for each in RESOLUTIONS[1:]:
        other = SteadyProblem(_case(PACKING, *each))
        begin = describe(problem, Iterated(state, (), "steady"), "")
        profile = regraded(change_degree(begin.profile, each[0]), first[2], each[2])
        yield _described(other, _steady(march(other, profile, tolerance=TOLERANCE, most=MOST)))


def _tangent(problem: SteadyProblem, state: SteadyState) -> np.ndarray:
    """Change of the unknowns with the packing."""
    train = problem.train.changed(packing=problem.train.packing + STEP)
    beyond = SteadyProblem(train).state(state.profile, state.flow.rules)
    right = np.append((beyond.rates - state.rates) / STEP, 0.0)
    return np.linalg.solve(state.bordered(), right)[:-1]


def _steady(found: Iterated) -> SteadyState:
    if not found.steady:
        raise RuntimeError(f"no steady train: {found.outcome}")
    return found.state


def _described(problem: SteadyProblem, state: SteadyState) -> Dense:
    train = problem.train
    values, vectors = np.linalg.eig(state.jacobian)
    normal = state.volume_gradient / np.linalg.norm(state.volume_gradient)
    keeping = np.abs(normal @ vectors) < 1e-3
    base = describe(problem, Iterated(state, (), "steady"), "")
    return Dense(
        packing=train.packing,
        degree=train.degree,
        targets=train.sizes.target_order,
        grading=train.sizes.grading,
        film=train.radius - base.largest_radius,
        gap=base.gap,
        cell_velocity=base.cell_velocity,
        viscosity=base.effective_viscosity,
        residual=state.residual,
        truncation_error=state.truncation_error,
        slowest=float(values.real[keeping].max()),
    )


def section(page: Page) -> None:
    """The section of the page."""
    rows = sorted(dense(page), key=lambda each: (each.packing, each.degree, each.targets))
    page.heading("A dense train in a tube of 4.2 um")
    page.table(
        (
            "phi",
            "M",
            "targets",
            "film, r0",
            "gap, r0",
            "U_c/U",
            "viscosity",
            "residual, U",
            "left out, U",
            "slowest, U/r0",
        ),
        [
            (
                f"{each.packing:.4g}",
                f"{each.degree}, {f'grading {each.grading:g}' if each.grading else 'plain'}",
                each.targets,
                f"{each.film:.5f}",
                f"{each.gap:.4f}",
                f"{each.cell_velocity:.5f}",
                f"{each.viscosity:.4f}",
                f"{each.residual:.0e}",
                f"{each.truncation_error:.0e}",
                f"{each.slowest:+.4f}",
            )
            for each in rows
        ],
    )
    page.text(_words(rows))


def _words(rows: list[Dense]) -> str:
    """What the table says of the packing that is asked for."""
    here = [each for each in rows if each.packing == PACKING]
    best = min(here, key=lambda each: each.truncation_error)
    apart: dict[bool, tuple[float, float]] = {}
    for fine in (True, False):
        others = [each for each in here if (each.degree >= FINE) == fine and each is not best]
        films = max(abs(each.film / best.film - 1.0) for each in others)
        viscosities = max(abs(each.viscosity / best.viscosity - 1.0) for each in others)
        apart[fine] = films, viscosities
    (films, viscosities), (coarse_films, coarse_viscosities) = apart[True], apart[False]
    slow = [each.slowest for each in here]
    loosest = min(rows, key=lambda each: each.packing)
    return f"""
The cells are as long as the period nearly, and each nose is inside the rim of the cell before it:
*gap* is along the tube, from the nose's tip to the rim's plane, and *slowest* the largest
eigenvalue of disturbances with m = 0 that are alike in all cells. It is {loosest.slowest:+.3f} at a
packing of {loosest.packing:.3g} and {min(slow):+.3f} to {max(slow):+.3f} at {PACKING:g}, by
resolution: no fold of the branch was met up to there, but one mode hardly decays, and an error of
the velocity may move the train by that error over the decay rate. So the residual says little, and
degree, grading and targets count. At packing {PACKING:g} the train whose degree leaves out least
(M = {best.degree}, {best.targets} targets) has a film of {best.film:.4f} r0
({best.film * CELL_RADIUS * 1e6:.3f} um) and the viscosity {best.viscosity:.3f}; all others of M =
{FINE} and more, with other targets and gradings, differ from it by {films:.1%} and
{viscosities:.1%} at most, which is what is known of its errors; those of lower degrees by
{coarse_films:.1%} and {coarse_viscosities:.1%}.
"""
