"""Figures of results for Plotly, as plain dictionaries: the same in the explorer and in pages."""

from collections.abc import Sequence
from typing import cast

import numpy as np

from celltrain.explore.curves import GrowthCurves
from celltrain.explore.drawing import Drawn, mode_key
from celltrain.explore.reading import Reading
from celltrain.pictures.spectrum import close_view
from celltrain.pictures.style import COLORS, VERMILION
from celltrain.stability import InfiniteTrain, Stability, TransientGrowth

Figure = dict[str, object]
INK, QUIET, LINE, OTHERS = "#1f2933", "#5b6875", "#d5dbe1", "#b4bcc4"
#: Shapes of points by azimuthal number, for who does not see the colours.
SYMBOLS = ("circle", "diamond", "square", "triangle-up")
FONT = {"family": "system-ui, -apple-system, Segoe UI, Roboto, sans-serif", "size": 12}


def axis(title: str, **more: object) -> dict[str, object]:
    """An axis as all figures have it."""
    return {
        "title": {"text": title, "standoff": 8, "font": {"size": 12, "color": QUIET}},
        "showgrid": False,
        "zeroline": False,
        "showline": True,
        "mirror": True,
        "linecolor": LINE,
        "ticks": "inside",
        "tickcolor": LINE,
        "tickfont": {"size": 11, "color": QUIET},
        **more,
    }


def logarithmic(low: float, high: float) -> dict[str, object]:
    """What makes an axis logarithmic, with ticks that say their values in full."""
    decades = range(int(np.floor(np.log10(low))), int(np.ceil(np.log10(high))) + 1)
    steps = (1.0, 2.0, 5.0) if high < 200.0 * low else (1.0,)
    ticks = [step * 10.0**decade for decade in decades for step in steps]
    inside = [tick for tick in ticks if low <= tick <= high]
    return {
        "type": "log",
        "range": [float(np.log10(low)), float(np.log10(high))],
        "tickvals": inside,
        "ticktext": [f"{tick:g}" for tick in inside],
    }


def figure(data: Sequence[dict[str, object]], **layout: object) -> Figure:
    """A figure as all are laid out."""
    return {
        "data": list(data),
        "layout": {
            "font": {**FONT, "color": INK},
            "paper_bgcolor": "rgba(0,0,0,0)",
            "plot_bgcolor": "#ffffff",
            "margin": {"l": 62, "r": 14, "t": 22, "b": 44},
            "showlegend": False,
            "hovermode": "closest",
            "hoverlabel": {"bgcolor": "#ffffff", "bordercolor": LINE, "font": {"color": INK}},
            "uirevision": "kept",
            **layout,
        },
    }


def empty_figure(words: str) -> Figure:
    """A figure that only says why it is empty."""
    note = _note(words, 0.5, 0.55, "center", QUIET)
    hidden = {"visible": False}
    return figure([], xaxis=hidden, yaxis=hidden, annotations=[note])


def spectrum_figures(
    result: Stability, reading: Reading, mode: Drawn | None = None
) -> tuple[Figure, Figure]:
    """The spectrum at both scales of Fig. 3: all modes, and those near the imaginary axis.

    Modes come as conjugates; both are drawn, and their points carry the key of the mode. The first
    points are a ring around the mode that is played (see `mode_drawing`).
    """
    rate, unit = reading.of("U/r0")
    growth = np.array([mode.growth_rate for mode in result.modes])
    frequency = np.array([mode.frequency for mode in result.modes])
    neutral = np.array([mode.neutral for mode in result.modes])
    left, right, top = close_view(growth, frequency, neutral)
    near = (growth > 1.3 * left) & (np.abs(frequency) < 1.3 * top)
    every = [_played(mode), *_modes(result, np.ones(len(growth), bool), rate)]
    close = [_played(mode), *_modes(result, near, rate)]
    axes = {
        "xaxis": axis(f"growth rate Re λ ({unit})"),
        "yaxis": axis(f"frequency Im λ ({unit})"),
    }
    window = [left * rate, right * rate, -top * rate, top * rate]
    whole = figure(every, **axes, shapes=[_vertical(0.0, INK, 0.8), _box(window)])
    alpha = result.spectral_abscissa * rate
    inner = figure(
        close,
        xaxis={**axes["xaxis"], "range": window[:2]},
        yaxis={**axes["yaxis"], "range": window[2:]},
        shapes=[
            _growing(window[1]),
            _vertical(0.0, INK, 0.8),
            _vertical(alpha, VERMILION, 1.2, "dash"),
        ],
        annotations=[_above(f"α = {alpha:.4g} {unit}")],
        uirevision=f"{unit}",
    )
    return whole, inner


def wave_figures(
    result: InfiniteTrain, reading: Reading, mode: Drawn | None = None
) -> tuple[Figure, Figure]:
    """The leading eigenvalues of an infinite train over the phase, in place of its spectrum."""
    rate, unit = reading.of("U/r0")
    best = result.most_unstable
    traces = [
        _played(mode),
        *(
            {
                "type": "scatter",
                "mode": "lines+markers",
                "x": (rate * result.growth_rates(m)[_first(result, m) :]).tolist(),
                "y": (rate * result.frequencies(m)[_first(result, m) :]).tolist(),
                "customdata": [
                    f"{m},{place},0" for place in range(_first(result, m), len(result.phases))
                ],
                "name": f"m = {m}",
                "line": {"color": COLORS[m % 4], "width": 1},
                "marker": {"color": COLORS[m % 4], "symbol": SYMBOLS[m % 4], "size": 7},
                "hovertemplate": f"m = {m}<br>λ = %{{x:.4g}} + %{{y:.4g}} i {unit}<extra></extra>",
            }
            for m in result.azimuthal_numbers
        ),
    ]
    axes = {
        "xaxis": axis(f"growth rate Re λ ({unit})"),
        "yaxis": axis(f"frequency Im λ ({unit})"),
    }
    wide = max(3.0 * abs(best.growth_rate), 0.02) * rate
    high = max(1.5 * abs(best.frequency), 0.02) * rate
    words = {**_above("the leading one of each m, over the phase q"), "font": {"color": QUIET}}
    whole = figure(traces, **axes, shapes=[_vertical(0.0, INK, 0.8)], annotations=[words])
    inner = figure(
        traces,
        xaxis={**axes["xaxis"], "range": [-2.0 * wide, wide]},
        yaxis={**axes["yaxis"], "range": [-high, high]},
        shapes=[_growing(wide), _vertical(0.0, INK, 0.8)],
        annotations=[_above(f"α = {best.growth_rate * rate:.4g} {unit}")],
        uirevision=f"{unit}",
    )
    return whole, inner


def dispersion_figure(result: InfiniteTrain, reading: Reading) -> Figure:
    """alpha_m(q) of the infinite train, with the most unstable wave.

    The axis is linear close to 0 and logarithmic further away, as modes of different m decay at
    very different rates. The point at q = 0 of m = 0 is apart, as the train's displacement is.
    """
    rate, unit = reading.of("U/r0")
    best = result.most_unstable
    small = max(2.0 * abs(best.growth_rate), 1e-3) * rate
    phases = result.phases / np.pi
    traces: list[dict[str, object]] = []
    for m in result.azimuthal_numbers:
        first = _first(result, m)
        values = rate * result.growth_rates(m)[first:]
        traces.append(
            {
                "type": "scatter",
                "mode": "lines+markers",
                "x": phases[first:].tolist(),
                "y": _bent(values, small).tolist(),
                "text": [f"{each:.4g}" for each in values],
                "name": f"m = {m}",
                "line": {"color": COLORS[m % 4], "width": 1.6},
                "marker": {"color": COLORS[m % 4], "symbol": SYMBOLS[m % 4], "size": 6},
                "hovertemplate": f"m = {m}, q = %{{x:.3g}} π<br>%{{text}} {unit}<extra></extra>",
            }
        )
    traces.append(
        {
            "type": "scatter",
            "mode": "markers",
            "x": [best.phase / np.pi],
            "y": _bent(np.array([best.growth_rate * rate]), small).tolist(),
            "marker": {
                "symbol": "star",
                "size": 14,
                "color": "#E69F00",
                "line": {"color": INK, "width": 0.8},
            },
            "hovertemplate": f"most unstable: {best.growth_rate * rate:.4g} {unit}<extra></extra>",
        }
    )
    every = rate * np.concatenate([result.growth_rates(m) for m in result.azimuthal_numbers])
    ticks = _bent_ticks(float(every.min()), float(every.max()), small)
    return figure(
        traces,
        xaxis=axis("phase from cell to cell q/π", range=[-0.03, 1.03]),
        yaxis=axis(
            f"growth rate α<sub>m</sub>(q) ({unit})",
            tickvals=_bent(np.array(ticks), small).tolist(),
            ticktext=[f"{tick:g}".replace("-", "−") for tick in ticks],
        ),
        shapes=[_horizontal(0.0)],
    )


def _first(result: InfiniteTrain, m: int) -> int:
    """Where the curve of an azimuthal number begins: that of m = 0 without q = 0."""
    return 1 if m == 0 and result.phases[0] == 0.0 else 0


def transient_curves(result: TransientGrowth) -> GrowthCurves:
    """The curves of a result of transient growth."""
    numbers = sorted({block.azimuthal_number for block in result.blocks})
    by_number = {
        m: np.asarray(
            np.max([each.growth for each in result.blocks if each.azimuthal_number == m], axis=0)
        )
        for m in numbers
    }
    return GrowthCurves(result.times, by_number, result.numerical_abscissa)


def growth_figure(curves: GrowthCurves, alpha: float, reading: Reading) -> Figure:
    """G(t) of each azimuthal number and of the train, beside exp(alpha t) and exp(eta t)."""
    time, unit = reading.of("r0/U")
    times, largest = curves.times[1:], curves.largest[1:]
    traces: list[dict[str, object]] = [
        {
            "type": "scatter",
            "mode": "lines",
            "x": (times * time).tolist(),
            "y": largest.tolist(),
            "line": {"color": "#c3cad1", "width": 7},
            "hovertemplate": f"largest: G(%{{x:.3g}} {unit}) = %{{y:.4g}}<extra></extra>",
        }
    ]
    for m in sorted(curves.by_number)[: len(COLORS)]:
        traces.append(
            {
                "type": "scatter",
                "mode": "lines",
                "x": (times * time).tolist(),
                "y": curves.by_number[m][1:].tolist(),
                "line": {"color": COLORS[m], "width": 1.8},
                "hovertemplate": f"m = {m}: %{{y:.4g}}<extra></extra>",
            }
        )
    top = 1.4 * float(largest.max())
    for name, rate, dash in (("α", alpha, "dash"), ("η", curves.numerical_abscissa, "dot")):
        bound = np.exp(np.minimum(rate * times, 300.0))
        traces.append(
            {
                "type": "scatter",
                "mode": "lines",
                "x": (times * time).tolist(),
                "y": bound.tolist(),
                "line": {"color": INK, "width": 1.1, "dash": dash},
                "hovertemplate": f"exp({name} t) = %{{y:.4g}}<extra></extra>",
            }
        )
    low = max(0.6 * float(min(each.min() for each in curves.by_number.values())), 0.02)
    return figure(
        traces,
        xaxis=axis(f"time t ({unit})", **logarithmic(times[0] * time, times[-1] * time)),
        yaxis=axis(
            "largest growth G(t)",
            **logarithmic(low, top),
        ),
    )


def _played(mode: Drawn | None) -> dict[str, object]:
    """A ring around the eigenvalue of a mode, and around its conjugate."""
    x, y = ([], []) if mode is None else ring_around(cast(Sequence[float], mode["place"]))
    look = {"symbol": "circle-open", "size": 17, "color": INK, "line": {"width": 2}}
    points = {"type": "scatter", "mode": "markers", "x": x, "y": y}
    return {**points, "marker": look, "hoverinfo": "skip"}


def ring_around(place: Sequence[float]) -> tuple[list[float], list[float]]:
    """Where rings stand around an eigenvalue and its conjugate."""
    growth, frequency = place
    return [growth, growth], [frequency, -frequency]


def _modes(result: Stability, chosen: np.ndarray, rate: float) -> list[dict[str, object]]:
    """Points of modes and their conjugates, small azimuthal numbers over large ones."""
    most = len(COLORS)
    traces: list[dict[str, object]] = []
    for number in range(most, -1, -1):
        for neutral in (False, True):
            modes = [
                mode
                for mode, wanted in zip(result.modes, chosen, strict=True)
                if wanted and min(mode.azimuthal_number, most) == number and mode.neutral == neutral
            ]
            if not modes:
                continue
            x = [float(f"{mode.growth_rate * rate:.6g}") for mode in modes]
            y = [float(f"{mode.frequency * rate:.6g}") for mode in modes]
            color = OTHERS if number == most else COLORS[number]
            symbol = "circle" if number == most else SYMBOLS[number]
            name = f"m ≥ {most}" if number == most else f"m = {number}"
            traces.append(
                {
                    "type": "scattergl" if len(modes) > 400 else "scatter",
                    "mode": "markers",
                    "x": [*x, *x],
                    "y": [*y, *(-each for each in y)],
                    "customdata": 2 * [mode_key(mode) for mode in modes],
                    "marker": {
                        "color": color,
                        "symbol": f"{symbol}-open" if neutral else symbol,
                        "size": 9 if neutral else 7 if number < most else 5,
                        "line": {"width": 1.4 if neutral else 0.5, "color": color}
                        if neutral
                        else {"width": 0.5, "color": "#ffffff"},
                    },
                    "name": f"{name}, neutral" if neutral else name,
                    "hovertemplate": (
                        f"{name}{', neutral' if neutral else ''}<br>λ = %{{x:.4g}} + %{{y:.4g}} i"
                        "<br>click: play this mode<extra></extra>"
                    ),
                }
            )
    return traces


def _bent(values: np.ndarray, small: float) -> np.ndarray:
    """Values on an axis that is linear below a small one and logarithmic above."""
    return np.asarray(np.arcsinh(values / small))


def _bent_ticks(least: float, most: float, small: float) -> list[float]:
    start = 10.0 ** np.ceil(np.log10(small))
    decades = [start * 10.0**power for power in range(5)]
    ticks = [0.0]
    ticks += [each for each in decades if each <= 1.5 * most]
    ticks += [-each for each in decades if each <= 1.5 * abs(min(least, 0.0))]
    if len(ticks) < 3:
        ticks += [start / 10.0 * sign for sign in (1, -1)]
    return sorted(ticks)


def _vertical(x: float, color: str, width: float, dash: str = "solid") -> dict[str, object]:
    line = {"color": color, "width": width, "dash": dash}
    whole = {"xref": "x", "yref": "paper", "y0": 0, "y1": 1}
    return {"type": "line", **whole, "x0": x, "x1": x, "line": line, "layer": "below"}


def _horizontal(y: float) -> dict[str, object]:
    line = {"color": INK, "width": 0.8}
    whole = {"xref": "paper", "yref": "y", "x0": 0, "x1": 1}
    return {"type": "line", **whole, "y0": y, "y1": y, "line": line, "layer": "below"}


def _growing(right: float) -> dict[str, object]:
    """The half plane of what grows."""
    whole = {"xref": "x", "yref": "paper", "y0": 0, "y1": 1, "x0": 0.0, "x1": 50.0 * right}
    look = {"fillcolor": "rgba(213,94,0,0.07)", "line": {"width": 0}, "layer": "below"}
    return {"type": "rect", **whole, **look}


def _box(window: Sequence[float]) -> dict[str, object]:
    left, right, bottom, top = window
    place = {"xref": "x", "yref": "y", "x0": left, "x1": right, "y0": bottom, "y1": top}
    return {"type": "rect", **place, "line": {"color": INK, "width": 1}}


def _above(text: str) -> dict[str, object]:
    """Words over the upper right corner."""
    return {**_note(text, 1.0, 1.0, "right", VERMILION), "yanchor": "bottom", "yshift": 1}


def _note(text: str, x: float, y: float, anchor: str, color: str) -> dict[str, object]:
    place = {"xref": "paper", "yref": "paper", "x": x, "y": y, "xanchor": anchor, "yanchor": "top"}
    return {**place, "text": text, "showarrow": False, "font": {"size": 12, "color": color}}
