"""A rigid cell of a given shape in a tube by lubrication theory: its velocity, and what it costs.

In a tube so tight that the film varies slowly along a cell, the flow at each z is that of an
annulus between the cell, of radius a(z) and velocity U_c, and the wall, of radius R, under the
pressure gradient -G(z). With A = log(R/a), s = R^2 - a^2, and mu = 1, its flux with the cell's own
cross-section, and the force of the fluid on the cell for each length, are

    Q = pi U_c s/(2 A) + (pi/8) G [R^4 - a^4 - s^2/A],
    f = (pi/A) (G s/2 - 2 U_c).

The flux is the same everywhere, Q = pi R^2 U, and there is no force on the cell, int f dz = 0. That
gives U_c and, with the pressure drop beyond that of the plain fluid, the effective viscosity

    mu_eff = 1 + (R^2/8 L) int (G - 8 U/R^2) dz.

For a bullet, a long cylinder with a = lambda R, the flow in the film is that of the plain parabola,
as no other one has no shear force left over: G = 4 U_c/s, and

    U_c/U = 2/(1 + lambda^2),    G = 8 U/(R^2 (1 - lambda^4)),

so for a thin film h = R - a, U_c/U = 1 + h/R, and the pressure drop of a cell of length l beyond
the fluid's own is 2 mu U l/(R h). A hollow in the cell moves with it: a(z) is its largest radius.
"""

import numpy as np

from celltrain.meridian.geometry import meridian_points
from celltrain.meridian.grids import Meridian
from celltrain.steady import Base

#: Cross-sections of a cell.
SECTIONS = 2001


def rigid_bullet(ratio: float) -> tuple[float, float]:
    """U_c/U of a long cylinder of `ratio` = a/R, and its pressure gradient over plain fluid's."""
    return 2.0 / (1.0 + ratio**2), 1.0 / (1.0 - ratio**4)


def rigid_cell(
    z: Meridian, envelope: Meridian, radius: float, period: float
) -> tuple[float, float]:
    """U_c/U and mu_eff/mu of a rigid cell, by the equations of the module.

    **Arguments:** `envelope`: the cell's radius a > 0 at the places z, below the tube's `radius`;
    `period`: the length of tube for each cell. All in r0.
    """
    log = np.log(radius / envelope)
    s = radius**2 - envelope**2
    across = radius**4 - envelope**4 - s**2 / log
    # G = fixed + U_c following.
    fixed, following = 8.0 * radius**2 / across, -4.0 * s / log / across
    still = _integral(0.5 * s * fixed / log, z)
    moving = _integral((0.5 * s * following - 2.0) / log, z)
    velocity = -still / moving
    extra = _integral(fixed + velocity * following - 8.0 / radius**2, z)
    return velocity, 1.0 + radius**2 / (8.0 * period) * extra


def lubricated(base: Base) -> tuple[float, float]:
    """The same for the cells of a steady train."""
    z, envelope = outline(base)
    return rigid_cell(z, envelope, base.train.radius, base.train.period)


def outline(base: Base) -> tuple[Meridian, Meridian]:
    """Cross-sections of a cell, rear to front, and its largest radius there, r0."""
    rho, z = meridian_points(base.profile)
    edges = np.linspace(z.min(), z.max(), SECTIONS + 1)
    levels = 0.5 * (edges[1:] + edges[:-1])
    found = np.zeros(SECTIONS)
    for here, there, one, other in zip(z[:-1], z[1:], rho[:-1], rho[1:], strict=True):
        low, high = min(here, there), max(here, there)
        inside = slice(*np.searchsorted(levels, (low, high)))
        part = (levels[inside] - here) / (there - here) if there != here else 0.0
        found[inside] = np.maximum(found[inside], one + part * (other - one))
    return levels, np.maximum(found, 1e-9)


def _integral(values: Meridian, z: Meridian) -> float:
    return float(np.trapezoid(values, z))
