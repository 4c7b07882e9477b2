"""A sample's records as one dataset: every train, and what is estimated from all of them."""

import math
from typing import Any

import numpy as np
import xarray as xr

from celltrain.parameters import Scales, Train
from celltrain.parameters.dimension import LENGTH, Dimension
from celltrain.quantities import Quantity
from celltrain.study.collect import parameter_meaning
from celltrain.study.columns import WORDS
from celltrain.study.sampling.definition import SampledStudy
from celltrain.study.sampling.draws import COLUMNS, OUTPUTS
from celltrain.study.sampling.engine import Sampled
from celltrain.study.sampling.result import SampleResult
from celltrain.study.sampling.statistics import PROBABILITIES, WithErrors, estimated

# What outputs are measured in: scales may differ from train to train.
_UNITS = {
    "U/r0": Dimension("1/s", velocity=1, length=-1),
    "U": Dimension("m/s", velocity=1),
    "r0": LENGTH,
    "mu": Dimension("Pa s", viscosity=1),
}
_OF_TRAINS = ("matrix", "point")


def collect_sample(study: SampledStudy, sampled: Sampled) -> SampleResult:
    """All trains of a sample and their statistics, in r0, U and mu, or in SI as the study is.

    A number that is not there is NaN; `status` and `reason` say why.
    """
    shape = (len(study.matrices), study.sample.points)
    numbers = {name: np.full(shape, math.nan) for name in COLUMNS}
    parameters = {name: np.full(shape, math.nan) for name in study.names}
    status = np.full(shape, "not computed", dtype=object)
    reason = np.full(shape, "", dtype=object)
    si = study.units == "SI"
    for draw in study.draws:
        for name, value in draw.values.items():
            parameters[name][draw.index] = value
        record = sampled.records.get(draw.index)
        if record is None:
            continue
        status[draw.index], reason[draw.index] = record.status, record.reason
        for name, value in record.values.items():
            numbers[name][draw.index] = value * _factor(COLUMNS[name], draw.train, si=si)
    variables: dict[str, Any] = {
        name: (_OF_TRAINS, array, _attributes(COLUMNS[name], si=si))
        for name, array in numbers.items()
    }
    variables |= {
        name: (_OF_TRAINS, array, parameter_meaning(name, study.units))
        for name, array in parameters.items()
    }
    variables |= {
        "status": (_OF_TRAINS, status.astype(str), WORDS["status"].attributes),
        "reason": (_OF_TRAINS, reason.astype(str), WORDS["reason"].attributes),
    }
    values = np.stack([numbers[name] for name in OUTPUTS])
    found = estimated(values, indices=study.sample.indices, seed=study.sample.seed)
    variables |= _statistics(found)
    variables["central"] = (
        "output",
        _central(study, sampled),
        {"long_name": "of the train of the means"},
    )
    variables["distribution"] = (
        "parameter",
        [str(each) for each in study.distributions],
        {"long_name": "how the parameter differs from train to train"},
    )
    coordinates = {
        "matrix": ("matrix", list(study.matrices)),
        "output": ("output", list(OUTPUTS)),
        "parameter": ("parameter", list(study.names)),
        "probability": ("probability", list(PROBABILITIES)),
    }
    header = {
        "title": study.title,
        "case": study.central.to_toml(),
        "seed": study.sample.seed,
        "degree": int(sampled.central.values["taken_degree"] or 0),
        "central_error": _number(sampled.central.values["error_estimate"])
        * _factor(COLUMNS["error_estimate"], study.central, si=si),
        "complete_points": found.complete,
    }
    return SampleResult(xr.Dataset(variables, coords=coordinates, attrs=header))


def _statistics(found: WithErrors) -> dict[str, Any]:
    words = {
        "mean": (("output",), "mean over the trains"),
        "standard_deviation": (("output",), "standard deviation over the trains"),
        "quantile": (("output", "probability"), "quantiles over the trains"),
        "positive": (("output",), "part of the trains in which the output is positive"),
    }
    variables: dict[str, Any] = {}
    for name, (dims, meaning) in words.items():
        variables[name] = (dims, getattr(found.summary, name), {"long_name": meaning})
        error = {"long_name": f"standard error: {meaning}"}
        variables[f"{name}_error"] = (dims, getattr(found.error, name), error)
    if found.indices is None:
        return variables
    orders = {
        "first_order": "part of the variance that goes when the parameter is known",
        "total_order": "part of the variance that stays when all others are known",
    }
    parts = {"": found.indices, "_low": found.low, "_high": found.high}
    for name, meaning in orders.items():
        for ending, each in parts.items():
            what = meaning if not ending else f"end of the 95 % interval: {meaning}"
            variables[name + ending] = (
                ("output", "parameter"),
                getattr(each, name),
                {"long_name": what, "units": "1"},
            )
    return variables


def _central(study: SampledStudy, sampled: Sampled) -> list[float]:
    si = study.units == "SI"
    return [
        _number(sampled.central.values[name]) * _factor(meaning, study.central, si=si)
        for name, meaning in OUTPUTS.items()
    ]


def _number(value: float | None) -> float:
    return math.nan if value is None else value


def _factor(meaning: Quantity, train: Train, *, si: bool) -> float:
    """What a number in r0, U and mu is multiplied with."""
    scales: Scales = train.scales
    return scales.unit(_UNITS[meaning.unit]) if si and meaning.unit in _UNITS else 1.0


def _attributes(meaning: Quantity, *, si: bool) -> dict[str, str]:
    unit = _UNITS[meaning.unit].si if si and meaning.unit in _UNITS else meaning.unit
    return meaning.attributes | {"units": unit}
