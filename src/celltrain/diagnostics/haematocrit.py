"""Haematocrits of a train, and the viscosity of blood in tubes of glass at the same haematocrit.

The tube haematocrit is the cells' share of the tube's volume, the discharge haematocrit their share
of what flows out: as the mean velocity of everything is U and that of the cells U_c,

    H_T = N V/(pi R^2 L),    H_D = H_T U_c/U.

Pries, Neuhaus & Gaehtgens (1992) fitted measurements of the apparent viscosity of human blood,
relative to that of its plasma, in tubes of 3.3 to 1978 um, D the diameter in um:

    mu_rel = 1 + (mu_45 - 1) ((1 - H_D)^C - 1)/((1 - 0.45)^C - 1),
    mu_45 = 220 exp(-1.3 D) + 3.2 - 2.44 exp(-0.06 D^0.645),
    C = (0.8 + exp(-0.075 D)) (-1 + s) + s,   s = 1/(1 + 1e-11 D^12).

For the Fahraeus effect, that the tube haematocrit is below the discharge haematocrit as the cells
are faster than the mean, Pries, Secomb, Gaehtgens & Gross (1990) have

    H_T/H_D = H_D + (1 - H_D) (1 + 1.7 exp(-0.415 D) - 0.6 exp(-0.011 D)).
"""

import math

import numpy as np
from jaxtyping import Float

from celltrain.membrane import meridian_membrane
from celltrain.parameters import CaseError
from celltrain.steady import Base

#: Diameters, um, of the tubes in which the law's measurements were made.
MEASURED_DIAMETERS = (3.3, 1978.0)


def tube_haematocrit(base: Base) -> float:
    """Share of the tube's volume that the cells of a steady train take."""
    train = base.train
    volume = meridian_membrane(train).volume(base.profile)
    return volume / (math.pi * train.radius**2 * train.period)


def discharge_haematocrit(base: Base) -> float:
    """The cells' share of what flows through a cross-section, H_T U_c/U."""
    return tube_haematocrit(base) * base.cell_velocity


def in_vitro_viscosity(
    diameter: float, haematocrit: float | Float[np.ndarray, "..."]
) -> Float[np.ndarray, "..."]:
    """Apparent viscosity of blood in a tube over that of its plasma, by the law above.

    **Arguments:** `diameter` in um, within `MEASURED_DIAMETERS`; the discharge `haematocrit`, from
    0 to below 1.

    **Raises:** `CaseError` for others.
    """
    share = _checked(diameter, haematocrit)
    usual = 220.0 * math.exp(-1.3 * diameter) + 3.2 - 2.44 * math.exp(-0.06 * diameter**0.645)
    s = 1.0 / (1.0 + 1e-11 * diameter**12)
    power = (0.8 + math.exp(-0.075 * diameter)) * (s - 1.0) + s
    rise = ((1.0 - share) ** power - 1.0) / (0.55**power - 1.0)
    return np.asarray(1.0 + (usual - 1.0) * rise)


def in_vitro_fahraeus(
    diameter: float, haematocrit: float | Float[np.ndarray, "..."]
) -> Float[np.ndarray, "..."]:
    """H_T/H_D of blood in a tube, by the law above; arguments and errors as `in_vitro_viscosity`.

    In a train it is U/U_c.
    """
    share = _checked(diameter, haematocrit)
    thin = 1.0 + 1.7 * math.exp(-0.415 * diameter) - 0.6 * math.exp(-0.011 * diameter)
    return np.asarray(share + (1.0 - share) * thin)


def _checked(
    diameter: float, haematocrit: float | Float[np.ndarray, "..."]
) -> Float[np.ndarray, "..."]:
    """The haematocrits as an array, if the laws allow them and the diameter."""
    share = np.asarray(haematocrit, dtype=float)
    least, most = MEASURED_DIAMETERS
    if not least <= diameter <= most:
        raise CaseError(
            f"diameter = {diameter:g} um is not allowed: the law was measured from {least:g} to"
            f" {most:g} um"
        )
    if not ((share >= 0.0) & (share < 1.0)).all():
        raise CaseError("a haematocrit is a number from 0 to below 1")
    return share
