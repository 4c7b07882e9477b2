"""Effective viscosity of trains in capillaries beside the viscosity of blood in tubes of glass."""

from dataclasses import dataclass

import numpy as np
from page import Page, plain_figure

from celltrain import Base, CaseError, Train, steady
from celltrain.diagnostics import discharge_haematocrit, in_vitro_viscosity, tube_haematocrit
from celltrain.parameters import Scales
from celltrain.steady import NotConverged

#: Diameters of tubes, um, the first to be computed first, and packings of the trains in them.
DIAMETERS = (10.0, 9.5, 9.0)
PACKINGS = (0.2, 0.3, 0.4, 0.5, 0.6, 0.7)
#: Discharge haematocrits at which the two are compared.
COMPARED = (0.1, 0.3)
#: Errors of the velocity far below what is compared here.
TOLERANCE = 1e-5
# In narrow tubes rounding leaves more than the usual 1e-9.
RESIDUAL = 1e-7


@dataclass(frozen=True)
class Attempt:
    """A tube, um, a packing, and the steady train there or why there is none."""

    diameter: float
    packing: float
    base: Base | None
    reason: str = ""


def trains(page: Page) -> list[Attempt]:
    """All trains: from rest, or from the one before if that fails."""
    attempts: list[Attempt] = []
    for diameter in DIAMETERS:
        start: Base | None = None
        for packing in PACKINGS:
            attempt = _train(diameter, packing, start)
            start = attempt.base or start
            attempts.append(attempt)
            page.log(f"{diameter:g} um, packing {packing:g}: {attempt.reason or 'steady'}")
    return attempts


def _train(diameter: float, packing: float, start: Base | None) -> Attempt:
    reason = ""
    for first in (None, start) if start else (None,):
        try:
            train = Train(
                diameter=diameter * 1e-6 / Scales().radius,
                packing=packing,
                cells=1,
                degree=12,
                tolerance=TOLERANCE,
            )
            return Attempt(diameter, packing, steady(train, start=first, tolerance=RESIDUAL))
        except (NotConverged, CaseError) as error:
            reason = str(error)
    return Attempt(diameter, packing, None, reason)


def study() -> None:
    page = Page("haematocrit", "Effective viscosity beside that of blood in tubes of glass")
    page.text(
        f"""
Single-file trains of the default cell in tubes of {", ".join(f"{d:g}" for d in DIAMETERS)} um
(r0 = 2.8 um, so {", ".join(f"{d / 2.8:.2f}" for d in DIAMETERS)} r0; the resting cell is 2.77 r0
wide), at the default mean velocity of 2.875 mm/s and degree 12, beside the law that Pries, Neuhaus
& Gaehtgens (1992) fitted to measurements of the relative apparent viscosity. Tube haematocrit: N
V/(pi R^2 L); discharge haematocrit: that times U_c/U. Both viscosities are relative to the plasma.
Steady trains are sought from the resting cell, for whose distance from the wall the wall is
resolved. In a tube of 8 um that is 0.04 r0, and one train at degree 8 was not done in ten minutes:
so this comparison ends at 9 um.
"""
    )
    attempts = trains(page)
    rows, differences = [], []
    for attempt in attempts:
        base = attempt.base
        if base is None:
            rows.append((f"{attempt.diameter:g}", f"{attempt.packing:g}", *[""] * 7))
            continue
        share = discharge_haematocrit(base)
        law = float(in_vitro_viscosity(attempt.diameter, share))
        if COMPARED[0] <= share <= COMPARED[1]:
            differences.append(base.effective_viscosity / law - 1.0)
        rows.append(
            (
                f"{attempt.diameter:g}",
                f"{attempt.packing:g}",
                f"{tube_haematocrit(base):.3f}",
                f"{share:.3f}",
                f"{base.effective_viscosity:.4f}",
                f"{law:.4f}",
                f"{base.effective_viscosity / law - 1:+.1%}",
                f"{base.train.radius - base.largest_radius:.3f}",
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
            "law",
            "difference",
            "distance from the wall, r0",
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
    page.text(
        f"""
Within the discharge haematocrits of {COMPARED[0]:g} to {COMPARED[1]:g} the {len(differences)}
trains differ from the law by {min(differences):+.1%} to {max(differences):+.1%}. The law describes
blood of many cells that need not keep to the axis, fitted over tubes of all widths; what scatter
its measurements have at these diameters is not known here.
"""
    )
    figure = plain_figure()
    axes = figure.subplots()
    shares = np.linspace(0.0, 0.45, 100)
    for diameter, colour in zip(DIAMETERS, ("C0", "C1", "C2"), strict=True):
        here = [each.base for each in attempts if each.diameter == diameter and each.base]
        axes.plot(shares, in_vitro_viscosity(diameter, shares), color=colour, linewidth=1.0)
        axes.plot(
            [discharge_haematocrit(each) for each in here],
            [each.effective_viscosity for each in here],
            "o",
            color=colour,
            label=f"{diameter:g} um",
        )
    axes.set(xlabel="discharge haematocrit", ylabel="viscosity over that of plasma")
    axes.legend(frameon=False)
    page.figure(figure, "Trains (dots) and the law of Pries et al. (lines).")
    page.write()
