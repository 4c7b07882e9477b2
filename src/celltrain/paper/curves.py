"""Curves of a study's numbers, drawn as the paper draws them."""

import itertools

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from celltrain.pictures.study import LABELS

#: Width and height of one pair of axes, inches.
SIZE = (4.2, 3.5)
MARKERS = "osv^Dx"


def side_by_side(count: int) -> tuple[Figure, list[Axes]]:
    """A figure with axes beside each other, lettered as in the paper."""
    figure = Figure(figsize=(SIZE[0] * count, SIZE[1]), dpi=200, layout="constrained")
    axes = list(np.atleast_1d(figure.subplots(1, count)))
    for letter, each in zip("abc", axes, strict=False):
        each.set_title(f"({letter})", fontsize=10)
        each.tick_params(direction="in", which="both", top=True, right=True)
    return figure, axes


def draw_curves(
    axes: Axes,
    values: xr.DataArray,
    along: str,
    errors: xr.DataArray | None = None,
    *,
    legend: bool = True,
) -> None:
    """A curve over the axis `along` for each place on the other axes, with error bars.

    Cases without a number leave gaps.
    """
    others = [str(name) for name in values.dims if name != along]
    places = itertools.product(*(values[name].values for name in others))
    for marker, place in zip(itertools.cycle(MARKERS), places):
        chosen = dict(zip(others, place, strict=True))
        curve = values.sel(chosen)
        bars = None if errors is None else np.nan_to_num(errors.sel(chosen).values)
        words = (f"{LABELS.get(name, name)} = {value:g}" for name, value in chosen.items())
        axes.errorbar(
            curve[along].values,
            curve.values,
            bars,
            fmt=f"{marker}-",
            markersize=3.5,
            capsize=2,
            linewidth=1.0,
            label=", ".join(words) or None,
        )
    if others and legend:
        axes.legend(fontsize=8, frameon=False)
