"""Any result as plain numbers and lists, for JSON."""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import TypeAlias

import numpy as np

from celltrain.parameters import Train
from celltrain.quantities import Record
from celltrain.quantities.fields import hints, properties
from celltrain.version import __version__

#: What JSON can hold.
Plain: TypeAlias = bool | int | float | str | Sequence[object] | Mapping[str, object] | None


def summary(result: Record) -> dict[str, Plain]:
    """A result as an object that JSON can hold, in r0, U and mu.

    Version, kind, and by their names all fields and derived quantities but the bulky ones, which
    files keep: a result within it is an object of its own, a case one in the sections of a case
    file. Numbers that are not finite become None, complex ones have the entries `real`, `imag`.
    """
    content = plain(result)
    assert isinstance(content, dict)
    return {"version": __version__, "kind": result.kind, **content}


def plain(value: object) -> Plain:
    """A value of a result without NumPy's types.

    Raises:
        TypeError: for a type that no result consists of.
    """
    if isinstance(value, Train):
        return {**value.sections(), "scales": value.scales.model_dump()}
    if dataclasses.is_dataclass(value):
        known = {
            name: getattr(value, name)
            for name, (_, meaning) in hints(type(value)).items()
            if meaning is None or not meaning.bulky
        }
        known |= {name: getattr(value, name) for name in properties(type(value))}
        # The case is what users look for.
        return {"case" if name == "train" else name: plain(each) for name, each in known.items()}
    if isinstance(value, Mapping):
        return {str(name): plain(each) for name, each in value.items()}
    if isinstance(value, np.ndarray | list | tuple):
        return [plain(each) for each in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, complex):
        return {"real": plain(value.real), "imag": plain(value.imag)}
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if value is None or isinstance(value, bool | int | float | str):
        return value
    raise TypeError(f"{type(value).__name__} has no form in JSON")
