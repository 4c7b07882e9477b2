"""Files' content beside xarray's, which reads and writes the same in its own way."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from netCDF4 import default_fillvals

from celltrain.results import read_dataset, write_dataset
from celltrain.results.content import FileContent, Variable, from_bytes, to_bytes
from celltrain.results.labelled import Labelled
from celltrain.results.netcdf import HEADER, content_of, result_of

CONTENT = FileContent(
    {
        "number": Variable((), np.array(-0.0), {"units": "U"}),
        "numbers": Variable(("m", "n"), np.array([[1.5, np.nan, np.inf], [-0.0, 1e-320, 0.1]]), {}),
        "short": Variable(("n",), np.arange(3, dtype=np.float32), {}),
        "counts": Variable(("n",), np.array([2**62, -1, 0]), {"ranks": np.array([1, 2])}),
        "bytes": Variable(("n",), np.array([1, 2, 255], dtype=np.uint8), {}),
        "truth": Variable(("n",), np.array([True, False, True]), {"long_name": "whether"}),
        "one_truth": Variable((), np.array(False), {}),
        "text": Variable((), np.array("α = 1\nand more"), {"kind": "a word"}),
        "texts": Variable(("m", "n"), np.array([["", "a", "bc"], ["é", " ", "x" * 99]]), {}),
        "objects": Variable(("m",), np.array(["one", "another"], dtype=object), {}),
        "nothing": Variable(("none", "n"), np.zeros((0, 3)), {}),
        "no_words": Variable(("none",), np.array([], dtype=str), {}),
    },
    {"title": "all that there is", "number": 3, "share": 0.5, "words": ["one", "two"]},
)


def dataset(content: FileContent) -> xr.Dataset:
    return xr.Dataset(content.variables, attrs=content.attributes)


def check(found: FileContent, expected: FileContent = CONTENT) -> None:
    assert set(found.variables) == set(expected.variables)
    for name, each in expected.variables.items():
        one = found.variables[name]
        assert one.dims == each.dims, name
        # Texts have the length of the longest.
        kind = "U" if each.values.dtype.kind in "UO" else each.values.dtype
        assert one.values.dtype == kind or one.values.dtype.kind == kind, name
        np.testing.assert_array_equal(one.values, each.values, err_msg=name)
        if each.values.dtype.kind == "f":
            np.testing.assert_array_equal(np.signbit(one.values), np.signbit(each.values))
    assert dataset(found).attrs.keys() == expected.attributes.keys()


def test_it_is_read_as_it_was() -> None:
    found = from_bytes(to_bytes(CONTENT))
    check(found)
    for name, each in CONTENT.variables.items():
        assert str(dict(found.variables[name].attributes)) == str(dict(each.attributes))
    assert found.attributes == CONTENT.attributes


def test_xarray_reads_it(tmp_path: Path) -> None:
    path = tmp_path / "content.nc"
    path.write_bytes(to_bytes(CONTENT))
    with xr.open_dataset(path, engine="netcdf4") as data:
        assert dataset(CONTENT).identical(data.load())
        assert data["truth"].dtype == bool


def test_what_xarray_writes_is_read() -> None:
    expected = dataset(CONTENT)
    encoding = {name: {"_FillValue": None} for name in expected.variables}
    written = expected.to_netcdf(None, engine="netcdf4", encoding=encoding)
    check(from_bytes(bytes(written)))


def test_every_number_is_meant() -> None:
    """Those by which netCDF fills what is not written, too, and whatever attributes say."""
    for name in ("f8", "f4", "i8", "i4", "i1"):
        values = np.array([default_fillvals[name], 1.0, 7.0]).astype(name)
        notes = {"scale_factor": 2.0, "add_offset": 1.0, "missing_value": values[1]}
        content = FileContent({"filled": Variable(("n",), values, notes)}, {})
        found = from_bytes(to_bytes(content)).variables["filled"].values
        assert type(found) is np.ndarray
        np.testing.assert_array_equal(found, values)


@pytest.mark.parametrize(
    "values", [np.zeros(2, complex), np.array([1, None]), np.array(["2026-01-01"], "datetime64[D]")]
)
def test_other_values_are_refused(values: Any) -> None:
    with pytest.raises(TypeError, match=r"^odd: .* no form in files"):
        to_bytes(FileContent({"odd": Variable(("n",), values, {})}, {}))
    # Nothing is left open.
    check(from_bytes(to_bytes(CONTENT)))


def test_other_lengths_of_a_dimension_are_refused() -> None:
    two = {name: Variable(("n",), np.zeros(size), {}) for name, size in (("a", 2), ("b", 3))}
    with pytest.raises(ValueError, match="b: 3 along n, which has the length 2"):
        to_bytes(FileContent(two, {}))


def test_coordinates_stay_coordinates(tmp_path: Path) -> None:
    """Of every kind: along a dimension, beside one, and of the whole."""
    coordinates = {
        "phi": ("phi", [0.1, 0.2], {"long_name": "packing"}),
        "label": ("phi", ["low", "high"]),
        # No date is made of it.
        "age": ("phi", [1.0, 2.0], {"units": "seconds since 2000-01-01"}),
        "diameter": 6.0,
    }
    data = xr.Dataset(
        {"alpha": (("phi", "m"), np.eye(2)), "whole": ((), 1.0)},
        coordinates,
        {"kind": "figure", "celltrain_version": "0", "form": 2},
    )
    assert read_dataset(write_dataset(data, tmp_path / "data.nc")).identical(data)
    with xr.open_dataset(tmp_path / "data.nc", engine="netcdf4", decode_times=False) as found:
        assert data.identical(found.load())


def test_a_labelled_result_is_without_the_files_own_attributes() -> None:
    data = xr.Dataset({"alpha": ("n", [1.0])}, {"n": [3]}, {"title": "mine", "made_with": "care"})
    result = Labelled(data)
    content = from_bytes(to_bytes(content_of(result)))
    assert set(HEADER) < set(content.attributes)
    assert content.attributes["title"] == "mine"
    assert result_of(Labelled, content) == result
