"""The spectrum at two scales, as in Fig. 3 of the paper."""

import numpy as np
from jaxtyping import Bool, Float, Int
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.ticker import MaxNLocator

from celltrain.pictures.style import COLORS, VERMILION, in_style
from celltrain.stability import Stability

# Azimuthal numbers that matter get a colour each (Okabe & Ito, safe for colour-blind readers).
OTHERS = "0.72"
# How many modes the close view is made to hold.
NEAREST = 24


@in_style()
def draw_spectrum(result: Stability) -> Figure:
    """Growth rate against frequency of all modes, and of those next to the imaginary axis.

    Colour is the azimuthal number m; neutral modes are hollow. Modes come as complex conjugates, of
    waves that travel up and down the train; both are drawn.
    """
    growth = np.array([mode.growth_rate for mode in result.modes])
    frequency = np.array([mode.frequency for mode in result.modes])
    number = np.array([mode.azimuthal_number for mode in result.modes])
    neutral = np.array([mode.neutral for mode in result.modes])

    figure = Figure(figsize=(10.0, 4.6), layout="constrained")
    whole, close = figure.subplots(1, 2)
    for axes in (whole, close):
        axes.axvline(0.0, color="0.3", linewidth=0.8, zorder=1)
        axes.axhline(0.0, color="0.85", linewidth=0.8, zorder=0)
        _scatter(axes, growth, frequency, number, neutral)
        axes.set_xlabel(r"growth rate  Re $\lambda$  ($U/r_0$)")
        axes.xaxis.set_major_locator(MaxNLocator(6))
    whole.set_ylabel(r"frequency  Im $\lambda$  ($U/r_0$)")
    whole.margins(0.04)
    whole.autoscale_view()

    left, right, top = close_view(growth, frequency, neutral)
    close.set_xlim(left, right)
    close.set_ylim(-top, top)
    close.axvspan(0.0, right, color=VERMILION, alpha=0.07, linewidth=0, zorder=0)
    close.text(
        0.99,
        0.02,
        "growing",
        transform=close.transAxes,
        rotation=90,
        ha="right",
        va="bottom",
        fontsize=9,
        color="0.35",
    )
    abscissa = result.spectral_abscissa
    close.axvline(abscissa, color=VERMILION, linewidth=0.9, linestyle=(0, (4, 3)), zorder=1)
    close.set_title(rf"$\alpha$ = {abscissa:.3g} $U/r_0$", loc="right", fontsize=10)
    whole.set_title("(a) all modes")
    close.set_title("(b) near the imaginary axis")
    whole.add_patch(
        Rectangle(
            (left, -top),
            right - left,
            2 * top,
            fill=False,
            edgecolor="0.2",
            linewidth=0.8,
            zorder=5,
        )
    )
    handles, labels = _legend(number, neutral)
    figure.legend(
        handles,
        labels,
        loc="outside lower center",
        ncols=len(labels),
        fontsize=9,
        frameon=False,
        handletextpad=0.1,
    )
    return figure


def number_color(number: int) -> str:
    """The colour of an azimuthal number."""
    return COLORS[number] if number < len(COLORS) else OTHERS


def _scatter(
    axes: Axes,
    growth: Float[np.ndarray, "mode"],
    frequency: Float[np.ndarray, "mode"],
    number: Int[np.ndarray, "mode"],
    neutral: Bool[np.ndarray, "mode"],
) -> None:
    """The modes and their conjugates; small azimuthal numbers over large ones."""
    for m in np.unique(number)[::-1].tolist():
        for hollow in (False, True):
            chosen = (number == m) & (neutral == hollow)
            if not chosen.any():
                continue
            axes.scatter(
                np.tile(growth[chosen], 2),
                np.concatenate([frequency[chosen], -frequency[chosen]]),
                s=30 if hollow else 15,
                facecolors="none" if hollow else number_color(m),
                edgecolors=number_color(m) if hollow else "white",
                linewidths=1.1 if hollow else 0.25,
                zorder=(4 if hollow else 3) - 0.05 * m,
            )


def _legend(
    number: Int[np.ndarray, "mode"], neutral: Bool[np.ndarray, "mode"]
) -> tuple[list[Artist], list[str]]:
    """Handles and labels: one for each coloured m, one for all others, one for neutral modes."""

    def dot(face: str, edge: str) -> Line2D:
        return Line2D(
            [], [], marker="o", linestyle="none", markerfacecolor=face, markeredgecolor=edge
        )

    present = sorted({int(m) for m in number})
    handles: list[Artist] = []
    labels = []
    for m in (m for m in present if m < len(COLORS)):
        handles.append(dot(number_color(m), number_color(m)))
        labels.append(f"$m$ = {m}")
    if present and present[-1] >= len(COLORS):
        handles.append(dot(OTHERS, OTHERS))
        labels.append(rf"$m$ $\geq$ {len(COLORS)}")
    if neutral.any():
        handles.append(dot("none", "0.3"))
        labels.append("neutral")
    return handles, labels


def close_view(
    growth: Float[np.ndarray, "mode"],
    frequency: Float[np.ndarray, "mode"],
    neutral: Bool[np.ndarray, "mode"],
) -> tuple[float, float, float]:
    """Left and right growth rate and largest frequency of a view of the leading modes."""
    leading = np.argsort(-np.where(neutral, -np.inf, growth), kind="stable")
    leading = leading[: min(NEAREST, int((~neutral).sum()))]
    if leading.size == 0:
        return -1.0, 1.0, 1.0
    left = min(1.08 * float(growth[leading].min()), -abs(float(growth[leading].max())), -1e-3)
    right = max(1.6 * float(growth[leading].max()), -0.12 * left)
    top = max(1.15 * float(np.abs(frequency[leading]).max()), 0.1 * (right - left))
    return left, right, top
