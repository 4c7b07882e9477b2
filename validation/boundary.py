"""The boundary of stability in diameter and packing: where the tilts neither grow nor decay."""

import math

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
from celltrain.stability.spectrum import BlockSpectrum

# Tilts: name, q, packings at D = 6 between which they turn stable or unstable, number of points.
SPARSE = ("all cells alike (q = 0)", 0.0, (0.38, 0.42), 6)
DENSE = ("neighbours oppositely (q = pi)", math.pi, (0.58, 0.62), 4)
# A usual one, and one at which the curves have converged.
DEGREES = (12, 24)
# Growth rates below this (U/r0) are zero: a thousandth of those inside the unstable regions.
STEPS = Steps(first=0.04, largest=0.12, tolerance=1e-6)
TILT = 1
# Packings at D = 6 over that of the boundary, around which the two fastest tilts meet.
AROUND = (-0.004, -0.002, 0.0, 0.001, 0.002, 0.004)
# Change of the packing over which differences are taken.
BESIDE = 1e-4


def study() -> None:
    page = Page("boundary", "The boundary of stability")
    page.text(
        """
alpha(D, packing) = 0 of the fastest tilt (m = 1) with one phase q, for an infinite train,
viscosity ratio 1: pseudo-arclength continuation from D = 6 with the exact gradient of alpha, at
degree 12 and at degree 24, where the curves have converged (at degree 32 growth rates differ by
about 5e-5 near them, and by 1e-4 at most farther off). Two modes bound the region in which the
cells keep their order: at small packing all cells tilt alike, at large packing neighbours tilt
oppositely. Rates in U/r0.
"""
    )
    found = {
        (name, degree): curve(page, name, degree, q, packings, count)
        for name, q, packings, count in (SPARSE, DENSE)
        for degree in DEGREES
    }
    path = FOLDER / "boundary.png"
    drawn = {f"{name}, degree {degree}": each for (name, degree), each in found.items()}
    draw_stability_boundary(drawn).savefig(path)
    page.parts.append(f"![Curves on which the tilts neither grow nor decay]({path.name})")
    checks(page, found)
    for degree in DEGREES:
        meeting(page, found[SPARSE[0], degree].points[0].base)
    page.text(
        """
Two real eigenvalues meet just inside the boundary, and are a pair of complex ones from there on.
Towards that point the slope grows like one over the root of the distance; beyond it the rate hardly
changes. So the differences above are taken over a small step."""
    )
    page.write()


def curve(
    page: Page, name: str, degree: int, q: float, packings: tuple[float, float], count: int
) -> StabilityBoundary:
    """One boundary, from the packing at D = 6 at which the tilt turns stable or unstable."""
    train = Train(diameter=6, packing=packings[0], cells=1, degree=degree)
    near = steady(train, estimate_error=False)
    packing = float(brentq(lambda each: rate(near, each, q), *packings, xtol=1e-4))
    start = steady(train.changed(packing=packing), start=near, estimate_error=False)
    page.log(f"start of {name}, degree {degree}: packing {packing:.4f}")

    def tell(point: BoundaryPoint) -> None:
        page.log(f"D = {point.diameter:.4f}, packing {point.packing:.5f}")

    found = stability_boundary(
        start,
        azimuthal_number=TILT,
        phase=q,
        most_points=count,
        steps=STEPS,
        progress=tell,
    )
    table(page, f"{name}, degree {degree}", found)
    return found


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


def checks(page: Page, found: dict[tuple[str, int], StabilityBoundary]) -> None:
    """The gradients against trains beside the curves, and the curves against each other."""
    page.heading("Checks")
    rows = []
    for degree in DEGREES:
        sparse = found[SPARSE[0], degree]
        for point in (sparse.points[0], sparse.points[-1]):
            rates = [rate(point.base, point.packing + side, 0.0) for side in (-BESIDE, BESIDE)]
            slope = (rates[1] - rates[0]) / (2.0 * BESIDE)
            place = f"D = {point.diameter:.3f}, degree {degree}"
            rows += [
                (
                    f"alpha at {place}, packing lower and higher by {BESIDE:g}",
                    f"{rates[0]:+.2e}, {rates[1]:+.2e}",
                    "growing, decaying",
                ),
                ("d alpha/d packing from them", f"{slope:+.4f}", f"{point.gradient[1]:+.4f}"),
            ]
    page.log("checks")
    coarse, fine = DEGREES
    for name, *_ in (SPARSE, DENSE):
        rows.append(
            (
                f"packing of the boundary at D = 6, {name}",
                f"{at_six(found[name, coarse]):.4f} at degree {coarse}",
                f"{at_six(found[name, fine]):.4f} at degree {fine}",
            )
        )
    first, last = (found[SPARSE[0], fine].points[i] for i in (0, -1))
    rows.append(
        (
            "packing from which the paper's trains are marginal, all D",
            f"{first.packing:.3f} at D = {first.diameter:.2g}, "
            f"{last.packing:.3f} at D = {last.diameter:.2g}",
            "0.4 (its steps are 0.05)",
        )
    )
    page.table(("what", "found", "expected"), rows)


def at_six(boundary: StabilityBoundary) -> float:
    """The packing at D = 6, along the tangent of the nearest point."""
    point = min(boundary.points, key=lambda each: abs(each.diameter - 6.0))
    return point.packing - point.gradient[0] * (6.0 - point.diameter) / point.gradient[1]


def meeting(page: Page, base: Base) -> None:
    """The two fastest tilts of all cells alike around the boundary, with their slopes."""
    page.heading(f"Why the slope is steep at D = 6, degree {base.train.degree}")
    rows, middle = [], base.train.packing
    for beside in AROUND:
        train = base.train.changed(packing=middle + beside)
        base = steady(train, start=base, estimate_error=False)
        spectrum = spectrum_of(base, 0.0)
        values = spectrum.eigenvalues[:2]
        leading = WaveMode(
            float(values[0].real),
            float(values[0].imag),
            TILT,
            0.0,
            spectrum.right[:, 0],
            spectrum.left[:, 0],
        )
        found = wave_sensitivities(base, leading, parameters=["packing"])
        slope = found.entries["packing"].growth_rate
        both = (f"{value.real:+.5f}{value.imag:+.5f}i" for value in values)
        rows.append((f"{train.packing:.4f}", *both, f"{slope:+.4f}"))
    page.log("the meeting of two tilts")
    page.table(("packing", "fastest, U/r0", "second, U/r0", "d alpha/d packing"), rows)


def spectrum_of(base: Base, q: float) -> BlockSpectrum:
    """That of the tilts with one phase."""
    block = linear_blocks(base, [q], [TILT])[TILT][0]
    return block_spectrum(block, neutral_space(base, TILT, 0 if q == 0.0 else 1))


def rate(base: Base, packing: float, q: float) -> float:
    """Growth rate of a tilt in a train of another packing."""
    other = steady(base.train.changed(packing=packing), start=base, estimate_error=False)
    return float(spectrum_of(other, q).eigenvalues[0].real)
