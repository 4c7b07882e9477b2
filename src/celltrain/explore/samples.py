"""A study of distributions in the browser: histograms, indices, and the trains to be opened."""

import itertools
import tomllib

import numpy as np
import xarray as xr

from celltrain.explore.figures import INK, OTHERS, Figure, axis, figure
from celltrain.explore.maps import NO_RING, Ring, chosen_ring, equal, numbers_of
from celltrain.explore.report import Row, row
from celltrain.parameters import CaseError, Train, merge_case
from celltrain.parameters.train import Units
from celltrain.pictures.sample import DRAWN, MOST_DOTS, bin_count
from celltrain.pictures.style import BLUE, SKY, VERMILION
from celltrain.study.sampling.result import SampleResult

_WORDS = {
    "spectral_abscissa": "growth rate α",
    "cell_velocity": "velocity of the cells",
    "effective_viscosity": "apparent viscosity",
}
# What a name begins with, and what its figure shows.
_HISTOGRAM, _OVER, _INDICES = "distribution of ", "over ", "indices of "


def sample_figures(sample: SampleResult) -> dict[str, str]:
    """What is drawn of a sample, by name: in what order, and what it is called."""
    data = sample.data
    if not (data["status"] == "finished").any():
        return {}
    found = {_HISTOGRAM + name: f"Distribution: {_WORDS[name]}" for name in DRAWN}
    for parameter in _parameters(data):
        found[_OVER + parameter] = f"Growth rate over {parameter.replace('_', ' ')}"
    if "first_order" in data:
        found |= {_INDICES + name: f"Sobol indices: {_WORDS[name]}" for name in DRAWN}
    return found


def sample_note(name: str) -> str:
    """What is seen in a figure of a sample."""
    if name.startswith(_HISTOGRAM):
        return "grey: 5 to 95 %; line: mean; dashed: train of the means"
    return "with 95 % intervals" if name.startswith(_INDICES) else "a dot for each train"


def sample_figure(sample: SampleResult, name: str) -> Figure:
    """A figure of a sample, by a name of `sample_figures`."""
    data = sample.data
    if name.startswith(_HISTOGRAM):
        return _histogram(data, name.removeprefix(_HISTOGRAM))
    if name.startswith(_INDICES):
        return _indices(data, name.removeprefix(_INDICES))
    return _over(data, name.removeprefix(_OVER))


def sample_ring(sample: SampleResult, place: str | None, name: str) -> Ring | None:
    """Where the ring stands around a train, in figures that have one; nowhere without a train."""
    if not name.startswith(_OVER):
        return None
    if place is None:
        return NO_RING
    train = sample.data.isel(_index(sample, place))
    parameter, rate = train[name.removeprefix(_OVER)], train["spectral_abscissa"]
    return {"x": [float(parameter)], "y": [float(rate)]}


def sample_place(sample: SampleResult, train: Train) -> str | None:
    """The place of a train in a sample; None if it is none of its trains."""
    data, known = sample.data, numbers_of(train, sample_units(sample))
    values = [known[name] for name in _parameters(data)]
    if not all(isinstance(value, int | float) for value in values):
        return None
    same = np.ones(data["status"].shape, bool)
    for name, value in zip(_parameters(data), values, strict=True):
        same &= np.isclose(data[name].values, float(value), rtol=1e-9, atol=0.0)  # type: ignore[arg-type]
    places = (",".join(map(str, index)) for index in np.argwhere(same))
    return next((each for each in places if equal(sample_train(sample, each), train)), None)


def sample_train(sample: SampleResult, place: str | None = None) -> Train:
    """A train of a sample by its matrix and point, such as ``"0,12"``, or that of the means.

    Raises:
        CaseError: for a place that is not in the sample.
    """
    data = sample.data
    central = merge_case(tomllib.loads(str(data.attrs["case"])), {"unusual": True})
    if place is None:
        return central
    drawn = data.isel(_index(sample, place))
    values: dict[str, object] = {name: float(drawn[name]) for name in _parameters(data)}
    if sample_units(sample) == "SI":
        return merge_case(central.leaves("SI"), {**values, "units": "SI", "unusual": True})
    return central.changed(**values, unusual=True)


def sample_units(sample: SampleResult) -> Units:
    """The units of a sample's parameters and outputs."""
    dimensionless = sample.data["spectral_abscissa"].attrs["units"] == "U/r0"
    return "dimensionless" if dimensionless else "SI"


def sample_headline(sample: SampleResult) -> str:
    """A sentence on the sample."""
    data = sample.data
    alpha = data.sel(output="spectral_abscissa")
    unstable, error = (100.0 * float(alpha[name]) for name in ("positive", "positive_error"))
    finished = int((data["status"] == "finished").sum())
    failed = f", {sample.failed} failed" if sample.failed else ""
    spread = f" ± {error:.1g}" if error > 0.0 else ""
    return (
        f"{finished} trains of {data['status'].size}{failed}; unstable (α > 0):"
        f" {unstable:.3g}{spread} %."
    )


def sample_rows(sample: SampleResult) -> list[Row]:
    """Mean, standard deviation and quantiles of each output that is drawn, with their errors."""
    found = []
    for name in DRAWN:
        output, unit = sample.data.sel(output=name), _unit(sample.data[name])
        words = _WORDS[name]
        found.append(row(f"{words}, train of the means", float(output["central"]), np.nan, unit))
        for each in ("mean", "standard_deviation"):
            error = float(output[f"{each}_error"])
            called = f"{words}, {each.replace('_', ' ')}"
            found.append(row(called, float(output[each]), error, unit))
        for part in output["probability"].values:
            value, error = (
                float(output[each].sel(probability=part)) for each in ("quantile", "quantile_error")
            )
            found.append(row(f"{words}, {100 * part:g} % are below", value, error, unit))
    return found


def _histogram(data: xr.Dataset, name: str) -> Figure:
    values = data[name].values
    finite = values[np.isfinite(values)]
    counts, edges = np.histogram(finite, bins=bin_count(finite))
    output, unit = data.sel(output=name), _unit(data[name])
    low, high = (float(output["quantile"].sel(probability=each)) for each in (0.05, 0.95))
    lines = ((float(output["mean"]), INK, "solid"), (float(output["central"]), VERMILION, "dash"))
    bars = {
        "type": "bar",
        "x": (0.5 * (edges[1:] + edges[:-1])).tolist(),
        "y": counts.tolist(),
        "width": np.diff(edges).tolist(),
        "text": [f"{a:.4g} to {b:.4g}" for a, b in itertools.pairwise(edges)],
        "textposition": "none",
        "marker": {"color": SKY, "line": {"color": "#ffffff", "width": 1}},
        "hovertemplate": "%{text}: %{y} trains<extra></extra>",
    }
    across = {"yref": "paper", "y0": 0, "y1": 1, "layer": "below"}
    return figure(
        [bars],
        xaxis=axis(_WORDS[name] + (f" ({unit})" if unit else "")),
        yaxis=axis("trains"),
        shapes=[
            {
                "type": "rect",
                "x0": low,
                "x1": high,
                "fillcolor": "#eef1f4",
                "line": {"width": 0},
                **across,
            },
            *(
                {
                    "type": "line",
                    "x0": x,
                    "x1": x,
                    "line": {"color": color, "width": 1.4, "dash": dash},
                    **across,
                    "layer": "above",
                }
                for x, color, dash in lines
                if np.isfinite(x)
            ),
        ],
    )


def _over(data: xr.Dataset, parameter: str) -> Figure:
    # Of the first matrices alone: no two trains share a value there.
    values = data[parameter].isel(matrix=slice(0, 2)).values
    rates = data["spectral_abscissa"].isel(matrix=slice(0, 2)).values
    known = np.argwhere(np.isfinite(rates))
    known = known[:: max(1, -(-len(known) // MOST_DOTS))]
    places = known[:, 0], known[:, 1]
    rate_unit, unit = _unit(data["spectral_abscissa"]), _unit(data[parameter])
    words = parameter.replace("_", " ")
    dots = {
        "type": "scatter",
        "mode": "markers",
        "x": values[places].tolist(),
        "y": rates[places].tolist(),
        "customdata": [f"{matrix},{point}" for matrix, point in known],
        "marker": {"color": BLUE, "size": 6, "opacity": 0.6},
        "hovertemplate": f"{words} %{{x:.4g}}: α = %{{y:.4g}} {rate_unit}<extra></extra>",
    }
    zero = {"type": "line", "xref": "paper", "x0": 0, "x1": 1, "y0": 0, "y1": 0}
    crosses = bool(rates[places].min() < 0.0 < rates[places].max())
    return figure(
        [dots, chosen_ring(VERMILION)],
        xaxis=axis(words + (f" ({unit})" if unit else "")),
        yaxis=axis(f"growth rate α ({rate_unit})"),
        shapes=[{**zero, "line": {"color": OTHERS, "width": 1}}] if crosses else [],
    )


def _indices(data: xr.Dataset, name: str) -> Figure:
    output, names = data.sel(output=name), _parameters(data)
    bars: list[dict[str, object]] = []
    for order, color, words in (
        ("first_order", BLUE, "first order: alone"),
        ("total_order", SKY, "total: with all others"),
    ):
        value, low, high = (output[order + end].values for end in ("", "_low", "_high"))
        # The estimate may lie outside of the interval of the resamples.
        above, below = np.clip(high - value, 0.0, None), np.clip(value - low, 0.0, None)
        bars.append(
            {
                "type": "bar",
                "name": words,
                "x": [each.replace("_", " ") for each in names],
                "y": _finite(value),
                "error_y": {
                    "type": "data",
                    "symmetric": False,
                    "array": _finite(above),
                    "arrayminus": _finite(below),
                    "color": INK,
                    "thickness": 1,
                },
                "marker": {"color": color},
                "hovertemplate": f"%{{x}}, {words}: %{{y:.3f}}<extra></extra>",
            }
        )
    return figure(
        bars,
        barmode="group",
        xaxis=axis(""),
        yaxis=axis("part of the variance"),
        showlegend=True,
        legend={"orientation": "h", "x": 0, "y": 1.12, "font": {"size": 11}},
    )


def _parameters(data: xr.Dataset) -> list[str]:
    return [str(name) for name in data["parameter"].values]


def _index(sample: SampleResult, place: str) -> dict[str, int]:
    sizes = sample.data.sizes
    try:
        matrix, point = (int(each) for each in place.split(","))
    except ValueError:
        matrix = point = -1
    if not (0 <= matrix < sizes["matrix"] and 0 <= point < sizes["point"]):
        raise CaseError(f"place = {place!r} is not allowed; allowed: a point of the figure")
    return {"matrix": matrix, "point": point}


def _finite(values: np.ndarray) -> list[float | None]:
    return [float(each) if np.isfinite(each) else None for each in values]


def _unit(values: xr.DataArray) -> str:
    unit = str(values.attrs.get("units", "1"))
    return "" if unit == "1" else unit.replace("r0", "r₀").replace("mu", "µ")
