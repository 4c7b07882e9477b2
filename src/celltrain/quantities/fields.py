"""The quantities of a class: its annotated fields, and the properties that are marked."""

import dataclasses
from collections.abc import Hashable
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, cast, get_args, get_origin, get_type_hints

from celltrain.quantities.quantity import Quantity, marked


@dataclass(frozen=True)
class Named:
    """A quantity with its name, for labels and tables."""

    name: str
    meaning: Quantity

    @property
    def words(self) -> str:
        """What reports call it."""
        return self.meaning.words or self.name.replace("_", " ")

    @property
    def label(self) -> str:
        """For an axis of a picture: words, symbol and unit."""
        symbol = f" ${self.meaning.symbol}$" if self.meaning.symbol else ""
        return f"{self.words}{symbol}{unit_label(self.meaning.unit)}"


def unit_label(unit: str) -> str:
    """A unit in brackets as mathematics, after a space; nothing for pure numbers."""
    if unit in ("", "1"):
        return ""
    symbols = unit.replace("mu", r"\mu").replace("r0", "r_0").replace(" ", r"\,")
    return f" (${symbols}$)" if unit != "s" else " (s)"


def split(hint: object) -> tuple[object, Quantity | None]:
    """A hint without its annotations, and the quantity among them."""
    if get_origin(hint) is not Annotated:
        return hint, None
    inner, *notes = get_args(hint)
    return inner, next((note for note in notes if isinstance(note, Quantity)), None)


def hints(kind: type) -> dict[str, tuple[object, Quantity | None]]:
    """Type and quantity of each field of a dataclass, in order."""
    return _hints(cast(Hashable, kind))


def properties(kind: type) -> dict[str, Quantity]:
    """The marked properties of a class."""
    return _properties(cast(Hashable, kind))


def quantities(kind: type) -> dict[str, Quantity]:
    """All quantities of a class by name: fields first, then properties."""
    of_fields = {name: known for name, (_, known) in hints(kind).items() if known is not None}
    return of_fields | properties(kind)


def numbers(kind: type) -> dict[str, Quantity]:
    """The quantities of a class that are single numbers, which studies make columns of."""
    known = {name: hint for name, (hint, _) in hints(kind).items()}
    known |= {name: get_type_hints(getattr(kind, name).fget)["return"] for name in properties(kind)}
    found = quantities(kind)
    return {name: meaning for name, meaning in found.items() if known[name] in (float, int)}


def quantity_of(kind: type, name: str) -> Named:
    """A quantity of a class.

    Raises:
        KeyError: if the class has none of that name.
    """
    return Named(name, quantities(kind)[name])


@cache
def _hints(kind: Any) -> dict[str, tuple[Any, Quantity | None]]:
    known = get_type_hints(kind, include_extras=True)
    return {field.name: split(known[field.name]) for field in dataclasses.fields(kind)}


@cache
def _properties(kind: Any) -> dict[str, Quantity]:
    found = {}
    for each in reversed(kind.__mro__):
        for name, value in vars(each).items():
            if isinstance(value, property) and (meaning := marked(value)) is not None:
                found[name] = meaning
    return found
