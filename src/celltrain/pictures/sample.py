"""A sample of trains: histograms of what they do, and from which parameters it varies."""

from functools import partial

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from celltrain.contract import Draw
from celltrain.pictures.study import axis_label
from celltrain.pictures.style import BLUE, SKY, VERMILION, in_style
from celltrain.quantities.fields import unit_label

#: Outputs that are drawn.
DRAWN = ("spectral_abscissa", "cell_velocity", "effective_viscosity")
# More points than this would only hide each other.
MOST_DOTS = 1000


def sample_pictures(data: xr.Dataset) -> dict[str, Draw]:
    """How histograms, dependences and indices of a sample are drawn, by their names."""
    if not (data["status"] == "finished").any():
        return {}
    found: dict[str, Draw] = {
        "distributions": partial(draw_distributions, data),
        "growth": partial(draw_growth, data),
    }
    if "first_order" in data:
        found["indices"] = partial(draw_indices, data)
    return found


@in_style()
def draw_distributions(data: xr.Dataset) -> Figure:
    """A histogram of each main output, with the train of the means and the middle 90 %."""
    figure = Figure(figsize=(10.0, 3.4), layout="constrained")
    for axes, name in zip(figure.subplots(1, len(DRAWN)), DRAWN, strict=True):
        output = data.sel(output=name)
        values = data[name].values
        finite = values[np.isfinite(values)]
        axes.hist(finite, bins=bin_count(finite), color=SKY, edgecolor="white", linewidth=0.3)
        quantiles = output["quantile"]
        low, high = (float(quantiles.sel(probability=part)) for part in (0.05, 0.95))
        axes.axvspan(low, high, color="0.9", zorder=0, label="5 to 95 %")
        axes.axvline(float(output["mean"]), color="0.2", linewidth=1.2, label="mean")
        central = float(output["central"])
        axes.axvline(
            central, color=VERMILION, linewidth=1.2, linestyle="--", label="train of the means"
        )
        axes.set_xlabel(output_label(data, name))
        axes.locator_params(axis="x", nbins=5)
        axes.margins(x=0.02)
    first = figure.axes[0]
    first.set_ylabel("trains")
    handles, labels = first.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper left", ncols=3)
    return figure


@in_style()
def draw_growth(data: xr.Dataset) -> Figure:
    """The growth rate over each parameter, a dot for each train."""
    names = [str(name) for name in data["parameter"].values]
    figure = Figure(figsize=(1.0 + 2.6 * len(names), 3.2), layout="constrained")
    panels = figure.subplots(1, len(names), sharey=True, squeeze=False)[0]
    # Of the first matrices alone: no two trains share a value there.
    rates = data["spectral_abscissa"].isel(matrix=slice(0, 2)).values.ravel()
    step = max(1, len(rates) // MOST_DOTS)
    for axes, name in zip(panels, names, strict=True):
        values = data[name].isel(matrix=slice(0, 2)).values.ravel()
        axes.plot(values[::step], rates[::step], ".", color=BLUE, markersize=2.5, alpha=0.5)
        axes.set_xlabel(axis_label(data[name]))
        axes.locator_params(axis="x", nbins=4)
        if np.nanmin(rates) < 0.0 < np.nanmax(rates):
            axes.axhline(0.0, color="0.6", linewidth=0.8)
    panels[0].set_ylabel(output_label(data, "spectral_abscissa"))
    return figure


@in_style()
def draw_indices(data: xr.Dataset) -> Figure:
    """First-order and total Sobol indices of each main output, with their 95 % intervals."""
    figure = Figure(figsize=(10.0, 3.6), layout="constrained")
    panels = figure.subplots(1, len(DRAWN), sharey=True)
    names = [str(name) for name in data["parameter"].values]
    places = np.arange(len(names))
    for axes, name in zip(panels, DRAWN, strict=True):
        output = data.sel(output=name)
        for order, offset, color, label in (
            ("first_order", -0.2, BLUE, "first order: alone"),
            ("total_order", 0.2, SKY, "total: with all others"),
        ):
            _bars(axes, output, order, places + offset, color, label)
        axes.axhline(0.0, color="0.3", linewidth=0.8)
        axes.set_xticks(places, [_symbol(data[each]) for each in names])
        axes.set_title(f"${data[name].attrs['symbol']}$", loc="left", fontsize=11)
        axes.tick_params(top=False)
    panels[0].set_ylabel("part of the variance")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper left", ncols=2)
    return figure


def output_label(data: xr.Dataset, name: str) -> str:
    """Symbol and unit of an output."""
    meaning = data[name].attrs
    return f"${meaning['symbol']}${unit_label(meaning['units'])}"


def _symbol(parameter: xr.DataArray) -> str:
    symbol = parameter.attrs["symbol"]
    return f"${symbol}$" if symbol else str(parameter.name).replace("_", " ")


def _bars(
    axes: Axes, output: xr.Dataset, order: str, places: np.ndarray, color: str, label: str
) -> None:
    values = output[order].values
    axes.bar(places, np.nan_to_num(values), 0.38, color=color, label=label)
    ends = [output[f"{order}_low"].values, output[f"{order}_high"].values]
    # The estimate may lie outside of the interval of the resamples.
    sizes = [np.clip(values - ends[0], 0.0, None), np.clip(ends[1] - values, 0.0, None)]
    axes.errorbar(places, values, np.nan_to_num(sizes), fmt="none", ecolor="0.2", capsize=2.5)


def bin_count(values: np.ndarray) -> int:
    """As many bins as a histogram of this many values shows without noise (Rice's rule)."""
    return int(np.clip(np.ceil(2.0 * len(values) ** (1.0 / 3.0)), 5, 40))
