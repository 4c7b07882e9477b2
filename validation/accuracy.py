"""Is the reported error of the velocity honest?

Every numerical parameter is refined in turn, and the change of the velocity on the cells compared
with the estimate that users see: of steady trains, on the meridian; and of cells close together,
tilted and off the axis, in three dimensions.
"""

from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from page import Page, plain_figure

from celltrain import Train, steady
from celltrain.harmonics import UNIT_DISPLACEMENT
from celltrain.proximity.overlaps import overlaps
from celltrain.steady.problem import SteadyProblem
from celltrain.train import rates_error, resting_shapes, train_operator

TRAIN = Train(diameter=8, packing=0.4, cells=2, degree=12, viscosity_ratio=5.0)
# Displacement of the resting cells' centres from the axis (r0), and their tilt about y (radians).
OFFSETS = (0.5, -0.4)
TILTS = (0.6, -0.9)
DISTANCES = (0.5, 0.1, 0.02)
# Smallest distance from the wall that is served.
WALL_GAP = 0.8
REFINED: dict[str, dict[str, float]] = {
    "points of the source grid": {"source_order": 40},
    "points of the target grid": {"target_order": 20},
    "radial nodes of the polar rule": {"polar_radial": 38},
    "azimuthal nodes of the polar rule": {"polar_azimuthal": 56},
    "points of the energy's grid": {"energy_order": 48},
    "range of the near kernel": {"near_cutoff": 3.2},
    "tolerance": {"tolerance": 1e-8},
}
# Diameter, packing and degree of the steady trains.
STEADY = ((6.0, 0.2, 12), (6.0, 0.2, 24), (6.0, 0.7, 24), (3.0, 0.2, 24))
# Sizes of the rules on the meridian, and by how much they grow.
RULES: dict[str, tuple[str, ...]] = {
    "points of the targets": ("targets",),
    "polar rule": ("radial", "half_circle"),
    "points of the sources": ("sources",),
    "points of the nearest images": ("image_sources", "image_half_circle"),
    "tolerance of tail and wall": ("tolerance",),
}
FINER, FINER_TARGETS, FINER_TOLERANCE = 1.5, 2.0, 0.01


@eqx.filter_jit
def _rates(operator: eqx.Module, shapes: jax.Array) -> jax.Array:
    return operator.rates(shapes)  # type: ignore[attr-defined, no-any-return]


def configuration(distance: float) -> np.ndarray:
    """Two tilted cells off the axis whose membranes are `distance` apart."""
    shapes = resting_shapes(TRAIN, 1).repeat(2, axis=0)
    for cell, (offset, tilt) in enumerate(zip(OFFSETS, TILTS, strict=True)):
        cosine, sine = np.cos(tilt), np.sin(tilt)
        matrix = np.array([[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]])
        shapes[cell] = matrix @ shapes[cell]
        # Bent, too, so that no symmetry is left.
        shapes[cell, 0, 4] += 0.1 * (cell + 1)
        shapes[cell, 0, 0] += offset * UNIT_DISPLACEMENT
    near, far = 0.0, 0.5 * TRAIN.length
    while far - near > 1e-4:
        shapes[1, 2, 0] = 0.5 * (near + far) * UNIT_DISPLACEMENT
        touching = overlaps(shapes, period=TRAIN.length)
        near, far = (0.5 * (near + far), far) if touching else (near, 0.5 * (near + far))
    # Where they touch they are about across the tube's axis: the gap opens along it.
    shapes[1, 2, 0] = (far + distance) * UNIT_DISPLACEMENT
    return shapes


def velocity(train: Train, shapes: np.ndarray, values: np.ndarray, gap: float) -> np.ndarray:
    """Velocity at fixed points of the membranes."""
    operator = train_operator(train, cells=2, wall_gap=gap)
    return np.einsum("pk,cik->cpi", values, np.asarray(_rates(operator, jnp.asarray(shapes))))


def study() -> None:
    page = Page("accuracy", "The reported error of the velocity")
    page.text(
        """
The velocity on the cells is computed in two ways: on the meridian for trains of axisymmetric cells,
on which steady trains and growth rates stand, and in three dimensions for any shapes, on which
simulations stand. The error that each reports for what grids, rules and tolerances leave at the
given degree is compared with what refining one rule alone changes, both relative to the largest
velocity. Expected: no change above the error.
"""
    )
    on_the_meridian(page)
    in_three_dimensions(page)
    page.write()


def on_the_meridian(page: Page) -> None:
    """Steady trains."""
    page.heading("Steady trains, on the meridian")
    page.text(
        f"""
N = 8, viscosity ratio 1. The error: one more evaluation with all rules finer by a quarter, the
targets by three quarters, and a tolerance ten times smaller, times 1.5. The changes: targets times
{FINER_TARGETS:g}, tolerance times {FINER_TOLERANCE:g}, the others times {FINER:g}.
"""
    )
    columns, holds = [], True
    for diameter, packing, degree in STEADY:
        base = steady(Train(diameter=diameter, packing=packing, cells=8, degree=degree))
        problem = SteadyProblem(base.train)
        rules = problem.rules(base.profile)
        usual = problem.flow(base.profile, rules)
        changes = []
        for names in RULES.values():
            finer = replace(rules, **{name: _finer(name, getattr(rules, name)) for name in names})
            flow = problem.flow(base.profile, finer)
            moved = np.linalg.norm(flow.at_targets(flow.rates - usual.rates), axis=1).max()
            size = np.linalg.norm(flow.at_targets(flow.rates), axis=1).max()
            changes.append(float(moved / size))
        holds = holds and max(changes) <= base.velocity_error
        columns.append([f"{each:.1e}" for each in (base.velocity_error, *changes)])
        page.log(f"D = {diameter:g}, packing {packing:g}, M = {degree}")
    page.table(
        (
            "refined",
            *(f"D = {d:g}, packing {phi:g}, M = {degree}" for d, phi, degree in STEADY),
        ),
        [
            (name, *row)
            for name, row in zip(("**error**", *RULES), zip(*columns, strict=True), strict=True)
        ],
    )
    page.text(f"Every change is below the error: {'yes' if holds else 'NO'}.")


def _finer(name: str, size: float) -> float:
    if name == "tolerance":
        return FINER_TOLERANCE * size
    return round((FINER_TARGETS if name == "targets" else FINER) * size)


def in_three_dimensions(page: Page) -> None:
    """Two cells off the axis."""
    page.heading("Cells of any shape, in three dimensions")
    page.text(
        f"""
Two biconcave cells in a tube of diameter 8 r0, {OFFSETS[0]:g} and {OFFSETS[1]:g} r0 off the axis,
tilted by {TILTS[0]:g} and {TILTS[1]:g} radians, bent, viscosity ratio 5, one displaced along the
tube from where they would touch by the distance given. The error: one more evaluation with all
rules finer by a quarter, the target grid by three quarters, and a tolerance ten times smaller.
M = {TRAIN.degree}, the degree of simulations.
"""
    )
    columns: list[list[str]] = []
    largest: list[float] = []
    estimates: list[float] = []
    for distance in DISTANCES:
        shapes = configuration(distance)
        page.log(f"distance {distance:g}")
        estimate = rates_error(TRAIN, shapes, wall_gap=WALL_GAP)
        estimates.append(estimate)
        values = np.asarray(train_operator(TRAIN, cells=2, wall_gap=WALL_GAP).target_grid.values)
        expected = velocity(TRAIN, shapes, values, WALL_GAP)
        size = np.linalg.norm(expected, axis=-1).max()
        changes = []
        for name, finer in REFINED.items():
            page.log(name)
            found = velocity(TRAIN.changed(**finer), shapes, values, WALL_GAP)
            changes.append(np.linalg.norm(found - expected, axis=-1).max() / size)
        found = velocity(TRAIN, shapes, values, 0.6 * WALL_GAP)
        changes.append(np.linalg.norm(found - expected, axis=-1).max() / size)
        largest.append(max(changes))
        columns.append([f"{each:.1e}" for each in (estimate, *changes)])
        jax.clear_caches()
    names = ("**error**", *REFINED, "modes of the wall")
    page.table(
        ("refined", *(f"{distance:g} r0 apart" for distance in DISTANCES)),
        [(name, *row) for name, row in zip(names, zip(*columns, strict=True), strict=True)],
    )
    holds = all(change < estimate for change, estimate in zip(largest, estimates, strict=True))
    page.text(f"Every change is below the error: {'yes' if holds else 'NO'}.")
    draw(page, estimates, largest)


def draw(page: Page, estimates: list[float], largest: list[float]) -> None:
    """What is reported of two cells beside what is found, over their distance."""
    figure = plain_figure()
    axes = figure.subplots()
    axes.loglog(DISTANCES, estimates, "o-", label="error reported")
    axes.loglog(DISTANCES, largest, "s-", label="largest change by one rule")
    axes.set_xticks(DISTANCES, [f"{distance:g}" for distance in DISTANCES])
    axes.set_yticks([1e-4, 2e-4, 4e-4], ["1e-4", "2e-4", "4e-4"])
    axes.minorticks_off()
    axes.set(xlabel="distance, $r_0$", ylabel="relative error of the velocity")
    axes.legend(frameon=False)
    page.figure(
        figure,
        "Two cells in three dimensions: what is reported, and what refining one rule at a time"
        " changes",
    )
