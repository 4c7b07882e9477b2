"""The strength of the flow as one number, for the many that depend on the mean velocity U.

A number of a case whose dimension has the power p of U is, made dimensionless, in proportion to
U^-p: a modulus, in mu U, to 1/U. Hence the capillary number Ca = mu U/Es is in proportion to U, and
a case is given another one by another U, all SI values staying as they are.
"""

from collections.abc import Mapping

from celltrain.parameters.errors import CaseError
from celltrain.parameters.routing import DIMENSIONS, KEPT
from celltrain.parameters.scales import REFERENCE, Scales
from celltrain.parameters.sections import Cell, Strength

_NAME = "capillary_number"

#: The numbers of a case that depend on the strength of the flow.
DRIVEN = tuple(name for name in KEPT if DIMENSIONS[name].velocity != 0)

#: Those that are moduli: in proportion to energies and forces.
MODULI = tuple(
    name for name in DRIVEN if (DIMENSIONS[name].viscosity, DIMENSIONS[name].velocity) == (1, 1)
)


def weakened(leaves: Mapping[str, object], factor: float) -> dict[str, float]:
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


def put_over(
    leaves: Mapping[str, object], given: Mapping[str, object], *, si: bool = False
) -> dict[str, object]:
    """A case's leaves with others put over them, on all of which a given capillary number acts.

    The numbers that depend on the flow's strength change, and with them the mean velocity among
    the scales; in SI it is only the latter.

    **Arguments:** `leaves`: values by name, with `scales` among them or the reference ones;
    `given`: the same; `si`: whether both are in SI, and the scales leaves of their own.

    **Raises:** `CaseError` for a capillary number that is not allowed, or is given together with a
    number that it changes.
    """
    merged = {**leaves, **given}
    if _NAME not in given:
        return merged
    wanted = Strength.of({_NAME: merged.pop(_NAME)}).capillary_number
    for name in ("mean_velocity",) if si else DRIVEN:
        if name in given:
            raise CaseError(
                f"{name} and {_NAME} are both given, but the latter changes the former; allowed:"
                " one of them, or in SI all moduli with the capillary number"
            )
    return _stronger_in_si(merged, wanted) if si else _stronger(merged, wanted)


def _stronger(leaves: Mapping[str, object], wanted: float) -> dict[str, object]:
    known = leaves.get("scales", REFERENCE)
    scales = Scales(**known) if isinstance(known, Mapping) else known
    assert isinstance(scales, Scales)
    # Only where the moduli are allowed is there a capillary number before.
    factor = Cell.of(leaves).capillary_number / wanted
    slower = {**scales.model_dump(), "mean_velocity": scales.mean_velocity / factor}
    return {**leaves, **weakened(leaves, factor), "scales": Scales(**slower)}


def _stronger_in_si(leaves: Mapping[str, object], wanted: float) -> dict[str, object]:
    scales = Scales.of(leaves)
    dimension = DIMENSIONS["shear_modulus"]
    usual = REFERENCE.si(dimension, Cell().shear_modulus)
    shear = scales.dimensionless(dimension, leaves.get("shear_modulus", usual))
    before = Cell.of({"shear_modulus": shear}).capillary_number
    return {**leaves, "mean_velocity": scales.mean_velocity * wanted / before}
