"""Any result as the variables of one flat data set, and back, bit for bit.

A result is a dataclass. Its fields are variables of their names; a dataclass within it has its name
before those of its fields (`base_cell_velocity`); several of one kind become columns
(`modes_growth_rate`), and columns within columns follow each other, with a count for each
(`..._count`). Arrays of one shape are stacked, others follow each other with their shapes
(`..._shape`). What is keyed by azimuthal numbers, or by names of quantities, has a variable for
each (`blocks_m01`, `history_eps`), what is keyed by other names a column of them (`..._key`).
Complex numbers are two variables (`..._real`, `..._imag`), a case is its TOML, and where there is
one of several kinds, or nothing, `..._kind` says which. Attributes are those of the field's
`Quantity`.
"""

import dataclasses
import tomllib
import types
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, TypeVar, Union, get_args, get_origin

import jaxtyping
import numpy as np

from celltrain.parameters import Train, merge_case
from celltrain.quantities import Quantity
from celltrain.quantities.fields import hints, split
from celltrain.results.content import Variable

Result = TypeVar("Result")

#: Types of single values: how they are kept, written and read.
SCALARS: dict[Any, tuple[Any, Callable[[Any], Any], Callable[[Any], Any]]] = {
    bool: (bool, bool, bool),
    int: (np.int64, int, int),
    float: (float, float, float),
    complex: (complex, complex, complex),
    str: (str, str, str),
    Train: (str, Train.to_toml, lambda text: _case(str(text))),
}
_NOTHING = type(None)


def _case(text: str) -> Train:
    """A case that was computed: whether it is unusual was asked then."""
    return merge_case(tomllib.loads(text), {"unusual": True})


#: Variables by name.
Data = Mapping[str, Variable]


@dataclass
class _Written:
    """The variables so far, and the lengths of their dimensions."""

    variables: dict[str, Variable] = field(default_factory=dict)
    lengths: dict[str, int] = field(default_factory=dict)

    def add(self, name: str, dims: Sequence[str], values: Any, meaning: Quantity | None) -> None:
        """Enter a variable; a dimension's name that is taken by another length gets longer."""
        values = np.asarray(values)
        notes = meaning.attributes if meaning else {}
        if values.dtype.kind == "c":
            for part, label in ((values.real, "real"), (values.imag, "imaginary")):
                about = notes and notes | {"long_name": f"{notes['long_name']}, {label} part"}
                self._enter(f"{name}_{label[:4]}", self._free(name, dims, part), part, about)
        else:
            self._enter(name, self._free(name, dims, values), values, notes)

    def _enter(self, name: str, dims: tuple[str, ...], values: Any, notes: Any) -> None:
        if name in self.variables:
            raise ValueError(f"two fields of a result have the name {name!r} in files")
        self.variables[name] = Variable(dims, values, notes)

    def _free(self, name: str, dims: Sequence[str], values: np.ndarray) -> tuple[str, ...]:
        found: list[str] = []
        for place, (dim, length) in enumerate(zip(dims, values.shape, strict=True)):
            candidates = (dim, f"{name}_{dim}", f"{name}_{dim}_{place}")
            free = next(
                each
                for each in candidates
                if each not in found and self.lengths.setdefault(each, length) == length
            )
            found.append(free)
        return tuple(found)


def to_variables(result: object) -> dict[str, Variable]:
    """The variables of a result, which is a dataclass.

    Raises:
        TypeError: for a field whose type has no form in files.
    """
    written = _Written()
    for name, (hint, meaning) in hints(type(result)).items():
        _write(written, hint, [getattr(result, name)], name, None, meaning)
    return written.variables


def from_variables(kind: type[Result], data: Data) -> Result:
    """A result of a kind, from what `to_variables` made of it.

    Raises:
        KeyError: if a variable is missing.
    """
    values = {
        name: _read(data, hint, name, None, meaning)[0]
        for name, (hint, meaning) in hints(kind).items()
    }
    return kind(**values)


# `lead` is the dimension along which the values of one field lie; None for a single value.
def _write(
    written: _Written,
    hint: Any,
    values: Sequence[Any],
    name: str,
    lead: str | None,
    meaning: Quantity | None,
) -> None:
    hint, own = split(hint)
    meaning = own or meaning
    dims = () if lead is None else (lead,)
    if (scalar := _scalar(hint)) is not None:
        kept, write, _ = scalar
        kept_values = np.array([write(each) for each in values], dtype=kept)
        written.add(name, dims, kept_values[0] if lead is None else kept_values, meaning)
    elif _is_array(hint):
        _write_arrays(written, hint, [np.asarray(each) for each in values], name, lead, meaning)
    elif (kinds := _alternatives(hint)) is not None:
        labels = [_label(kinds, each) for each in values]
        written.add(f"{name}_kind", dims, labels[0] if lead is None else np.array(labels), None)
        for each in kinds:
            chosen = [v for v, label in zip(values, labels, strict=True) if label == _name(each)]
            if chosen and each is not _NOTHING:
                inner = None if lead is None else f"{name}_given"
                _write(written, each, chosen, _place(name, kinds, each), inner, meaning)
    elif dataclasses.is_dataclass(hint):
        for inside, (each, about) in hints(hint).items():  # type: ignore[arg-type]
            inner_values = [getattr(value, inside) for value in values]
            _write(written, each, inner_values, f"{name}_{inside}", lead, about)
    elif (key := _numbered(hint)) is not None and lead is None:
        written.add(f"{name}_key", (f"{name}_key",), np.array(list(values[0]), np.int64), None)
        for number, value in values[0].items():
            about = meaning and dataclasses.replace(
                meaning, description=f"{meaning.description}, azimuthal number m = {number}"
            )
            _write(written, key, [value], f"{name}_m{number:02d}", None, about)
    elif (pair := _mapping(hint)) is not None and meaning and meaning.parts and lead is None:
        names = np.array(list(values[0]), dtype=str)
        written.add(f"{name}_key", (f"{name}_key",), names, None)
        for part, value in values[0].items():
            _write(written, pair[1], [value], f"{name}_{part}", None, meaning.parts.get(part))
    elif (pair := _mapping(hint)) is not None:
        counts = [len(each) for each in values]
        inner = _counted(written, counts, name, lead)
        keys = [key for each in values for key in each]
        _write(written, pair[0], keys, f"{name}_key", inner, None)
        _write(written, pair[1], [v for e in values for v in e.values()], name, inner, meaning)
    elif (item := _sequence(hint)) is not None:
        inner = _counted(written, [len(each) for each in values], name, lead)
        _write(written, item, [v for each in values for v in each], name, inner, meaning)
    elif (items := _fixed(hint)) is not None:
        for place, each in enumerate(items):
            _write(written, each, [v[place] for v in values], f"{name}_{place}", lead, meaning)
    else:
        raise TypeError(f"{name}: {hint} has no form in files")


def _read(
    data: Data, hint: Any, name: str, lead: int | None, meaning: Quantity | None = None
) -> list[Any]:
    """The values of a field: `lead` of them, or a single one for None."""
    hint, own = split(hint)
    meaning = own or meaning
    count = 1 if lead is None else lead
    if (scalar := _scalar(hint)) is not None:
        column = _values(data, name, complex_=scalar[0] is complex)
        return [scalar[2](each) for each in np.atleast_1d(column).tolist()]
    if _is_array(hint):
        return _read_arrays(data, hint, name, lead)
    if (kinds := _alternatives(hint)) is not None:
        labels = [str(each) for each in np.atleast_1d(data[f"{name}_kind"].values)]
        found = {}
        for each in kinds:
            number = labels.count(_name(each))
            if each is _NOTHING or not number:
                found[_name(each)] = iter([None] * number)
                continue
            inner = None if lead is None else number
            found[_name(each)] = iter(_read(data, each, _place(name, kinds, each), inner))
        return [next(found[label]) for label in labels]
    if dataclasses.is_dataclass(hint):
        columns = {
            inside: _read(data, each, f"{name}_{inside}", lead, about)
            for inside, (each, about) in hints(hint).items()  # type: ignore[arg-type]
        }
        return [hint(**{key: each[i] for key, each in columns.items()}) for i in range(count)]  # type: ignore[operator]
    if (key := _numbered(hint)) is not None and lead is None:
        numbers = data[f"{name}_key"].values.tolist()
        return [{m: _read(data, key, f"{name}_m{m:02d}", None)[0] for m in numbers}]
    if (pair := _mapping(hint)) is not None and meaning and meaning.parts and lead is None:
        keys = data[f"{name}_key"].values.tolist()
        return [{key: _read(data, pair[1], f"{name}_{key}", None)[0] for key in keys}]
    if (pair := _mapping(hint)) is not None:
        counts = _counts(data, name, lead)
        keys = iter(_read(data, pair[0], f"{name}_key", sum(counts)))
        values = iter(_read(data, pair[1], name, sum(counts)))
        return [{next(keys): next(values) for _ in range(size)} for size in counts]
    if (item := _sequence(hint)) is not None:
        counts = _counts(data, name, lead)
        values = iter(_read(data, item, name, sum(counts)))
        return [tuple(next(values) for _ in range(size)) for size in counts]
    if (items := _fixed(hint)) is not None:
        each = [_read(data, kind, f"{name}_{i}", lead) for i, kind in enumerate(items)]
        return list(zip(*each, strict=True))
    raise TypeError(f"{name}: {hint} has no form in files")


def _write_arrays(
    written: _Written,
    hint: Any,
    values: list[np.ndarray],
    name: str,
    lead: str | None,
    meaning: Quantity | None,
) -> None:
    if lead is None:
        written.add(name, _dims(hint, values[0].ndim, meaning), values[0], meaning)
        return
    if len({each.shape for each in values}) == 1:
        stacked = np.stack(values)
        written.add(name, (lead, *_dims(hint, stacked.ndim - 1, meaning)), stacked, meaning)
        return
    rank = values[0].ndim if values else 0
    shapes = np.array([each.shape for each in values], dtype=np.int64).reshape(len(values), rank)
    kept = np.concatenate([each.ravel() for each in values]) if values else np.zeros(0)
    written.add(f"{name}_shape", (lead, "rank"), shapes, None)
    written.add(name, (f"{name}_entry",), kept, meaning)


def _read_arrays(data: Data, hint: Any, name: str, lead: int | None) -> list[np.ndarray]:
    if lead == 0:
        return []
    complex_ = f"{name}_real" in data
    values = _values(data, name, complex_=complex_)
    if lead is None:
        return [values]
    if f"{name}_shape" not in data:
        return list(values)
    shapes = data[f"{name}_shape"].values
    ends = np.cumsum(np.prod(shapes, axis=1))
    parts = np.split(values, ends[:-1])
    return [part.reshape(shape) for part, shape in zip(parts, shapes, strict=True)]


def _values(data: Data, name: str, *, complex_: bool) -> np.ndarray:
    if not complex_:
        found: np.ndarray = data[name].values
        return found
    # Arithmetic with 1j would lose the signs of zeros.
    whole = np.empty(data[f"{name}_real"].values.shape, dtype=complex)
    whole.real, whole.imag = data[f"{name}_real"].values, data[f"{name}_imag"].values
    return whole


def _counted(written: _Written, counts: list[int], name: str, lead: str | None) -> str:
    """The dimension along which parts follow each other, with their counts if there are several."""
    written.add(
        f"{name}_count", () if lead is None else (lead,), counts if lead else counts[0], None
    )
    return name


def _counts(data: Data, name: str, lead: int | None) -> list[int]:
    return [int(each) for each in np.atleast_1d(data[f"{name}_count"].values)]


def _scalar(hint: Any) -> Any:
    if get_origin(hint) is Literal:
        hint = type(get_args(hint)[0])
    return SCALARS.get(hint) if isinstance(hint, type) else None


def _is_array(hint: Any) -> bool:
    return hint is np.ndarray or (
        isinstance(hint, type) and issubclass(hint, jaxtyping.AbstractArray)
    )


def _dims(hint: Any, rank: int, meaning: Quantity | None) -> tuple[str, ...]:
    """Names of an array's dimensions: of its quantity, or of its annotation."""
    if meaning and len(meaning.dims) == rank:
        return meaning.dims
    words = getattr(hint, "dim_str", "").split()
    if len(words) == rank:
        return tuple(word if word.isidentifier() else f"axis_{word}" for word in words)
    return tuple(f"axis_{place}" for place in range(rank))


def _alternatives(hint: Any) -> tuple[Any, ...] | None:
    return get_args(hint) if get_origin(hint) in (Union, types.UnionType) else None


def _name(kind: Any) -> str:
    return "none" if kind is _NOTHING else getattr(split(kind)[0], "__name__", str(kind))


def _label(kinds: tuple[Any, ...], value: Any) -> str:
    """The name of the kind that a value is of."""
    if value is None:
        return "none"
    exact = [_name(each) for each in kinds if split(each)[0] is type(value)]
    others = [_name(each) for each in kinds if each is not _NOTHING]
    return exact[0] if exact else others[0]


def _place(name: str, kinds: tuple[Any, ...], kind: Any) -> str:
    """The name under which one of several kinds is kept."""
    several = sum(each is not _NOTHING for each in kinds) > 1
    return f"{name}_{_name(kind).lower()}" if several else name


def _arguments(hint: Any, *origins: type) -> tuple[Any, ...]:
    return get_args(hint) if get_origin(hint) in origins else ()


def _numbered(hint: Any) -> Any:
    """The type of what is keyed by whole numbers."""
    found = _arguments(hint, dict)
    return found[1] if found and found[0] is int else None


def _mapping(hint: Any) -> tuple[Any, Any] | None:
    found = _arguments(hint, dict)
    return (found[0], found[1]) if found else None


def _sequence(hint: Any) -> Any:
    found = _arguments(hint, tuple)
    return found[0] if len(found) == 2 and found[1] is Ellipsis else None


def _fixed(hint: Any) -> tuple[Any, ...] | None:
    found = _arguments(hint, tuple)
    return found if found and Ellipsis not in found else None


def walk(kind: type, prefix: str = "") -> Iterator[tuple[str, type, str]]:
    """Every quantity that a result of a kind holds: its name in files, its class, its field."""
    for name, (hint, meaning) in hints(kind).items():
        if meaning is not None:
            yield prefix + name, kind, name
        for each in parts_of(hint):
            yield from walk(each, f"{prefix}{name}_")


def parts_of(hint: object) -> list[type]:
    """The dataclasses that a type of a field is made of."""
    hint, _ = split(hint)
    if _is_array(hint) or _scalar(hint) is not None:
        return []
    if dataclasses.is_dataclass(hint):
        return [hint]  # type: ignore[list-item]
    return [part for each in get_args(hint) for part in parts_of(each)]
