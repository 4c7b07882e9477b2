"""The numbers by which trains are differentiated, and along which they are followed.

They are those of a case by which its equations have derivatives at fixed shapes: the tube's, the
flow's, and whatever the laws of the membrane are made of. The reduced volume of a biconcave cell
has a value, the healthy cell's, also where a case gives none.
"""

from collections.abc import Sequence
from dataclasses import fields

from celltrain.laws import BENDINGS, LAWS
from celltrain.membrane import healthy_reduced_volume
from celltrain.parameters import CaseError, Cell, Train

_OF_LAWS = {field.name for law in (*LAWS.values(), *BENDINGS.values()) for field in fields(law)}

#: Numbers of a cell that its laws depend on.
MATERIAL = tuple(name for name in Cell.model_fields if name in _OF_LAWS)

#: Parameters of a train by which its rates can be differentiated at fixed shapes.
PARAMETERS = (
    "diameter",
    "packing",
    "viscosity_ratio",
    *MATERIAL,
    "capillary_number",
    "reduced_volume",
)


def parameters_of(train: Train) -> tuple[str, ...]:
    """Those of `PARAMETERS` that a train has.

    Of `MATERIAL` those of its own laws; only a biconcave cell has a reduced volume.
    """
    laws = LAWS[train.cell.law], BENDINGS[train.cell.bending]
    own = {field.name for law in laws for field in fields(law)}
    lacking = set(MATERIAL) - own
    if train.cell.reference != "biconcave":
        lacking.add("reduced_volume")
    return tuple(name for name in PARAMETERS if name not in lacking)


def check_parameters(names: Sequence[str], train: Train) -> None:
    """Check that a train can be differentiated by these parameters.

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
    value = train.leaf(name)
    # Only a reduced volume may be left open.
    return float(value) if isinstance(value, int | float) else healthy_reduced_volume(train.degree)
