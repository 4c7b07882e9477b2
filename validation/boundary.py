"""The boundary of stability in diameter and packing: where the tilts neither grow nor decay."""

import math

import numpy as np
from page import FOLDER, Page
from scipy.optimize import brentq

from celltrain import Base, Train, steady
from celltrain.continuation import BoundaryPoint, StabilityBoundary, Steps, stability_boundary
from celltrain.pictures import draw_stability_boundary
from celltrain.stability import (
    WaveMode,
    block_spectrum,
    linear_blocks,
    neutral_space,
    wave_sensitivities,
)

# Modes of trains at D = 6: name, q, packings through which the start is reached, number of points.
SPARSE = ("all cells alike (q = 0)", 0.0, (0.3, 0.36, 0.39), 5)
DENSE = ("neighbours oppositely (q = pi)", math.pi, (0.3, 0.5, 0.6), 3)
FINER_DEGREE = 16
# Packings at D = 6 between which the uniform tilt turns stable at that degree.
FINER_PACKINGS = (0.39, 0.42)
# Growth rates below this (U/r0) are zero: a thousandth of those inside the unstable regions.
STEPS = Steps(first=0.06, largest=0.12, tolerance=1e-6)
TILT = 1
# Packings at D = 6, around that at which the two fastest tilts meet.
AROUND = (0.386, 0.388, 0.39, 0.3905, 0.391, 0.394)
# Change of the packing over which differences are taken.
BESIDE = 1e-4


def study() -> None:
    page = Page("boundary", "The boundary of stability")
    page.text(
        """
alpha(D, packing) = 0 of the fastest tilt (m = 1) with one phase q, for an infinite train,
viscosity ratio 1, degree 12: pseudo-arclength continuation from D = 6 with the exact gradient of
alpha. Two modes bound the region in which the cells keep their order: at small packing all cells
tilt alike, at large packing neighbours tilt oppositely. Rates in U/r0.
"""
    )
    found, starts = {}, {}
    for name, q, packings, count in (SPARSE, DENSE):
        starts[name] = start = reach(packings, 12)
        page.log(f"start of {name}")

        def tell(point: BoundaryPoint) -> None:
            page.log(f"D = {point.diameter:.4f}, packing {point.packing:.5f}")

        found[name] = stability_boundary(
            start,
            azimuthal_number=TILT,
            phase=q,
            most_points=count,
            steps=STEPS,
            progress=tell,
        )
        table(page, name, found[name])
    path = FOLDER / "boundary.png"
    draw_stability_boundary(found, path)
    page.parts.append(f"![Curves on which the tilts neither grow nor decay]({path.name})")
    checks(page, found[SPARSE[0]], starts[SPARSE[0]])
    page.write()


def reach(packings: tuple[float, ...], degree: int) -> Base:
    """A train at D = 6, by continuation in the packing."""
    base = None
    for packing in packings:
        train = Train(diameter=6, packing=packing, cells=1, degree=degree)
        base = steady(train, start=base, estimate_error=False)
    assert base is not None
    return base


def table(page: Page, name: str, boundary: StabilityBoundary) -> None:
    """The points of one curve."""
    page.heading(f"Tilt of {name}")
    page.table(
        ("D/r0", "packing", "gap, r0", "alpha", "frequency", "d alpha/dD", "d alpha/d packing"),
        [
            (
                f"{point.diameter:.3f}",
                f"{point.packing:.5f}",
                f"{point.base.gap:.3f}",
                f"{point.mode.growth_rate:.0e}",
                f"{abs(point.mode.frequency):.5f}",
                *(f"{slope:+.4f}" for slope in point.gradient),
            )
            for point in boundary.points
        ],
    )
    page.text(f"The curve ended because {boundary.ending.message}.")


def checks(page: Page, sparse: StabilityBoundary, start: Base) -> None:
    """The gradients against trains beside the curve, and the curve at a higher degree."""
    page.heading("Checks")
    rows = []
    for point in (sparse.points[0], sparse.points[-1]):
        rates = [rate(point.base, point.packing + side) for side in (-BESIDE, BESIDE)]
        slope = (rates[1] - rates[0]) / (2.0 * BESIDE)
        place = f"D = {point.diameter:.3f}, packing lower and higher by {BESIDE:g}"
        found = f"{rates[0]:+.2e}, {rates[1]:+.2e}"
        rows += [
            (f"alpha at {place}", found, "growing, decaying"),
            ("d alpha/d packing from them", f"{slope:+.4f}", f"{point.gradient[1]:+.4f}"),
        ]
        page.log(f"beside D = {point.diameter:.3f}: {slope:+.4f}")
    finer = steady(start.train.changed(degree=FINER_DEGREE), start=start, estimate_error=False)
    # Not by Newton's method: at this degree two tilts meet there, and the slope changes at once.
    there = float(brentq(lambda packing: rate(finer, packing), *FINER_PACKINGS, xtol=1e-4))
    page.log("checks")
    # The boundary at degree 12 in the same tube, along its tangent.
    first = sparse.points[0]
    wider = start.train.tube.diameter - first.diameter
    coarse = first.packing - first.gradient[0] * wider / first.gradient[1]
    page.table(
        ("what", "found", "expected"),
        [
            *rows,
            (
                f"packing of the boundary at D = 6, degree {FINER_DEGREE}, by bracketing",
                f"{there:.4f}",
                f"{coarse:.4f} at degree 12",
            ),
            (
                "packing from which the paper's trains are marginal, all D",
                f"{first.packing:.3f} at D = {first.diameter:.2g}, "
                f"{sparse.points[-1].packing:.3f} at D = {sparse.points[-1].diameter:.2g}",
                "0.4 (its steps are 0.05)",
            ),
        ],
    )
    meeting(page, first.base)


def meeting(page: Page, base: Base) -> None:
    """The two fastest tilts of all cells alike around the boundary, with their slopes."""
    page.heading("Why the slope is steep at D = 6")
    rows = []
    for packing in AROUND:
        train = base.train.changed(packing=packing)
        base = steady(train, start=base, estimate_error=False)
        block = linear_blocks(base.train, base.coefficients, np.zeros(1), [TILT])[TILT][0]
        spectrum = block_spectrum(block, neutral_space(base, TILT, 0))
        values = spectrum.eigenvalues[:2]
        leading = WaveMode(
            values[0].real,
            values[0].imag,
            TILT,
            0.0,
            spectrum.right[:, 0],
            spectrum.left[:, 0],
        )
        found = wave_sensitivities(base, leading, parameters=["packing"])
        slope = found.entries["packing"].growth_rate
        rows.append((f"{packing:g}", *(f"{value:+.5f}" for value in values), f"{slope:+.4f}"))
    page.log("the meeting of two tilts")
    page.table(("packing", "fastest, U/r0", "second, U/r0", "d alpha/d packing"), rows)
    page.text(
        """
Two real eigenvalues meet just inside the boundary, and are a pair of complex ones from there on.
Towards that point the slope grows like one over the root of the distance; beyond it the rate hardly
changes. So the differences above are taken over a small step."""
    )


def rate(base: Base, packing: float) -> float:
    """Growth rate of the uniform tilt in a train of another packing."""
    other = steady(base.train.changed(packing=packing), start=base, estimate_error=False)
    block = linear_blocks(other.train, other.coefficients, np.zeros(1), [TILT])[TILT][0]
    return float(block_spectrum(block, neutral_space(other, TILT, 0)).eigenvalues[0].real)
