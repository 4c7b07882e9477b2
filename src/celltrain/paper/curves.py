"""Curves of a study's numbers, drawn as the paper draws them."""

import itertools

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from celltrain.paper.finding import DENSE, SPARSE, at, in_paper_units
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


def sparse_and_dense(data: xr.Dataset, along: str, usual: float) -> tuple[Figure, list[Axes]]:
    """alpha over the axis `along` for sparse and for dense trains, in the paper's unit.

    **Arguments:** `usual`: the place on that axis of the paper's other figures, which is marked.
    """
    figure, panels = side_by_side(2)
    for axes, packing in zip(panels, (SPARSE, DENSE), strict=True):
        alpha, error = (
            in_paper_units(at(data[name], packing=packing))
            for name in ("spectral_abscissa", "error_estimate")
        )
        draw_curves(axes, alpha, along, error)
        axes.axvline(usual, color="0.5", linestyle="--", linewidth=0.8)
        axes.set_ylabel(r"$\alpha\, r_0/U^*$")
        axes.set_title(f"{axes.get_title()}  $\\phi$ = {packing:g}", fontsize=10)
    return figure, panels
