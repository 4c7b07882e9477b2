"""Rigid spheres on the axis of a tube: the flow solver against classical tables.

The force density on a sphere that makes its surface move as required follows from the discrete
single layer K, a dense matrix in the axisymmetric harmonics. With the fluid at rest far away
(flow of zero mean), a force F moves the sphere at the velocity V: F = 6 pi K1 V. Held in a
Poiseuille flow of mean velocity U (2 U on the axis) it feels F = 12 pi K2 U. Spheres of a
free train feel no force.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from page import Page, plain_figure

from celltrain import Train
from celltrain.harmonics import UNIT_DISPLACEMENT, axisymmetric_basis
from celltrain.train import CellsOperator, close_distance, resting_shapes, train_operator

# Drag factors K1, K2 by the exact series solution, many terms.
EXPECTED = {0.3: (2.370094890, 2.228976606), 0.5: (5.947374246, 4.995338624)}
FREE = (1.6789619, 1.0323471)
# Axial period of the tube in its radii, so long that neighbours do not matter.
PERIOD = 10.0


@dataclass(frozen=True)
class Drag:
    """Drag factors, and velocity and apparent viscosity of a train of free spheres."""

    moving: float
    held: float
    free_velocity: float
    apparent_viscosity: float


@eqx.filter_jit
def _matrix(operator: CellsOperator, shapes: jax.Array, basis: jax.Array) -> tuple:
    """Velocity by UNIT_DISPLACEMENT force densities, and by none, in the axisymmetric harmonics."""

    def velocity(force: jax.Array) -> jax.Array:
        on_targets = operator.surface_velocity(shapes, force)
        return jnp.einsum("uik,ik->u", basis, operator.project(on_targets)[0])

    undisturbed = velocity(jnp.zeros_like(shapes))
    columns = jax.lax.map(lambda force: velocity(force[None]) - undisturbed, basis)
    return columns.T, undisturbed


def drag(ratio: float, period: float = PERIOD, degree: int = 16, **resolution: float) -> Drag:
    """Drag on spheres of radius r0 in a tube of radius r0/ratio, `period` tube radii apart."""
    radius = 1.0 / ratio
    train = Train(
        diameter=2.0 * radius,
        packing=1.0 / (period * radius),
        cells=1,
        reference="sphere",
        degree=degree,
        **resolution,
    )
    basis = axisymmetric_basis(degree)
    operator = train_operator(train, close=radius - 1.0 < close_distance(train.resolution))
    shapes = jnp.asarray(resting_shapes(train, 1))
    matrix, undisturbed = (np.asarray(a) for a in _matrix(operator, shapes, jnp.asarray(basis)))
    # A translation by 1, and the total force of a density: both in the first member's coefficient.
    translation = np.eye(len(basis))[0] * UNIT_DISPLACEMENT
    # A constant normal force makes no flow: least squares leave it out.
    moving = np.linalg.lstsq(matrix, translation, rcond=1e-9)[0]
    held = np.linalg.lstsq(matrix, -undisturbed, rcond=1e-9)[0]
    free_velocity = -held[0] / moving[0]
    density = jnp.einsum("u,uik->ik", jnp.asarray(moving * free_velocity + held), basis)
    flux = operator.flow.extra_flux(operator.sources(shapes, density[None]))
    return Drag(
        moving=moving[0] * UNIT_DISPLACEMENT / (6.0 * np.pi),
        held=-held[0] * UNIT_DISPLACEMENT / (12.0 * np.pi),
        free_velocity=free_velocity,
        apparent_viscosity=1.0 - float(flux),
    )


def study() -> None:
    page = Page("sphere", "Rigid spheres in a tube")
    page.text(
        f"""
A rigid sphere of radius a on the axis of a tube of radius R, periodic over {PERIOD:g} R, at degree
16 unless stated. K1: drag on the moving sphere over 6 pi mu a V. K2: drag on the sphere held in
Poiseuille flow of mean velocity U over 12 pi mu a U (2 U being the velocity on the axis). Expected
values: exact series solution of the kind of *Haberman & Sayre 1958*. What the default rules leave
comes from the tolerance of far sums, wall and near range alone, as the second table shows. From
a/R = 0.7 on the wall is so close that the graded rules take over there.
"""
    )
    rows = []
    ratios = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8)
    found = []
    for ratio in ratios:
        page.log(f"a/R = {ratio}")
        result = drag(ratio)
        finer = drag(ratio, degree=20)
        found.append(result)
        expected = EXPECTED.get(ratio)
        rows.append(
            (
                ratio,
                f"{result.moving:.9f}",
                f"{abs(result.moving / finer.moving - 1):.1e}",
                f"{expected[0]:.9f}" if expected else "",
                f"{abs(result.moving / expected[0] - 1):.1e}" if expected else "",
                f"{result.held:.9f}",
                f"{abs(result.held / finer.held - 1):.1e}",
                f"{expected[1]:.9f}" if expected else "",
                f"{abs(result.held / expected[1] - 1):.1e}" if expected else "",
            )
        )
    page.heading("Default rules")
    columns = ("change to M = 20", "expected", "error")
    page.table(("a/R", "K1", *columns, "K2", *columns), rows)

    page.heading("Convergence at a/R = 0.5")
    variants: tuple[tuple[str, dict[str, float]], ...] = (
        ("default, M = 12", {"degree": 12}),
        ("default, M = 16", {}),
        ("default, M = 20", {"degree": 20}),
        ("tolerance 1e-9", {"tolerance": 1e-9}),
        ("tolerance 1e-10", {"tolerance": 1e-10}),
        ("tolerance 1e-10, 48 x 72 polar nodes", _finest(16)),
        ("the same, M = 20", _finest(20)),
    )
    lines = []
    for name, settings in variants:
        page.log(name)
        result = drag(0.5, **settings)  # type: ignore[arg-type]
        moving, held = (result.moving / EXPECTED[0.5][0] - 1, result.held / EXPECTED[0.5][1] - 1)
        lines.append(
            (name, f"{result.moving:.9f}", f"{moving:.1e}", f"{result.held:.9f}", f"{held:.1e}")
        )
    page.table(("rules", "K1", "relative error", "K2", "relative error"), lines)

    page.heading("A train of free spheres")
    page.log("free spheres")
    free = drag(0.5, 2.0, **_finest(16))  # type: ignore[arg-type]
    page.text("a/R = 0.5, two tube radii apart, no force on any sphere; tolerance 1e-10.")
    page.table(
        ("", "computed", "expected", "difference"),
        [
            (name, f"{value:.9f}", f"{expected:.7f}", f"{value - expected:.0e}")
            for name, value, expected in (
                ("velocity/U", free.free_velocity, FREE[0]),
                ("apparent viscosity/mu", free.apparent_viscosity, FREE[1]),
            )
        ],
    )

    moving, held = ([getattr(each, name) for each in found] for name in ("moving", "held"))
    draw(page, ratios, moving, held)
    page.write()


def draw(page: Page, ratios: Sequence[float], moving: list[float], held: list[float]) -> None:
    """Both drag factors over a/R."""
    figure = plain_figure()
    axes = figure.subplots()
    axes.semilogy(ratios, moving, "o-", label="$K_1$, moving")
    axes.semilogy(ratios, held, "s-", label="$K_2$, held in the flow")
    known = sorted(EXPECTED)
    for column in (0, 1):
        axes.plot(known, [EXPECTED[each][column] for each in known], "kx", markersize=10)
    axes.set(xlabel="$a/R$", ylabel="drag factor")
    ticks = (1, 2, 5, 10, 20, 50)
    axes.set_yticks(ticks, [str(tick) for tick in ticks])
    axes.minorticks_off()
    axes.legend(frameon=False)
    page.figure(figure, "Drag factors of a sphere on the axis; crosses: expected values")


def _finest(degree: int) -> dict[str, float]:
    """The finest rules tried."""
    return {"degree": degree, "tolerance": 1e-10, "polar_radial": 48, "polar_azimuthal": 72}
