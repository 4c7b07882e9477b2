"""A study's records as one dataset over its axes."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from celltrain.parameters import Scales
from celltrain.parameters.fields import dimension, symbol
from celltrain.parameters.routing import TAKEN
from celltrain.study.columns import COLUMNS, WORDS, further
from celltrain.study.definition import Axis, Study
from celltrain.study.result import StudyResult
from celltrain.study.store import CaseRecord

Records = Mapping[tuple[int, ...], CaseRecord]


def collect(study: Study, records: Records) -> StudyResult:
    """The numbers of all cases over the study's axes, in r0, U and mu.

    Axes are in the units of the study file. A number that is not there is NaN; `status` and
    `reason` say why, `origin` how each steady train was reached.
    """
    names = tuple(axis.name for axis in study.axes)
    shape = tuple(len(axis.values) for axis in study.axes)
    columns = COLUMNS | further(study.computed.analyses)
    numbers = {name: np.full(shape, math.nan) for name in columns}
    words = {name: np.full(shape, "", dtype=object) for name in WORDS}
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
        name: (names, array, columns[name].meaning.attributes) for name, array in numbers.items()
    }
    variables |= {
        name: (names, array.astype(str), WORDS[name].attributes) for name, array in words.items()
    }
    coordinates = {
        axis.name: (axis.name, _values(axis), parameter_meaning(axis.name, study.units))
        for axis in study.axes
    }
    header = {
        "title": study.title,
        # A case in full, from which the others differ by the axes' values.
        "case": study.cases[0].train.to_toml(),
    }
    return StudyResult(xr.Dataset(variables, coords=coordinates, attrs=header))


def parameter_meaning(name: str, units: str) -> dict[str, str]:
    """Attributes of a parameter, whose values are in the units of the study file."""
    taken = TAKEN.get(name) or Scales.model_fields[name]
    measured = dimension(taken)
    return {
        "long_name": str(taken.description),
        "units": (measured.si if units == "SI" else measured.unit) or "1",
        "symbol": symbol(taken) or "",
    }


def _values(axis: Axis) -> np.ndarray:
    if any(isinstance(value, str) for value in axis.values):
        return np.array(axis.values, dtype=str)
    return np.array(axis.values, dtype=float)
