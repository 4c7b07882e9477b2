"""The boundary of stability: the curve itself, and a short piece of it for coarse trains."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from drawn import saved

from celltrain import Base, CaseError, Train, steady
from celltrain.continuation import BoundaryPoint, Steps, boundary, stability_boundary
from celltrain.continuation.boundary import crossing
from celltrain.pictures import draw_stability_boundary
from celltrain.stability import WaveMode, block_spectrum, linear_blocks, neutral_space

M, Q = 1, 0.7


def growth_rate(base: Base) -> float:
    """Of the leading mode with m = 1 and this q."""
    block = linear_blocks(base, [Q], [M])[M][0]
    return float(block_spectrum(block, neutral_space(base, M, 1)).eigenvalues[0].real)


def test_the_curve_is_followed_to_the_side_asked_for(
    coarse_base: Base, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    # A made-up growth rate (D/6)^2 + (phi/0.3)^2 - 2, with its gradient.
    mode = WaveMode(0.1, 0.0, M, Q, np.ones(1, complex), np.ones(1, complex))

    def point(near: BoundaryPoint, values: np.ndarray) -> BoundaryPoint:
        scaled = values / [6.0, 0.3]
        train = near.base.train.changed(diameter=float(values[0]), packing=float(values[1]))
        rate = float(scaled @ scaled - 2.0)
        gradient = 2.0 * scaled / [6.0, 0.3]
        return BoundaryPoint(
            replace(near.base, train=train), replace(mode, growth_rate=rate), gradient
        )

    monkeypatch.setattr(boundary, "_point", point)
    monkeypatch.setattr(boundary, "_modes", lambda base, m, q: [mode])
    start = replace(coarse_base, train=coarse_base.train.changed(packing=0.33))
    for towards, rising in (("packing", True), ("packing", False), ("diameter", True)):
        found = stability_boundary(
            start,
            azimuthal_number=M,
            phase=Q,
            towards=towards,
            rising=rising,
            most_points=8,
            steps=Steps(first=0.05, largest=0.05, tolerance=1e-10),
        )
        assert found.ending.kind == "enough"
        assert len(found.points) == 8
        for each in found.points:
            assert abs(each.mode.growth_rate) < 1e-10
        along = np.array([getattr(each, towards) for each in found.points])
        assert (np.diff(along) * (1.0 if rising else -1.0) > 0.0).all()
    picture = saved(draw_stability_boundary({"tilt": found}), tmp_path / "boundary.png")
    assert picture.stat().st_size > 10_000


def test_a_short_piece_of_a_boundary() -> None:
    # A stiff membrane, with which the tilt hardly grows at this degree.
    train = Train(diameter=6, packing=0.3, cells=1, degree=6, bending_modulus=0.0277)
    start = steady(train, estimate_error=False)
    assert growth_rate(start) > 1e-5
    found = stability_boundary(
        start,
        azimuthal_number=M,
        phase=Q,
        towards="packing",
        most_points=3,
        steps=Steps(first=0.004, largest=0.008, tolerance=1e-8),
    )
    assert found.ending.kind == "enough"
    places = np.array([[point.diameter, point.packing] for point in found.points])
    assert (np.diff(places[:, 1]) > 0.0).all()
    for point in found.points:
        anew = steady(point.base.train, estimate_error=False)
        assert abs(growth_rate(anew)) < 2e-8
    # Along the curve the rate does not change: its gradient, by the trapezoidal rule.
    gradients = np.array([point.gradient for point in found.points])
    middle = 0.5 * (gradients[:-1] + gradients[1:])
    for moved, gradient in zip(np.diff(places, axis=0), middle, strict=True):
        change = moved * gradient
        assert abs(change.sum()) < 0.002 * np.abs(change).max()


def test_what_is_refused(coarse_base: Base) -> None:
    with pytest.raises(CaseError, match="azimuthal_numbers = 7"):
        stability_boundary(coarse_base, azimuthal_number=7, phase=0.0)
    with pytest.raises(CaseError, match="phases = 4"):
        stability_boundary(coarse_base, azimuthal_number=1, phase=4.0)
    with pytest.raises(CaseError, match=r"towards = 'length'.*diameter or packing"):
        stability_boundary(coarse_base, azimuthal_number=1, phase=0.0, towards="length")


def test_the_boundary_is_found_from_afar() -> None:
    start = steady(Train(diameter=6, packing=0.2, cells=1, degree=8), estimate_error=False)
    found = crossing(start, azimuthal_number=1, phase=np.pi)
    assert found.train.tube.diameter == 6.0
    assert found.train.packing != 0.2
    block = linear_blocks(found, [np.pi], [1])[1][0]
    spectrum = block_spectrum(block, neutral_space(found, 1, 1))
    leading = max(
        value.real
        for value, kind in zip(spectrum.eigenvalues, spectrum.kinds, strict=True)
        if not kind
    )
    assert abs(leading) < 1e-4
    with pytest.raises(CaseError, match="does not change its sign with the packing"):
        crossing(start, azimuthal_number=3, phase=0.0)
