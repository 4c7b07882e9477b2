"""Results as one self-describing netCDF4 file, and back, bit for bit."""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar

from celltrain.quantities import Record
from celltrain.results.columns import from_variables, to_variables
from celltrain.results.content import FileContent, from_bytes, to_bytes
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


class ForeignFile(ValueError):
    """A netCDF file that holds no result of this package."""


class OwnContent(Record, ABC):
    """A result that says itself what its file holds; what others hold follows from their fields."""

    @abstractmethod
    def content(self) -> FileContent:
        """Its variables and attributes, without what all files say of themselves."""

    @classmethod
    @abstractmethod
    def of_content(cls: type[Result], content: FileContent) -> Result:
        """The result of what its file holds."""


def content_of(result: Record) -> FileContent:
    """What a result's file holds: a variable for each number, with its meaning and unit."""
    header = {
        "title": result.title,
        "kind": result.kind,
        "celltrain_version": __version__,
        "form": FORM,
        "units": UNITS,
    }
    if isinstance(result, OwnContent):
        own = result.content()
        return FileContent(own.variables, {**header, **own.attributes})
    return FileContent(to_variables(result), header)


def result_of(kind: type[Result], content: FileContent) -> Result:
    """The result that a file holds.

    Raises:
        ForeignFile: if it holds none of this kind.
        OSError: if it is of another version that this one cannot read.
    """
    with _reading(content):
        found = content.attributes.get("kind", "nothing")
        if found != kind.kind:
            raise ForeignFile(f"it holds no {kind.kind}, but: {found}")
        if issubclass(kind, OwnContent):
            return kind.of_content(content)
        return from_variables(kind, content.variables)


def save(result: Record, path: str | Path) -> Path:
    """Write a result to a netCDF4 file; returns the path.

    The file is written beside its final place and moved there when complete, so that a failure
    leaves nothing half-written, and a file of that name as it was.

    Raises:
        OSError: if the file cannot be written.
    """
    return write_content(content_of(result), Path(path))


def write_content(content: FileContent, path: Path) -> Path:
    """Write what a file is to hold, as `save` writes a result.

    Raises:
        OSError: if the file cannot be written.
        TypeError: for values of a type that has no form in files.
    """
    data = to_bytes(content)
    replace_file(path, lambda part: part.write_bytes(data))
    return path


def read_content(path: str | Path) -> FileContent:
    """What a file of this package holds.

    Raises:
        OSError: if the file cannot be read.
        ForeignFile: if it is not of this package.
    """
    # Read by Python: netCDF's library opens no file whose name is not UTF-8.
    data = Path(path).read_bytes()
    try:
        content = from_bytes(data)
    except (OSError, KeyError, ValueError, RuntimeError) as error:
        # What it says names the content in memory, not the file.
        raise ForeignFile(f"{str(path)!r} is no netCDF file, or a damaged one") from error
    if not {"kind", "celltrain_version"} <= set(content.attributes):
        raise ForeignFile(f"{str(path)!r} is a netCDF file, but holds no result of celltrain")
    return content


def read(path: str | Path, kind: type[Result]) -> Result:
    """A result of a known kind.

    Raises:
        OSError: if the file cannot be read, or is of another version that this one cannot read.
        ForeignFile: if it holds no such result.
    """
    return read_as(kind, read_content(path), path)


def read_as(kind: type[Result], content: FileContent, path: str | Path) -> Result:
    """A result of a known kind from what a file holds; `path` is told where it fails.

    Raises:
        OSError, ForeignFile: as `read`.
    """
    try:
        return result_of(kind, content)
    except (OSError, ForeignFile) as error:
        raise type(error)(f"{str(path)!r}: {error}") from None


@contextmanager
def _reading(content: FileContent) -> Iterator[None]:
    """Say of a file that cannot be read as it is which version wrote it.

    Raises:
        OSError: if the form is another one, or something is missing from it.
    """
    form = content.attributes.get("form", 1)
    writer = content.attributes.get("celltrain_version", "unknown")
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
