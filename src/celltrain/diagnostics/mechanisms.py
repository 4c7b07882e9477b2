"""What disturbances do to the cells: how they turn, strain and deform them."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from jaxtyping import Float

from celltrain.diagnostics.modes import mode_motion
from celltrain.diagnostics.quantities import ENERGY_PARTS
from celltrain.diagnostics.spectrum import deformation_spectrum
from celltrain.extras import check_installed
from celltrain.quantities import Quantity, Record, quantity
from celltrain.stability import Mode, Stability, TransientMode
from celltrain.steady import Base

#: Modes whose turning is computed.
MODES = 8


@dataclass(frozen=True)
class ModeTurning:
    """How a mode turns the cells, for each unit of its amplitude (see `mode_motion`)."""

    growth_rate: Annotated[float, Quantity(r"\mathrm{Re} \lambda", "U/r0", "growth rate")]
    azimuthal_number: Annotated[int, Quantity("m", "1", "azimuthal number")]
    wave_number: Annotated[int, Quantity("j", "1", "wave number")]
    tumbling: Annotated[
        float,
        Quantity(
            r"|\omega|", "U/r0^2", "rate at which the cells' axes turn", source="Eqs. (17) to (19)"
        ),
    ]
    tank_treading: Annotated[
        float,
        Quantity(
            r"|\Omega - \omega|",
            "U/r0^2",
            "rate at which membranes turn around their cells",
            source="Eqs. (20) and (21)",
        ),
    ]


@dataclass(frozen=True, eq=False)
class DisturbanceStrain(Record):
    """How a disturbance strains and deforms the cells, at the paper's amplitude (Table I)."""

    name: Annotated[str, Quantity("", "1", "which disturbance")]
    azimuthal_number: Annotated[int, Quantity("m", "1", "azimuthal number")]
    wave_number: Annotated[int, Quantity("j", "1", "wave number")]
    energies: Annotated[
        dict[str, float],
        Quantity("W", "mu U r0^2", "strain energy by part", source="Eqs. (23) and (24)"),
    ]
    spectrum: Annotated[
        Float[np.ndarray, " degree"],
        Quantity("E_n", "r0^2", "spectrum of the deformation over degrees", source="Eq. (16)"),
    ]

    @property
    @quantity(Quantity("W", "mu U r0^2", "strain energy"))
    def energy(self) -> float:
        """The sum of all parts, in mu U r0^2."""
        return sum(self.energies.values())


@dataclass(frozen=True, eq=False)
class Mechanisms(Record):
    """What the leading modes, and the disturbance that grows fastest at first, do to the cells."""

    kind: ClassVar[str] = "mechanisms"
    title: ClassVar[str] = "how disturbances of a train turn, strain and deform its cells"

    base: Base
    modes: tuple[ModeTurning, ...]
    strains: tuple[DisturbanceStrain, ...]

    @property
    @quantity(Quantity("W", "mu U r0^2", "strain energy of the leading mode"))
    def leading_energy(self) -> float:
        """W of the leading mode, in mu U r0^2."""
        return self.strains[0].energy

    @property
    @quantity(Quantity(r"W_\eta", "mu U r0^2", "strain energy of what grows fastest at first"))
    def transient_energy(self) -> float:
        """W of the disturbance that grows fastest at first, in mu U r0^2."""
        return self.strains[1].energy


def mechanisms(result: Stability) -> Mechanisms:
    """Turning, strain and deformation of a train's disturbances (Eqs. 16 to 24).

    The leading modes' turning; of the leading mode and of the disturbance that grows fastest at
    first also the strain energy by part and the spectrum over degrees.

    Raises:
        MissingExtra: without the extra `simulations`.
    """
    check_installed("simulations")
    leading = [mode for mode in result.modes if not mode.neutral][:MODES]
    return Mechanisms(
        base=result.base,
        modes=tuple(_turning(result, mode) for mode in leading),
        strains=(
            _strain(result, "leading mode", result.leading, result.shape(result.leading)),
            _strain(result, "fastest at first", result.transient, result.transient_shape()),
        ),
    )


def _turning(result: Stability, mode: Mode) -> ModeTurning:
    motion = mode_motion(result, mode)
    return ModeTurning(
        mode.growth_rate,
        mode.azimuthal_number,
        mode.wave_number,
        motion.tumbling,
        motion.tank_treading,
    )


def _strain(
    result: Stability,
    name: str,
    mode: Mode | TransientMode,
    shape: Float[np.ndarray, "cell 3 coefficient"],
) -> DisturbanceStrain:
    from celltrain.diagnostics.energy import perturbation_energy  # JAX

    parts = map(float, perturbation_energy(result.base, shape))
    return DisturbanceStrain(
        name,
        mode.azimuthal_number,
        mode.wave_number,
        dict(zip(ENERGY_PARTS, parts, strict=True)),
        deformation_spectrum(shape),
    )
