"""The numbers by which trains are differentiated, and along which they are followed.

They are leaves of a case, with two differences. The reduced volume of a biconcave cell has a value,
the healthy cell's, also where a case gives none. The capillary number Ca = mu U/Es is no leaf: it
is the strength of the flow, to which all three moduli of the membrane are in inverse proportion.
"""

from collections.abc import Sequence

from celltrain.membrane import healthy_reduced_volume
from celltrain.parameters import CaseError, Train

MODULI = ("shear_modulus", "dilatation_modulus", "bending_modulus")

#: Parameters of a train by which its rates can be differentiated at fixed shapes.
PARAMETERS = (
    "diameter",
    "packing",
    "viscosity_ratio",
    *MODULI,
    "capillary_number",
    "reduced_volume",
)


def parameters_of(train: Train) -> tuple[str, ...]:
    """Those of `PARAMETERS` that a train has: only a biconcave cell has a reduced volume."""
    biconcave = train.cell.reference == "biconcave"
    return PARAMETERS if biconcave else tuple(p for p in PARAMETERS if p != "reduced_volume")


def check_parameters(names: Sequence[str], train: Train) -> None:
    """See to it that a train can be differentiated by these parameters.

    **Raises:** `CaseError` if not.
    """
    allowed = parameters_of(train)
    for name in names:
        if name not in allowed:
            raise CaseError(f"parameter = {name!r} is not allowed; allowed: {', '.join(allowed)}")


def parameter_value(train: Train, name: str) -> float:
    """The value of one of `PARAMETERS`, in r0, U and mu.

    **Raises:** `CaseError` if the train has none.
    """
    check_parameters([name], train)
    if name == "capillary_number":
        return train.cell.capillary_number
    value = train.leaf(name)
    # Only a reduced volume may be left open.
    return healthy_reduced_volume(train.degree) if value is None else float(value)


def with_parameter(train: Train, name: str, value: float) -> Train:
    """The train with another value of one of `PARAMETERS`.

    **Raises:** `CaseError` for a value that is not allowed.
    """
    if name != "capillary_number":
        return train.changed(**{name: value})
    if not value > 0.0:
        raise CaseError(f"capillary_number = {value:g} is not allowed; allowed: a number > 0")
    factor = train.cell.capillary_number / value
    return train.changed(**{modulus: factor * train.leaf(modulus) for modulus in MODULI})
