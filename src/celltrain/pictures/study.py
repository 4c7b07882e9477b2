"""A study's numbers over its axes: maps with contours, or curves."""

from functools import partial

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from celltrain.contract import Draw
from celltrain.parameters.fields import symbol
from celltrain.parameters.routing import DIMENSIONS, TAKEN
from celltrain.pictures.style import color_bar, in_style
from celltrain.quantities.fields import unit_label

#: What is drawn of a study.
DRAWN = ("spectral_abscissa", "numerical_abscissa", "gap", "effective_viscosity")


def _label(text: str, unit: str) -> str:
    """A symbol over its unit, such as ``$D/r_0$``."""
    measured = unit.replace("mu", r"\mu").replace("r0", "r_0")
    over = f"({measured})" if " " in measured or "/" in measured else measured
    return f"${text}$" if unit == "1" else f"${text}/{over}$"


#: How axes of studies are called in pictures; a figure of the paper calls its own Ca.
LABELS = {
    name: _label(text, DIMENSIONS[name].unit)
    for name, field in TAKEN.items()
    if (text := symbol(field)) is not None
} | {"Ca": "Ca"}
# More curves than this are drawn as a map.
MOST_CURVES = 4


def study_pictures(data: xr.Dataset) -> dict[str, Draw]:
    """How each number of a study that matters is drawn, by its name.

    One picture for each pair of values of the third and further axes, side by side, would be many;
    only studies with one or two axes of numbers are drawn.
    """
    names = [str(name) for name in data["spectral_abscissa"].dims]
    if len(names) > 2 or any(data[name].dtype.kind not in "fi" for name in names):
        return {}
    return {name: partial(_draw, data, name) for name in DRAWN if np.isfinite(data[name]).any()}


def axis_label(axis: xr.DataArray) -> str:
    """The symbol of an axis with its unit, which is that of the study's file."""
    name, unit = str(axis.name), axis.attrs.get("units", "")
    known = DIMENSIONS.get(name)
    text = axis.attrs.get("symbol", "")
    if not text or unit in ("", "1") or (known is not None and unit == known.unit):
        return LABELS.get(name, name.replace("_", " "))
    return f"${text}$ ({unit})"


@in_style()
def _draw(data: xr.Dataset, name: str) -> Figure:
    values = data[name]
    label = f"${values.attrs['symbol']}${unit_label(values.attrs['units'])}"
    figure = Figure(figsize=(6.0, 4.5), layout="constrained")
    axes = figure.subplots()
    if values.ndim == 2 and min(values.shape) > MOST_CURVES:
        draw_map(axes, values, label)
    else:
        errors = data.get("error_estimate") if name == "spectral_abscissa" else None
        draw_curves(axes, values, label, errors)
    return figure


def draw_map(axes: Axes, values: xr.DataArray, label: str) -> None:
    """Contours of a number over two axes, the last one to the right; failed cases are crosses."""
    up, right = (str(name) for name in values.dims)
    x, y = values[right].values, values[up].values
    filled = axes.contourf(x, y, np.ma.masked_invalid(values.values), levels=12, cmap="viridis")
    lines = axes.contour(
        x, y, np.ma.masked_invalid(values.values), levels=filled.levels, colors="k", linewidths=0.4
    )
    axes.clabel(lines, fontsize=7)
    mark_cases(axes, values)
    color_bar(axes, filled, label)
    axes.set(xlabel=axis_label(values[right]), ylabel=axis_label(values[up]))


def mark_cases(axes: Axes, values: xr.DataArray) -> None:
    """A dot for each case with a number, a cross for each without."""
    up, right = (str(name) for name in values.dims)
    x, y = np.meshgrid(values[right].values, values[up].values)
    known = np.isfinite(values.values)
    axes.plot(x[known], y[known], "k.", markersize=2.5)
    axes.plot(x[~known], y[~known], "rx", markersize=5)


def draw_curves(axes: Axes, values: xr.DataArray, label: str, errors: xr.DataArray | None) -> None:
    """Curves of a number over the longer axis, one for each value of the other, with error bars."""
    names = sorted((str(name) for name in values.dims), key=lambda name: values.sizes[name])
    right = names[-1]
    others = names[:-1]
    curves = values[others[0]].values if others else [None]
    for value in curves:
        chosen = {} if value is None else {others[0]: value}
        curve = values.sel(chosen)
        bars = None if errors is None else np.nan_to_num(errors.sel(chosen).values)
        axes.errorbar(
            curve[right].values,
            curve.values,
            bars,
            fmt="o-",
            markersize=3.5,
            capsize=2,
            label=None if value is None else f"{axis_label(values[others[0]])} = {value:g}",
        )
    if others:
        axes.legend()
    if (values < 0).any():
        axes.axhline(0.0, color="0.6", linewidth=0.8)
    axes.set(xlabel=axis_label(values[right]), ylabel=label)
