"""The steady trains that the paper shows: Figs. 5, 15 and 18."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from degrees import PAPER
from matplotlib.axes import Axes
from page import Page, plain_figure

from celltrain import Base, Train, paper_units, steady
from celltrain.meridian.geometry import meridian_points
from celltrain.steady.solve import at_degree

# The paper's criterion of convergence, velocity along the normal in U (Sec. V A).
CONVERGED = 1e-4
# Half of what is shown of the tube, r0.
HALF_WINDOW = 8.5
WIDE, NARROW = 10.0, 6.0


@dataclass(frozen=True)
class Shown:
    """A steady train and where the paper shows it."""

    figure: str
    words: str
    base: Base

    @property
    def paper(self) -> Base:
        """The same train at the paper's degree."""
        return at_degree(self.base, PAPER)


def shown() -> Iterator[Shown]:
    """All of them, from the easy ones on."""
    corners = ((NARROW, 0.2), (NARROW, 0.7), (WIDE, 0.2), (WIDE, 0.7))
    for letter, (diameter, packing) in zip("abcd", corners, strict=True):
        train = Train(diameter=diameter, packing=packing, cells=8)
        yield Shown(
            f"5 ({letter})",
            f"D = {diameter:g}, packing {packing:g}",
            steady(train, estimate_error=False),
        )
    train = Train(diameter=8, packing=0.2, cells=8)
    usual, base = train.cell.capillary_number, steady(train, estimate_error=False)
    moduli = ("shear_modulus", "dilatation_modulus", "bending_modulus")
    for letter, capillary in (("a", 0.4), ("b", 20.5)):
        # A faster flow makes all moduli smaller in its units.
        weaker = usual / paper_units.capillary_number_from_paper(capillary)
        changed = {name: getattr(train.cell, name) * weaker for name in moduli}
        base = steady(train.changed(**changed), start=base, estimate_error=False)
        yield Shown(f"15 ({letter})", f"D = 8, packing 0.2, Ca = {capillary:g}", base)
    dense = steady(train.changed(packing=0.7), estimate_error=False)
    for letter, volumes in (("a", (0.55, 0.4)), ("b", (0.7, 0.75, 0.8, 0.84, 0.86))):
        base = dense
        for volume in volumes:
            case = train.changed(packing=0.7, reduced_volume=volume)
            base = steady(case, start=base, estimate_error=False)
        yield Shown(f"18 ({letter})", f"D = 8, packing 0.7, v = {volumes[-1]:g}", base)


def study() -> None:
    page = Page("trains", "Steady trains")
    page.text(
        f"""
The trains of the paper's Figs. 5, 15 and 18, N = 8, viscosity ratio 1, which they do not depend on.
M: the first degree at which the velocity of the cells is known to 1e-4 U. Ca as the paper counts
it; the packing of Fig. 15 it does not say. Residual: largest velocity of the membrane against the
moving train, of the harmonics that there are; left out: what more harmonics would have. The paper
calls a train converged whose velocity along the normal is below {CONVERGED:.0e} U. Its resolution
is M = {PAPER}: the second table has the same trains there. Lengths in r0, velocities in U.
"""
    )
    rows, paper = [], []
    figure = plain_figure(9.0, 7.0)
    panels = figure.subplots(4, 2).ravel()
    for axes, each in zip(panels, shown(), strict=True):
        base = each.base
        draw(axes, each)
        along, across = extent(base)
        rows.append(
            [
                each.figure,
                each.words,
                str(base.train.degree),
                f"{base.cell_velocity:.4f}",
                f"{base.gap:.3f}",
                f"{base.train.radius - base.largest_radius:.3f}",
                f"{along:.2f}; {2.0 * across:.2f}",
                f"{base.effective_viscosity:.4f}",
                f"{base.residual:.0e}",
                f"{base.truncation_error:.0e}",
                "yes" if base.residual < CONVERGED else "no",
            ]
        )
        page.log(" | ".join(rows[-1]))
        coarse = each.paper
        along, across = extent(coarse)
        paper.append(
            [
                each.figure,
                f"{coarse.cell_velocity:.4f}",
                f"{coarse.gap:.3f}",
                f"{coarse.train.radius - coarse.largest_radius:.3f}",
                f"{along:.2f}; {2.0 * across:.2f}",
                f"{coarse.effective_viscosity:.4f}",
                f"{coarse.truncation_error:.0e}",
            ]
        )
    page.table(
        (
            "figure",
            "train",
            "M",
            "velocity of the cells",
            "gap",
            "distance from the wall",
            "cell: length; width",
            "effective viscosity",
            "residual",
            "left out",
            "converged",
        ),
        rows,
    )
    page.heading(f"At M = {PAPER}")
    page.table(
        (
            "figure",
            "velocity of the cells",
            "gap",
            "distance from the wall",
            "cell: length; width",
            "effective viscosity",
            "left out",
        ),
        paper,
    )
    page.figure(figure, "Sections along the axis; the flow is to the right")
    page.write()


def extent(base: Base) -> tuple[float, float]:
    """Length along the axis and largest radius of a cell, r0."""
    radius, height = meridian_points(base.profile)
    return float(np.ptp(height)), float(radius.max())


def draw(axes: Axes, each: Shown) -> None:
    """As many cells of a train in its tube as there is room for, cut along the axis."""
    train = each.base.train
    radius, height = meridian_points(each.base.profile)
    along = np.concatenate([height, height[::-1]])
    across = np.concatenate([radius, -radius[::-1]])
    cells = min(train.cells, int(2.0 * HALF_WINDOW / train.period))
    for cell in range(cells):
        axes.fill(along + cell * train.period, across, facecolor="#E8A5A3", edgecolor="#7A1210")
    for side in (-1.0, 1.0):
        axes.axhline(side * train.radius, color="0.25", linewidth=1.2)
    axes.set_aspect("equal")
    middle = along.mean() + 0.5 * (cells - 1) * train.period
    axes.set_xlim(middle - HALF_WINDOW, middle + HALF_WINDOW)
    axes.axis("off")
    axes.set_title(f"Fig. {each.figure}: {each.words}", fontsize=9, loc="left")
