"""Results compare equal when everything in them does, arrays included."""

import dataclasses
from collections.abc import Mapping
from numbers import Number
from typing import ClassVar

import numpy as np


class Record:
    """Base of frozen dataclasses (`eq=False`) that hold arrays: they compare field by field.

    NaN equals NaN, as in a result that is read from its file again. One with a `kind` may be saved;
    `title` says in files what it is.
    """

    kind: ClassVar[str] = ""
    title: ClassVar[str] = ""
    __hash__ = None  # type: ignore[assignment]

    def __eq__(self, other: object) -> bool:
        return equal(self, other) if type(other) is type(self) else NotImplemented


def equal(one: object, other: object) -> bool:
    """Whether two values are the same, element by element and field by field."""
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return _equal_arrays(np.asarray(one), np.asarray(other))
    if isinstance(one, Number) and isinstance(other, Number):
        return bool(one == other or (one != one and other != other))
    if type(one) is not type(other):
        return False
    if dataclasses.is_dataclass(one):
        names = (field.name for field in dataclasses.fields(one) if field.compare)
        return all(equal(getattr(one, name), getattr(other, name)) for name in names)
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return list(one) == list(other) and all(equal(one[key], other[key]) for key in one)
    if isinstance(one, list | tuple) and isinstance(other, list | tuple):
        return len(one) == len(other) and all(map(equal, one, other))
    return bool(one == other)


def _equal_arrays(one: np.ndarray, other: np.ndarray) -> bool:
    if one.shape != other.shape:
        return False
    numbers = one.dtype.kind in "fc" and other.dtype.kind in "fc"
    return bool(np.array_equal(one, other, equal_nan=numbers))
