"""Curves of a study's numbers, drawn as the paper draws them."""

import itertools
from collections.abc import Callable
from functools import partial

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from celltrain.paper.finding import DENSE, SPARSE, at, in_paper_units
from celltrain.paper.resolutions import (
    CONVERGED,
    LABELS,
    PAPER,
    Resolutions,
    Style,
    label_of,
    present,
)
from celltrain.pictures.study import LABELS as AXES

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
    data: Resolutions,
    curve: Callable[[xr.Dataset], xr.DataArray],
    along: str,
    errors: Callable[[xr.Dataset], xr.DataArray] | None = None,
    *,
    legend: bool = True,
) -> None:
    """A curve over the axis `along` for each place on the other axes, at each resolution.

    Lines, with the error where it is known, for what is converged; open symbols for the paper's
    degree. Cases without a number leave gaps.

    **Arguments:** `curve` and `errors` take what is drawn from the data of one resolution.
    """
    for name, each in present(data):
        values, resolution = curve(each), label_of(name, each)
        bars = None if errors is None else errors(each)
        others = [str(other) for other in values.dims if other != along]
        places = list(itertools.product(*(values[other].values for other in others)))
        for number, (marker, place) in enumerate(zip(itertools.cycle(MARKERS), places)):
            chosen = dict(zip(others, place, strict=True))
            at = values.sel(chosen)
            words = ", ".join(f"{AXES.get(key, key)} = {value:g}" for key, value in chosen.items())
            color = f"C{number}"
            style: Style = {"color": color, "capsize": 2, "linewidth": 1.2, "label": words or None}
            if name == PAPER:
                style |= {"fmt": marker, "mfc": "none", "ms": 5, "elinewidth": 0.6}
            if resolution != LABELS[CONVERGED]:
                style["label"] = f"{words}, {resolution}".lstrip(", ")
            known = None if bars is None else np.nan_to_num(bars.sel(chosen).values)
            axes.errorbar(at[along].values, at.values, known, **style)
        if others and legend:
            axes.legend(fontsize=6.5, frameon=False)


def sparse_and_dense(data: Resolutions, along: str, usual: float) -> tuple[Figure, list[Axes]]:
    """alpha over the axis `along` for sparse and for dense trains, in the paper's unit.

    **Arguments:** `usual`: the place on that axis of the paper's other figures, which is marked.
    """
    figure, panels = side_by_side(2)
    for axes, packing in zip(panels, (SPARSE, DENSE), strict=True):

        def rate(each: xr.Dataset, name: str, packing: float = packing) -> xr.DataArray:
            return in_paper_units(at(each[name], packing=packing))

        draw_curves(
            axes,
            data,
            partial(rate, name="spectral_abscissa"),
            along,
            partial(rate, name="error_estimate"),
        )
        axes.axvline(usual, color="0.5", linestyle="--", linewidth=0.8)
        axes.set_ylabel(r"$\alpha\, r_0/U^*$")
        axes.set_title(f"{axes.get_title()}  $\\phi$ = {packing:g}", fontsize=10)
    return figure, panels
