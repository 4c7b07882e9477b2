"""The law and the bending energy that a cell's parameters name, with the cell's moduli."""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any, TypeVar

from celltrain.laws.arithmetic import Number
from celltrain.laws.bending import BENDINGS, BendingLaw
from celltrain.laws.constitutive import LAWS, ConstitutiveLaw
from celltrain.parameters import Cell

Law = TypeVar("Law", ConstitutiveLaw, BendingLaw)


def cell_material(cell: Cell) -> tuple[ConstitutiveLaw, BendingLaw]:
    """What a cell's membrane is made of; each field takes the cell's value of the same name."""
    return _made(LAWS[cell.law], cell), _made(BENDINGS[cell.bending], cell)


def with_moduli(law: Law, moduli: Mapping[str, Number]) -> Law:
    """A law with other values of those moduli, by name, that it has."""
    own: Any = law
    return type(law)(
        **{field.name: moduli.get(field.name, getattr(law, field.name)) for field in fields(own)}
    )


def _made(kind: Any, cell: Cell) -> Any:
    return kind(**{field.name: getattr(cell, field.name) for field in fields(kind)})
