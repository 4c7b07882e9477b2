"""The strength of the flow as one number, for the many that depend on the mean velocity U.

A number of a case whose dimension has the power p of U is, made dimensionless, in proportion to
U^-p: a modulus, in mu U, to 1/U. Hence the capillary number Ca = mu U/Es is in proportion to U, and
a case is given another one by another U, all SI values staying as they are.
"""

from collections.abc import Mapping
from typing import Any

from celltrain.parameters.routing import DIMENSIONS, KEPT
from celltrain.parameters.scales import Scales
from celltrain.parameters.sections import Cell, Strength

#: The numbers of a case that depend on the strength of the flow.
DRIVEN = tuple(name for name in KEPT if DIMENSIONS[name].velocity != 0)

#: Those that are moduli: in proportion to energies and forces.
MODULI = tuple(
    name for name in DRIVEN if (DIMENSIONS[name].viscosity, DIMENSIONS[name].velocity) == (1, 1)
)


def weakened(leaves: Mapping[str, Any], factor: float) -> dict[str, Any]:
    """The leaves that depend on the flow's strength, in a flow with U/factor in place of U.

    **Arguments:** `leaves`: values by name, in r0, U and mu; a default stands for one that is not
    there.
    """
    values = {name: leaves.get(name, KEPT[name].default) for name in DRIVEN}
    return {
        name: factor ** DIMENSIONS[name].velocity * value
        for name, value in values.items()
        if isinstance(value, int | float)
    }


def with_strength(
    leaves: Mapping[str, Any], scales: Scales, capillary_number: Any
) -> tuple[dict[str, Any], Scales]:
    """Leaves and scales of a case that is given a capillary number.

    **Raises:** `CaseError` for one that is not allowed.
    """
    wanted = Strength(capillary_number=capillary_number).capillary_number
    # Only where the moduli are allowed is there a capillary number before.
    before = Cell(**{name: leaves[name] for name in Cell.model_fields if name in leaves})
    factor = before.capillary_number / wanted
    mean_velocity = scales.mean_velocity / factor
    return (
        {**leaves, **weakened(leaves, factor)},
        Scales(**{**scales.model_dump(), "mean_velocity": mean_velocity}),
    )
