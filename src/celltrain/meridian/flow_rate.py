"""The flow rate is held: the parabola that goes with the cells' forces.

A train in a tube of radius R and period L adds the flux Q0 to that of the parabola, known from
reciprocity,

    Q0 = (1/L) int F_z (R^2 - r^2)/4 dOmega,      q0 = Q0/(pi R^2),

so 2 (1 - r^2/R^2)(1 - q0) is what drives the flow, and 1 - q0 the extra pressure drop: the
effective viscosity in mu. Only axisymmetric disturbances that are alike in all cells change Q0.
"""

import numpy as np
from jaxtyping import Float

from celltrain.meridian.grids import Amplitudes, Meridian

Rates = Float[np.ndarray, " member"]


def parabola(rho: Meridian, radius: float) -> Meridian:
    """2 (1 - r^2/R^2), axial, in U."""
    return 2.0 * (1.0 - (rho / radius) ** 2)


def extra_flux(
    axial_force: Meridian, rho: Meridian, solid_angle: Meridian, radius: float, period: float
) -> float:
    """q0 of the module."""
    moment = np.sum(solid_angle * axial_force * (radius**2 - rho**2) / 4.0)
    return float(moment / (period * np.pi * radius**2))


def extra_flux_change(
    axial_force: Meridian,
    rho: Meridian,
    radius: float,
    period: float,
    sources: Amplitudes,
    force_change: Amplitudes,
) -> Rates:
    """dq0 for each member of m = 0: [int dF_z (R^2 - r^2)/4 - F_z r dr/2]/(L pi R^2).

    **Arguments:** `sources`: the members' displacements, and `force_change` their forces, both as
    amplitudes times solid angles.
    """
    points = len(rho)
    change = ((radius**2 - rho**2) / 4.0) @ force_change[2 * points :]
    change -= (axial_force * rho / 2.0) @ sources[:points]
    return np.asarray(change / (period * np.pi * radius**2))


def stress_flux(
    area: tuple[Meridian, Meridian],
    z: Meridian,
    rho: Meridian,
    radius: float,
    period: float,
    sources: Amplitudes,
) -> Rates:
    """The flux of the double layer in units of pi R^2, for each member of m = 0.

    L Q0 = int [z u.n - r (u_r n_z + u_z n_r)/2] dOmega, `area` the axial and radial n dS/dOmega.
    """
    axial, radial = area
    points = len(rho)
    flux = (z * radial - 0.5 * rho * axial) @ sources[:points]
    flux += (z * axial - 0.5 * rho * radial) @ sources[2 * points :]
    return np.asarray(flux / (period * np.pi * radius**2))
