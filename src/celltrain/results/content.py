"""What a file holds, as netCDF-4 in memory and back: variables over dimensions, with attributes.

It is written as xarray writes it, so that `xarray.open_dataset` gives it back: texts as netCDF's
strings, truth values as bytes that say so, no fill values. xarray itself takes the better part of a
second until it has written its first file, which commands with small files would wait for.
"""

from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass
from threading import Lock
from typing import Any, NamedTuple

import netCDF4
import numpy as np

# netCDF's library runs in one thread at a time; an interrupted simulation is saved in another one
# than that which marches.
_ONE_AT_A_TIME = Lock()
# By which xarray knows truth values.
_TRUTH = {"dtype": "bool"}


class Variable(NamedTuple):
    """Numbers, truth values or texts, with the names of their dimensions; xarray takes it as it is.

    Attributes:
        dims: a name for each dimension of the values.
        attributes: what they mean.
    """

    dims: tuple[str, ...]
    values: np.ndarray
    attributes: Mapping[str, Any]


@dataclass(frozen=True)
class FileContent:
    """What a file holds."""

    variables: Mapping[str, Variable]
    attributes: Mapping[str, Any]


def to_bytes(content: FileContent) -> bytes:
    """A file's content, made in memory: a full disk leaves no library with a file to close.

    Raises:
        TypeError: for values of a type that has no form in files.
        ValueError: for dimensions of several lengths.
    """
    with _ONE_AT_A_TIME:
        file = netCDF4.Dataset("content", mode="w", memory=1, format="NETCDF4")
        try:
            file.setncatts(content.attributes)
            # Values after all definitions: HDF5 takes twice the time to change between them.
            defined = [_define(file, *each) for each in content.variables.items()]
            for variable, values in defined:
                variable[...] = values
        except BaseException:
            file.close()
            raise
        return bytes(file.close())


def from_bytes(data: bytes) -> FileContent:
    """What a file holds, of its content.

    Raises:
        OSError, RuntimeError: if it is no netCDF file, or a damaged one.
    """
    with _ONE_AT_A_TIME, closing(netCDF4.Dataset("content", mode="r", memory=data)) as file:
        # Every number is meant, and none is to be scaled.
        file.set_auto_maskandscale(False)
        variables = {name: _read(each) for name, each in file.variables.items()}
        return FileContent(variables, _attributes(file))


def _define(
    file: netCDF4.Dataset, name: str, variable: Variable
) -> tuple[netCDF4.Variable, np.ndarray]:
    """A variable of a file, and the values that are to be written to it."""
    values, notes = np.asarray(variable.values), dict(variable.attributes)
    kind: Any = values.dtype
    if kind.kind in "UO":
        # One text is no sequence of letters.
        kind, values = str, _texts(name, values)
    elif kind.kind == "b":
        kind, values, notes = np.dtype(np.int8), values.astype(np.int8), notes | _TRUTH
    elif kind.kind not in "iuf":
        raise TypeError(f"{name}: values of the type {kind} have no form in files")
    for dim, length in zip(variable.dims, values.shape, strict=True):
        if dim not in file.dimensions:
            file.createDimension(dim, length)
        if length != (known := len(file.dimensions[dim])):
            raise ValueError(f"{name}: {length} along {dim}, which has the length {known}")
    made = file.createVariable(name, kind, variable.dims)
    made.set_auto_maskandscale(False)
    made.setncatts(notes)
    return made, values


def _texts(name: str, values: np.ndarray) -> np.ndarray:
    texts = values.astype(object)
    if not all(isinstance(each, str) for each in texts.flat):
        raise TypeError(f"{name}: objects that are no texts have no form in files")
    return texts


def _read(found: netCDF4.Variable) -> Variable:
    notes = _attributes(found)
    values = np.asarray(found[...], dtype=str if found.dtype is str else None)
    if notes.get("dtype") == "bool":
        del notes["dtype"]
        values = values.astype(bool)
    return Variable(found.dimensions, values, notes)


def _attributes(found: netCDF4.Dataset | netCDF4.Variable) -> dict[str, Any]:
    return {name: found.getncattr(name) for name in found.ncattrs()}
