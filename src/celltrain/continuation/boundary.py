"""The boundary of stability: the curve alpha(D, phi) = 0 of one mode.

The growth rate alpha of a mode with azimuthal number m and phase q is a function of the
tube's diameter D and the packing phi, with an exact gradient (`wave_sensitivities`). Its zero is
followed by its arclength in (D/D0, phi/phi0), D0 and phi0 those of the start; as one equation in
two unknowns it needs no other treatment than a branch does. From one train to the next the mode is
recognised by its overlap |<l, r>| with the adjoint mode before.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, ClassVar

import numpy as np
import scipy  # loads its parts when they are used
from jaxtyping import Complex, Float

from celltrain.continuation.arclength import (
    CurveEnding,
    CurveLost,
    Evaluation,
    NoSolution,
    Steps,
    Unknowns,
    trace_curve,
)
from celltrain.parameters import CaseError
from celltrain.quantities import Quantity, Record, quantity
from celltrain.stability import block_spectrum, check_linearisable, linear_blocks
from celltrain.stability.infinite import WaveMode, check_phases
from celltrain.stability.neutral import neutral_space
from celltrain.stability.parameter_sensitivity import wave_sensitivities
from celltrain.steady import Base, NotConverged, steady

#: Growth rates of points on the boundary are below the tolerance, in U/r0.
BOUNDARY_STEPS = Steps(first=0.02, largest=0.1, tolerance=1e-7)

#: Factors of the packing at which the other side of the boundary is sought, one after another.
FACTORS = (1.0, 1.1, 0.9, 1.25, 0.8, 1.5, 0.65, 2.0, 0.5, 2.5, 0.35, 3.0)
# Part of the interval to which the boundary is sought there.
CLOSE = 1e-3
# The two parameters, in the order of the unknowns.
PLANE = ("diameter", "packing")


@dataclass(frozen=True, eq=False)
class BoundaryPoint(Record):
    """A train with a mode that neither grows nor decays.

    `gradient` is (d alpha/dD, d alpha/d phi), which points into the unstable side.
    """

    base: Base
    mode: WaveMode
    gradient: Annotated[
        Float[np.ndarray, "2"],
        Quantity("", "U/r0", "derivatives of the growth rate by diameter and packing", ("plane",)),
    ]

    @property
    @quantity(Quantity("D", "r0", "diameter of the tube"))
    def diameter(self) -> float:
        """D, in r0."""
        return self.base.train.tube.diameter

    @property
    @quantity(Quantity(r"\phi", "1", "packing"))
    def packing(self) -> float:
        """The packing phi."""
        return self.base.train.packing


@dataclass(frozen=True, eq=False)
class StabilityBoundary(Record):
    """Points of the boundary in order, and why there are no more."""

    kind: ClassVar[str] = "boundary"
    title: ClassVar[str] = "boundary of stability in diameter and packing"

    points: tuple[BoundaryPoint, ...]
    ending: CurveEnding

    @property
    def base(self) -> Base:
        """The last steady train."""
        return self.points[-1].base


def stability_boundary(
    start: Base,
    *,
    azimuthal_number: int,
    phase: float,
    towards: str = "diameter",
    rising: bool = True,
    most_points: int = 20,
    steps: Steps = BOUNDARY_STEPS,
    progress: Callable[[BoundaryPoint], None] | None = None,
) -> StabilityBoundary:
    """The curve on which a mode neither grows nor decays, from a train close to it.

    What was found is kept when the curve ends early, also by an interruption.

    **Arguments:**

    - `azimuthal_number`, `phase`: m and q (radians per cell) of the mode; of all that have
      them the leading one of the start is followed.
    - `towards`, `rising`: to which side: that where "diameter" or "packing" rises, or falls.

    **Raises:** `CaseError` for what is not allowed.
    """
    points: list[BoundaryPoint] = []
    ending = CurveEnding("enough", f"{most_points} points were found")
    followed = follow_boundary(
        start,
        azimuthal_number=azimuthal_number,
        phase=phase,
        towards=towards,
        rising=rising,
        steps=steps,
    )
    try:
        for point in followed:
            points.append(point)
            if progress is not None:
                progress(point)
            if len(points) >= most_points:
                break
    except CurveLost as failure:
        ending = CurveEnding("lost", str(failure))
    except KeyboardInterrupt:
        ending = CurveEnding("interrupted", "interrupted")
    return StabilityBoundary(tuple(points), ending)


def crossing(start: Base, *, azimuthal_number: int, phase: float) -> Base:
    """A train of the same diameter on, or next to, the boundary of its leading mode.

    The leading growth rate alpha(phi) of these azimuthal number and phase is computed at `FACTORS`
    of the start's packing until its sign changes, and its zero sought between (Brent's method).

    **Raises:** `CaseError` if the sign does not change where there are trains.
    """
    known: dict[float, tuple[float, Base]] = {}

    def rate(packing: float) -> float:
        if packing not in known:
            near = min(known, key=lambda each: abs(each - packing), default=None)
            base = start if near is None else known[near][1]
            if packing != base.train.packing:
                train = start.train.changed(packing=packing)
                base = steady(train, start=base, estimate_error=False)
            known[packing] = (_modes(base, azimuthal_number, phase)[0].growth_rate, base)
        return known[packing][0]

    for factor in FACTORS:
        packing = factor * start.train.packing
        try:
            rate(packing)
        except (CaseError, NotConverged):
            continue
        for low, high in pairwise(sorted(known)):
            if rate(low) * rate(high) <= 0.0:
                found = scipy.optimize.brentq(rate, low, high, xtol=CLOSE * (high - low))
                rate(found)
                return known[found][1]
    rates = ", ".join(f"{known[each][0]:.2g} at {each:.3g}" for each in sorted(known))
    raise CaseError(
        f"packing = {start.train.packing:g} is not allowed: the largest growth rate for m ="
        f" {azimuthal_number}, q = {phase:.4g} does not change its sign with the packing ({rates});"
        " allowed: a case from which it does"
    )


def follow_boundary(
    start: Base,
    *,
    azimuthal_number: int,
    phase: float,
    towards: str = "diameter",
    rising: bool = True,
    steps: Steps = BOUNDARY_STEPS,
) -> Iterator[BoundaryPoint]:
    """The points of `stability_boundary` one by one, as they are found, without end.

    **Raises:** `CaseError` as `stability_boundary` does; `CurveLost` when there is no way on.
    """
    check_linearisable(start.train, [azimuthal_number])
    check_phases(np.array([phase]))
    if towards not in PLANE:
        raise CaseError(f"towards = {towards!r} is not allowed; allowed: {' or '.join(PLANE)}")
    first = np.array([start.train.leaf(name) for name in PLANE])
    direction = np.where(np.array(PLANE) == towards, 1.0 if rising else -1.0, 0.0)
    leading = _modes(start, azimuthal_number, phase)[0]
    known = BoundaryPoint(start, leading, np.zeros(2))

    def evaluate(unknowns: Unknowns, near: BoundaryPoint) -> Evaluation[BoundaryPoint]:
        point = _point(near, first * unknowns)
        return Evaluation(
            residual=np.array([point.mode.growth_rate]),
            jacobian=(first * point.gradient)[None],
            error=abs(point.mode.growth_rate),
            state=point,
        )

    for point in trace_curve(evaluate, np.ones(2), direction, known, steps):
        yield point.state


def _point(near: BoundaryPoint, values: Float[np.ndarray, "2"]) -> BoundaryPoint:
    """The train at some diameter and packing, with the mode that continues one nearby.

    **Raises:** `NoSolution` if there is none.
    """
    changes = dict(zip(PLANE, map(float, values), strict=True))
    try:
        train = near.base.train.changed(**changes)
        base = near.base
        if train != base.train:
            base = steady(train, start=base, estimate_error=False)
    except (CaseError, NotConverged) as error:
        raise NoSolution(str(error)) from None
    before = near.mode
    mode = max(
        _modes(base, before.azimuthal_number, before.phase),
        key=lambda each: _overlap(before.left, each.right),
    )
    found = wave_sensitivities(base, mode, parameters=PLANE)
    gradient = np.array([found.entries[name].growth_rate for name in PLANE])
    return BoundaryPoint(base, mode, gradient)


def _modes(base: Base, m: int, q: float) -> list[WaveMode]:
    """The modes of A_m(q) that are not neutral, by falling growth rate."""
    block = linear_blocks(base, [q], [m])[m][0]
    spectrum = block_spectrum(block, neutral_space(base, m, 0 if q == 0.0 else 1))
    return [
        WaveMode(
            float(value.real), float(value.imag), m, q, spectrum.right[:, i], spectrum.left[:, i]
        )
        for i, (value, kind) in enumerate(zip(spectrum.eigenvalues, spectrum.kinds, strict=True))
        if not kind
    ]


def _overlap(left: Complex[np.ndarray, " size"], right: Complex[np.ndarray, " size"]) -> float:
    return float(abs(left.conj() @ right) / np.linalg.norm(right))
