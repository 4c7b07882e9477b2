"""A study's results as one dataset over its axes, and as a table."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from celltrain.results import replace_file
from celltrain.results.version import version
from celltrain.study.definition import Axis, Case, Study, describe
from celltrain.study.quantities import study_attributes
from celltrain.study.store import Record

#: Numbers of each case, by their names among `STUDY_QUANTITIES`.
NUMBERS = (
    "cell_velocity",
    "gap",
    "largest_radius",
    "effective_viscosity",
    "residual",
    "truncation_error",
    "velocity_error",
    "spectral_abscissa",
    "error_estimate",
    "taken_degree",
    "leading_azimuthal_number",
    "leading_wave_number",
    "leading_frequency",
    "tumbling",
    "tank_treading",
    "axisymmetric_growth_rate",
    "numerical_abscissa",
    "transient_azimuthal_number",
    "transient_wave_number",
    "case_seconds",
)
#: Columns of the table: heading, name, format.
COLUMNS = (
    ("alpha, U/r0", "spectral_abscissa", ".2e"),
    ("its error", "error_estimate", ".0e"),
    ("M", "taken_degree", ".0f"),
    ("m", "leading_azimuthal_number", ".0f"),
    ("j", "leading_wave_number", ".0f"),
    ("eta, U/r0", "numerical_abscissa", ".3f"),
    ("U_c, U", "cell_velocity", ".5f"),
    ("gap, r0", "gap", ".4f"),
    ("viscosity, mu", "effective_viscosity", ".5f"),
    ("residual, U", "residual", ".0e"),
)

Records = Mapping[tuple[int, ...], Record]


def study_dataset(study: Study, records: Records) -> xr.Dataset:
    """The numbers of all cases over the study's axes, in r0, U and mu.

    Axes are in the units of the study file. A number that is not there is NaN; `status` and
    `reason` say why, `origin` how each steady train was reached.
    """
    names = tuple(axis.name for axis in study.axes)
    shape = tuple(len(axis.values) for axis in study.axes)
    numbers = {name: np.full(shape, math.nan) for name in NUMBERS}
    words = {name: np.full(shape, "", dtype=object) for name in ("status", "reason", "origin")}
    for case in study.cases:
        record = records.get(case.index)
        words["status"][case.index] = record.status if record else "not computed"
        if record is None:
            continue
        words["reason"][case.index] = record.reason
        words["origin"][case.index] = record.origin
        for name, array in numbers.items():
            value = record.values.get(name)
            array[case.index] = math.nan if value is None else value
    variables: dict[str, Any] = {
        name: (names, array, study_attributes(name)) for name, array in numbers.items()
    }
    variables |= {
        name: (names, array.astype(str), study_attributes(name)) for name, array in words.items()
    }
    coordinates = {axis.name: (axis.name, _values(axis)) for axis in study.axes}
    header = {
        "title": study.title,
        "kind": "study",
        "celltrain_version": version(),
        "units": "length r0 (radius of the sphere of a cell's volume), velocity U (mean velocity in"
        " the tube), viscosity mu (plasma); axes as in the study file",
        # A case in full, from which the others differ by the axes' values.
        "case": study.cases[0].train.to_toml(),
    }
    return xr.Dataset(variables, coords=coordinates, attrs=header)


def _values(axis: Axis) -> np.ndarray:
    if any(isinstance(value, str) for value in axis.values):
        return np.array(axis.values, dtype=str)
    return np.array(axis.values, dtype=float)


def save_dataset(data: xr.Dataset, path: Path) -> Path:
    """Write a study's dataset to a netCDF file, replaced at once; returns the path.

    **Raises:** `OSError` if it cannot be written.
    """
    encoding = {name: {"_FillValue": None} for name in data.variables}

    def write(part: Path) -> None:
        data.to_netcdf(part, engine="h5netcdf", encoding=encoding)

    replace_file(path, write)
    return path


def table(study: Study, records: Records) -> str:
    """A study's results as a table in Markdown, a line for each case."""
    headings = [axis.name for axis in study.axes] + [heading for heading, *_ in COLUMNS]
    lines = [f"| {' | '.join(headings)} |", "|" + "---|" * len(headings)]
    for case in study.cases:
        lines.append(f"| {' | '.join(_row(case, records.get(case.index)))} |")
    failed = [
        (case, record)
        for case in study.cases
        if (record := records.get(case.index)) is not None and record.status == "failed"
    ]
    if failed:
        lines += ["", "Failed:", ""]
        lines += [f"- {describe(case.values)}: {_line(record.reason)}" for case, record in failed]
    return "\n".join(lines) + "\n"


def _row(case: Case, record: Record | None) -> list[str]:
    cells = [value if isinstance(value, str) else f"{value:g}" for value in case.values.values()]
    for _, name, form in COLUMNS:
        value = record.values.get(name) if record else None
        cells.append("" if value is None else format(value, form))
    return cells


def _line(reason: str) -> str:
    return " ".join(reason.split())
