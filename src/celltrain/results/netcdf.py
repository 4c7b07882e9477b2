"""Results as one self-describing netCDF4 file, and back, bit for bit."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Lock
from typing import TypeVar

import xarray as xr

from celltrain.quantities import Record
from celltrain.results.columns import from_variables, to_variables
from celltrain.results.labelled import Labelled
from celltrain.results.replace import replace_file
from celltrain.version import __version__

#: Number of the files' form: it grows when older files cannot be read any longer.
FORM = 2
UNITS = (
    "length r0 (radius of the sphere of a cell's volume), velocity U (mean velocity in the tube),"
    " viscosity mu (plasma)"
)

#: Attributes that all files have, apart from their title.
HEADER = ("kind", "celltrain_version", "form", "units")

Result = TypeVar("Result", bound=Record)

# netCDF's library runs in one thread at a time; an interrupted simulation is saved in another one
# than that which marches.
_ONE_AT_A_TIME = Lock()


class ForeignFile(ValueError):
    """A netCDF file that holds no result of this package."""


def to_dataset(result: Record) -> xr.Dataset:
    """The content of a result's file: a variable for each number, with its meaning and unit."""
    header = {
        "title": result.title,
        "kind": result.kind,
        "celltrain_version": __version__,
        "form": FORM,
        "units": UNITS,
    }
    if isinstance(result, Labelled):
        return result.data.assign_attrs(header | result.data.attrs)
    return xr.Dataset(to_variables(result), attrs=header)


def from_dataset(kind: type[Result], data: xr.Dataset) -> Result:
    """The result that a data set holds.

    Raises:
        ForeignFile: if it holds none of this kind.
        OSError: if it is of another version that this one cannot read.
    """
    with reading(data):
        if data.attrs.get("kind") != kind.kind:
            raise ForeignFile(f"it holds no {kind.kind}, but: {data.attrs.get('kind', 'nothing')}")
        if not issubclass(kind, Labelled):
            return from_variables(kind, data)
        kept = {name: each for name, each in data.attrs.items() if name not in HEADER}
        return kind(xr.Dataset(data.data_vars, data.coords, kept))


def save(result: Record, path: str | Path) -> Path:
    """Write a result to a netCDF4 file; returns the path.

    The file is written beside its final place and moved there when complete, so that a failure
    leaves nothing half-written, and a file of that name as it was.

    Raises:
        OSError: if the file cannot be written.
    """
    return write_dataset(to_dataset(result), Path(path))


def write_dataset(data: xr.Dataset, path: Path) -> Path:
    """Write a data set as `save` writes a result.

    Raises:
        OSError: if the file cannot be written.
    """
    content = content_of(data)
    replace_file(path, lambda part: part.write_bytes(content))
    return path


def content_of(data: xr.Dataset) -> memoryview:
    """A file's content, made in memory: a full disk leaves no library with a file to close."""
    # No fill values: every number is meant, and an infinite step is no gap in the data.
    encoding = {name: {"_FillValue": None} for name in data.variables}
    with _ONE_AT_A_TIME:
        return data.to_netcdf(None, engine="netcdf4", encoding=encoding)


def read_dataset(path: str | Path) -> xr.Dataset:
    """What a file of this package holds, in memory.

    Raises:
        OSError: if the file cannot be read.
        ForeignFile: if it is not of this package.
    """
    # Read by Python: netCDF's library opens no file whose name is not UTF-8.
    content = Path(path).read_bytes()
    try:
        with _ONE_AT_A_TIME, xr.open_dataset(content, engine="netcdf4", decode_times=False) as data:
            data.load()
    except (OSError, KeyError, ValueError, RuntimeError) as error:
        # What it says names the content in memory, not the file.
        raise ForeignFile(f"{str(path)!r} is no netCDF file, or a damaged one") from error
    if "kind" not in data.attrs or "celltrain_version" not in data.attrs:
        raise ForeignFile(f"{str(path)!r} is a netCDF file, but holds no result of celltrain")
    return data


def read(path: str | Path, kind: type[Result]) -> Result:
    """A result of a known kind.

    Raises:
        OSError: if the file cannot be read, or is of another version that this one cannot read.
        ForeignFile: if it holds no such result.
    """
    return read_as(kind, read_dataset(path), path)


def read_as(kind: type[Result], data: xr.Dataset, path: str | Path) -> Result:
    """A result of a known kind from what a file holds; `path` is told where it fails.

    Raises:
        OSError, ForeignFile: as `read`.
    """
    try:
        return from_dataset(kind, data)
    except (OSError, ForeignFile) as error:
        raise type(error)(f"{str(path)!r}: {error}") from None


@contextmanager
def reading(data: xr.Dataset) -> Iterator[None]:
    """Say of a file that cannot be read as it is which version wrote it.

    Raises:
        OSError: if the form is another one, or something is missing from the data.
    """
    form, writer = data.attrs.get("form", 1), data.attrs.get("celltrain_version", "unknown")
    age = "an older" if form < FORM else "a newer"
    if form != FORM:
        raise OSError(
            f"it was written by celltrain {writer} in {age} form ({form}; celltrain"
            f" {__version__} reads form {FORM}); "
            + ("it has to be computed anew" if form < FORM else "a newer celltrain is needed")
        )
    try:
        yield
    except KeyError as error:
        missing = str(error.args[0]).split(". ")[0]
        raise OSError(
            f"it was written by celltrain {writer} and lacks what celltrain {__version__} needs"
            f" ({missing}); it has to be computed anew"
        ) from None
