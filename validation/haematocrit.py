"""Effective viscosity of trains in capillaries beside the viscosity of blood in tubes of glass."""

from dataclasses import dataclass

import numpy as np
from degrees import FINE
from page import Page, plain_figure

from celltrain import Base, CaseError, Train, steady
from celltrain.diagnostics import discharge_haematocrit, in_vitro_viscosity, tube_haematocrit
from celltrain.parameters import Scales
from celltrain.steady import NotConverged
from celltrain.steady.solve import at_degree

#: Diameters of tubes, um, the first to be computed first, and packings of the trains in them.
DIAMETERS = (10.0, 9.0, 8.0, 7.0, 6.5)
PACKINGS = (0.2, 0.3, 0.4, 0.5, 0.6, 0.7)
#: Discharge haematocrits at which the two are compared.
COMPARED = (0.1, 0.3)
#: The degree whose trains tell the error of the others.
HIGHER = 36
#: Differences from the law beyond this are listed by themselves.
LARGE = 0.10
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00")


@dataclass(frozen=True)
class Attempt:
    """A tube, um, a packing, and the steady train there or why there is none.

    `finer` is its viscosity at the higher degree, NaN if the train was not found there.
    """

    diameter: float
    packing: float
    base: Base | None
    finer: float = np.nan
    reason: str = ""


def trains(page: Page) -> list[Attempt]:
    """All trains, each from the one before, those of a tube from the first in a wider one."""
    attempts: list[Attempt] = []
    first: Base | None = None
    for diameter in DIAMETERS:
        start = first
        for packing in PACKINGS:
            attempt = _train(diameter, packing, start)
            start = attempt.base or start
            if packing == PACKINGS[0]:
                first = start
            attempts.append(attempt)
            page.log(f"{diameter:g} um, packing {packing:g}: {attempt.reason or 'steady'}")
            if attempt.base is None:
                # Denser trains have less room still.
                break
    return attempts


def _train(diameter: float, packing: float, start: Base | None) -> Attempt:
    train = Train(diameter=diameter * 1e-6 / Scales().radius, packing=packing, cells=1, degree=FINE)
    try:
        base = steady(train, start=start, estimate_error=False)
    except (NotConverged, CaseError) as error:
        return Attempt(diameter, packing, None, reason=str(error))
    try:
        finer = at_degree(base, HIGHER).effective_viscosity
    except (NotConverged, CaseError):
        finer = np.nan
    return Attempt(diameter, packing, base, finer)


def _difference(base: Base, diameter: float) -> float:
    """Of the train's viscosity from the law's, relative to that."""
    law = float(in_vitro_viscosity(diameter, discharge_haematocrit(base)))
    return base.effective_viscosity / law - 1.0


def _beyond(attempts: list[Attempt]) -> str:
    """The trains that are far from the law, with what is known of why."""
    found = []
    for each in attempts:
        if each.base is None or abs(_difference(each.base, each.diameter)) <= LARGE:
            continue
        share = (each.base.effective_viscosity - each.finer) / each.finer
        error = f"{share:+.1%}" if np.isfinite(share) else "not known"
        found.append(
            f"{each.diameter:g} um, {each.packing:g}:"
            f" {_difference(each.base, each.diameter):+.0%}, gap {each.base.gap:.2f} r0,"
            f" M = {FINE} against {HIGHER}: {error}"
        )
    return f"""
Beyond {LARGE:.0%}: {"; ".join(found)}. Of a difference as large as that of the degrees nothing can
be said but that a higher degree is needed. Why the others differ was not tested: a train in single
file on the axis is more orderly than blood at such haematocrits in the wider tubes, and in the
narrower ones its cells come close to each other, which the law's average over tubes does not know.
"""


def study() -> None:
    page = Page("haematocrit", "Effective viscosity beside that of blood in tubes of glass")
    page.text(
        f"""
Single-file trains of the default cell in tubes of {", ".join(f"{d:g}" for d in DIAMETERS)} um
(r0 = 2.8 um, so {", ".join(f"{d / 2.8:.2f}" for d in DIAMETERS)} r0; the resting cell is 2.77 r0
wide), at the default mean velocity of 2.875 mm/s, M = {FINE}, beside the law that Pries, Neuhaus &
Gaehtgens (1992) fitted to measurements of the relative apparent viscosity. Tube haematocrit: N
V/(pi R^2 L); discharge haematocrit: that times U_c/U. Both viscosities are relative to the plasma;
*error* is the difference of the train's from that at M = {HIGHER}, *gap* that between neighbours
along the tube.
Each train is continued from the one before. Where that ends no denser train is tried: cells in
narrow tubes are long, and close to each other at packings below 0.7.
"""
    )
    attempts = trains(page)
    rows: list[tuple[object, ...]] = []
    differences: dict[float, list[float]] = {diameter: [] for diameter in DIAMETERS}
    for attempt in attempts:
        base = attempt.base
        if base is None:
            rows.append((f"{attempt.diameter:g}", f"{attempt.packing:g}", *[""] * 9))
            continue
        share = discharge_haematocrit(base)
        law = float(in_vitro_viscosity(attempt.diameter, share))
        if COMPARED[0] <= share <= COMPARED[1]:
            differences[attempt.diameter].append(base.effective_viscosity / law - 1.0)
        rows.append(
            (
                f"{attempt.diameter:g}",
                f"{attempt.packing:g}",
                f"{tube_haematocrit(base):.3f}",
                f"{share:.3f}",
                f"{base.effective_viscosity:.4f}",
                f"{abs(attempt.finer - base.effective_viscosity):.0e}"
                if np.isfinite(attempt.finer)
                else "not known",
                f"{law:.4f}",
                f"{base.effective_viscosity / law - 1:+.1%}",
                f"{base.train.radius - base.largest_radius:.3f}",
                f"{base.gap:.3f}",
                f"{base.truncation_error:.0e}",
            )
        )
    page.table(
        (
            "D, um",
            "phi",
            "H_T",
            "H_D",
            "viscosity, train",
            "error",
            "law",
            "difference",
            "distance from the wall, r0",
            "gap, r0",
            "left out by the degree, U",
        ),
        rows,
    )
    failed = [each for each in attempts if each.base is None]
    if failed:
        page.text(
            "No steady train: "
            + "; ".join(f"{each.diameter:g} um, {each.packing:g}: {each.reason}" for each in failed)
            + "."
        )
    page.text(_beyond(attempts))
    words = "; ".join(
        f"{diameter:g} um: {min(each):+.1%}" + (f" to {max(each):+.1%}" if len(each) > 1 else "")
        for diameter, each in differences.items()
        if each
    )
    page.text(
        f"""
Within the discharge haematocrits of {COMPARED[0]:g} to {COMPARED[1]:g} the trains differ from the
law by these: {words}. The law describes blood of many cells that need not keep to the axis, fitted
over tubes of all widths; what scatter its measurements have at these diameters is not known here.
"""
    )
    figure = plain_figure(6.8, 4.4)
    axes = figure.subplots()
    shares = np.linspace(0.0, 0.65, 100)
    for diameter, color in zip(DIAMETERS, COLORS, strict=True):
        here = [each.base for each in attempts if each.diameter == diameter and each.base]
        axes.plot(shares, in_vitro_viscosity(diameter, shares), color=color, linewidth=1.0)
        axes.plot(
            [discharge_haematocrit(each) for each in here],
            [each.effective_viscosity for each in here],
            "o",
            color=color,
            label=f"{diameter:g} um",
        )
    axes.set(xlabel="discharge haematocrit", ylabel="viscosity over that of plasma")
    axes.legend(frameon=False)
    page.figure(figure, "Trains (dots) and the law of Pries et al. (lines)")
    page.write()
