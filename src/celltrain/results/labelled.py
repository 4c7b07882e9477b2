"""Results that are a data set with labelled axes themselves, and xarray's data sets of any."""

from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import xarray as xr
from xarray.conventions import encode_dataset_coordinates

from celltrain.quantities import Record
from celltrain.results.content import FileContent, Variable
from celltrain.results.netcdf import (
    HEADER,
    OwnContent,
    content_of,
    read_content,
    result_of,
    write_content,
)

Result = TypeVar("Result", bound=Record)
LabelledResult = TypeVar("LabelledResult", bound="Labelled")


@dataclass(frozen=True, eq=False)
class Labelled(OwnContent):
    """Numbers over labelled axes; what they mean are the attributes of the variables."""

    data: xr.Dataset

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Labelled) and self.data.identical(other.data)

    def content(self) -> FileContent:
        """Its variables and attributes."""
        return _content(self.data)

    @classmethod
    def of_content(cls: type[LabelledResult], content: FileContent) -> LabelledResult:
        """The data set, without what files say of themselves."""
        data = _dataset(content)
        kept = {name: each for name, each in data.attrs.items() if name not in HEADER}
        return cls(xr.Dataset(data.data_vars, data.coords, kept))


def to_dataset(result: Record) -> xr.Dataset:
    """The content of a result's file: a variable for each number, with its meaning and unit."""
    return _dataset(content_of(result))


def from_dataset(kind: type[Result], data: xr.Dataset) -> Result:
    """The result that a data set holds.

    Raises:
        ForeignFile: if it holds none of this kind.
        OSError: if it is of another version that this one cannot read.
    """
    return result_of(kind, _content(data))


def write_dataset(data: xr.Dataset, path: Path) -> Path:
    """Write a data set as `save` writes a result.

    Raises:
        OSError: if the file cannot be written.
        TypeError: for values of a type that has no form in files.
    """
    return write_content(_content(data), path)


def read_dataset(path: str | Path) -> xr.Dataset:
    """What a file of this package holds, in memory.

    Raises:
        OSError: if the file cannot be read.
        ForeignFile: if it is not of this package.
    """
    return _dataset(read_content(path))


def _content(data: xr.Dataset) -> FileContent:
    # Which variables are coordinates is said in attributes, as the CF conventions have it.
    variables, attributes = encode_dataset_coordinates(data)
    return FileContent(
        {str(n): Variable(each.dims, each.values, each.attrs) for n, each in variables.items()},
        attributes,
    )


def _dataset(content: FileContent) -> xr.Dataset:
    return xr.decode_cf(xr.Dataset(content.variables, attrs=content.attributes), decode_times=False)
