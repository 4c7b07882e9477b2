"""A study in the browser: its map or curves, and the train under each point."""

import math
import tomllib
from typing import Any

import numpy as np
import xarray as xr

from celltrain.explore.figures import INK, QUIET, Figure, axis, figure
from celltrain.parameters import CaseError, Train, merge_case
from celltrain.parameters.fields import plain_type
from celltrain.parameters.routing import DIMENSIONS, TAKEN
from celltrain.parameters.train import Units
from celltrain.pictures.style import BLUE, COLORS, VERMILION
from celltrain.study import StudyResult

#: What a map may show: name in the study, and how it is called.
SHOWN = {
    "spectral_abscissa": "growth rate α (U/r₀)",
    "numerical_abscissa": "initial growth rate η (U/r₀)",
    "gap": "gap between cells (r₀)",
    "effective_viscosity": "effective viscosity (µ)",
    "cell_velocity": "velocity of the cells (U)",
}

#: Coordinates of the ring around a case.
Ring = dict[str, list[object]]
NO_RING: Ring = {"x": [], "y": []}


def shown_numbers(study: StudyResult) -> dict[str, str]:
    """What can be shown of a study."""
    data = study.data
    return {
        name: words
        for name, words in SHOWN.items()
        if name in data and bool(np.isfinite(data[name]).any())
    }


def study_figure(study: StudyResult, name: str) -> Figure:
    """A number of a study over its axes: a map of the last two of them, or curves over one.

    Each point carries the place of its case; what further axes there are is at its first value.
    """
    values = study.data[name]
    dims = [str(each) for each in values.dims]
    fixed = dict.fromkeys(dims[:-2], 0)
    values = values.isel(fixed)
    label = SHOWN[name]
    if values.ndim == 1:
        return _curve(values, label)
    up, right = (str(each) for each in values.dims)
    x, y = _numbers(values[right]), _numbers(values[up])
    places = [[f"{row},{column}" for column in range(len(x))] for row in range(len(y))]
    grid = [[_finite(float(each)) for each in row] for row in values]
    return figure(
        [
            {
                "type": "heatmap",
                "x": x,
                "y": y,
                "z": grid,
                "zsmooth": "best" if min(values.shape) > 3 else False,
                "colorscale": "Viridis",
                "colorbar": {
                    "title": {"text": label, "side": "right", "font": {"size": 12}},
                    "thickness": 12,
                    "outlinewidth": 0,
                    "tickfont": {"size": 11, "color": QUIET},
                },
                "hoverinfo": "skip",
            },
            {
                "type": "contour",
                "x": x,
                "y": y,
                "z": grid,
                "contours": {"coloring": "none", "start": 0, "end": 0, "size": 1},
                "line": {"color": "#ffffff", "width": 2.5},
                "showscale": False,
                "hoverinfo": "skip",
            },
            *_cases(values, x, y, places, label),
            chosen_ring(),
        ],
        xaxis=axis(_words(values[right])),
        yaxis=axis(_words(values[up])),
    )


def first_place(study: StudyResult) -> str:
    """The place of the first case that has a steady train; of the first one if none has."""
    found = np.argwhere(np.isfinite(study.data["spectral_abscissa"].values))
    shape = study.data["spectral_abscissa"].shape
    return ",".join(str(each) for each in (found[0] if len(found) else [0] * len(shape)))


def train_at(study: StudyResult, place: str) -> Train:
    """The train of a case of a study, by its place in the figure.

    Raises:
        CaseError: for a place that is not in the study.
    """
    data = study.data
    dims = [str(each) for each in data["status"].dims]
    try:
        numbers = [int(each) for each in place.split(",")]
        index = [0] * (len(dims) - len(numbers)) + numbers
        case = data.isel(dict(zip(dims, index, strict=True)))
    except (ValueError, IndexError):
        raise CaseError(f"place = {place!r} is not allowed; allowed: a point of the map") from None
    # All at once: in SI a capillary number acts on the values of the other axes.
    values = {name: _kept(name, case[name].item()) for name in dims}
    train = merge_case(tomllib.loads(str(data.attrs["case"])), {"unusual": True})
    if units_of(study) == "SI":
        return merge_case(train.leaves("SI"), {**values, "units": "SI", "unusual": True})
    return train.changed(**values, unusual=True)


def units_of(study: StudyResult) -> Units:
    """The units of a study's axes; without any that have a dimension both are the same."""
    units = {name: study.data[name].attrs.get("units") for name in study.data["status"].dims}
    alike = all(unit in ("1", _unit(str(name))) for name, unit in units.items())
    return "dimensionless" if alike else "SI"


def place_of(study: StudyResult, train: Train) -> str | None:
    """The place of a train in a study's figures; None if it is none of the cases in them."""
    known = numbers_of(train, units_of(study))
    found = []
    for name in study.data["status"].dims:
        values = study.data[name].values.tolist()
        same = [index for index, each in enumerate(values) if _alike(each, known[str(name)])]
        if not same:
            return None
        found.append(same[0])
    # Of what further axes there are the first value is shown.
    place = ",".join(map(str, found[-2:]))
    return place if not any(found[:-2]) and equal(train_at(study, place), train) else None


def numbers_of(train: Train, units: Units) -> dict[str, object]:
    """All that may vary in a study, by name."""
    return {**train.leaves(units), "capillary_number": train.leaf("capillary_number")}


def equal(one: Train, other: Train) -> bool:
    """Whether two trains are the same but for rounding."""
    first, second = one.leaves("SI"), other.leaves("SI")
    return all(_alike(value, second[name]) for name, value in first.items())


def ring_at(study: StudyResult, place: str | None, name: str) -> Ring:
    """Where the ring stands around a case in the figure of a number; nowhere without a case."""
    if place is None:
        return NO_RING
    values = study.data[name]
    dims = [str(each) for each in values.dims]
    numbers = [int(each) for each in place.split(",")]
    across = _numbers(study.data[dims[-1]])[numbers[-1]]
    if len(dims) == 1:
        return {"x": [across], "y": [_finite(float(values[numbers[-1]]))]}
    return {"x": [across], "y": [_numbers(study.data[dims[-2]])[numbers[-2]]]}


def _cases(
    values: xr.DataArray, x: list[float], y: list[float], places: list[list[str]], label: str
) -> list[dict[str, object]]:
    """A dot for each case with a number, a cross for each without; they can be clicked."""
    traces: list[dict[str, object]] = []
    for known, symbol, size, color in (
        (True, "circle", 7, "rgba(255,255,255,0.85)"),
        (False, "x", 8, VERMILION),
    ):
        chosen = [
            (x[column], y[row], places[row][column], float(values[row, column]))
            for row in range(len(y))
            for column in range(len(x))
            if bool(np.isfinite(values[row, column])) == known
        ]
        if not chosen:
            continue
        traces.append(
            {
                "type": "scatter",
                "mode": "markers",
                "x": [each[0] for each in chosen],
                "y": [each[1] for each in chosen],
                "customdata": [each[2] for each in chosen],
                "text": [f"{each[3]:.4g}" if known else "no steady train" for each in chosen],
                "marker": {
                    "symbol": symbol,
                    "size": size,
                    "color": color,
                    "line": {"color": INK, "width": 0.8},
                },
                "hovertemplate": f"(%{{x:.4g}}, %{{y:.4g}})<br>{label}: %{{text}}<extra></extra>",
            }
        )
    return traces


def _curve(values: xr.DataArray, label: str) -> Figure:
    [name] = (str(each) for each in values.dims)
    x = _numbers(values[name])
    trace: dict[str, object] = {
        "type": "scatter",
        "mode": "lines+markers",
        "x": x,
        "y": [_finite(float(each)) for each in values],
        "customdata": [str(place) for place in range(len(x))],
        "line": {"color": COLORS[0], "width": 1.8},
        "marker": {"color": BLUE, "size": 8},
        "hovertemplate": f"%{{x:.4g}}: {label} %{{y:.4g}}<extra></extra>",
    }
    return figure([trace, chosen_ring()], xaxis=axis(_words(values[name])), yaxis=axis(label))


def chosen_ring(color: str = "#ffffff") -> dict[str, object]:
    """A ring around the case that is shown; last of all traces."""
    look = {"symbol": "circle-open", "size": 17, "color": color, "line": {"width": 3}}
    return {"type": "scatter", "mode": "markers", **NO_RING, "marker": look, "hoverinfo": "skip"}


def _numbers(axis: xr.DataArray) -> list[Any]:
    values = axis.values
    return [each if isinstance(each, str) else float(each) for each in values.tolist()]


def _alike(one: object, other: object) -> bool:
    if isinstance(one, int | float) and isinstance(other, int | float):
        return math.isclose(one, other, rel_tol=1e-9)
    return one == other


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def _kept(name: str, value: object) -> object:
    """A value of an axis as a case has it: whole numbers are kept as others."""
    whole = name in TAKEN and plain_type(TAKEN[name]) is int
    return int(value) if whole and isinstance(value, float) else value


def _words(axis: xr.DataArray) -> str:
    name, unit = str(axis.name), axis.attrs.get("units", "1")
    words = name.replace("_", " ")
    return words if unit == "1" else f"{words} ({unit.replace('r0', 'r₀')})"


def _unit(name: str) -> str | None:
    return DIMENSIONS[name].unit if name in DIMENSIONS else None
