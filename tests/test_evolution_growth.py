"""Simulations beside the linear theory, and beside themselves at other tolerances.

Of one cell in a period, coarse: what is exact must hold for it, too.
"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain import Base, Stability, Train, evolve, stability, steady
from celltrain.evolution import (
    Disturbance,
    FastestAtFirst,
    FromFile,
    Leading,
    NumberedMode,
    RandomDisplacement,
    RungeKuttaChebyshev,
)
from celltrain.evolution.dynamics import train_dynamics

# Large enough for nothing else to matter, small enough for the linear theory.
SMALL = 1e-3
TRAIN = Train(diameter=6, packing=0.2, cells=1, degree=6, tolerance=1e-7)


@pytest.fixture(scope="module")
def calm() -> Base:
    """A train whose disturbances all decay in the end."""
    return steady(TRAIN, estimate_error=False)


@pytest.fixture(scope="module")
def tilting(calm: Base) -> Base:
    """A train whose tilt grows without oscillating: membranes that are stiffer in bending."""
    stiffer = TRAIN.changed(bending_modulus=10.0 * TRAIN.cell.bending_modulus)
    return steady(stiffer, start=calm, estimate_error=False)


@pytest.fixture(scope="module")
def analysed() -> Callable[[Base, float], Stability]:
    """The linear dynamics at a viscosity ratio, on which the steady train does not depend.

    Azimuthal numbers 0 and 2 are what the correction of the volume adds to disturbances of 1.
    """

    def at_ratio(base: Base, ratio: float) -> Stability:
        viscous = replace(base, train=base.train.changed(viscosity_ratio=ratio))
        return stability(viscous, azimuthal_numbers=(0, 1, 2), estimate_error=False)

    return at_ratio


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [1.0, pytest.param(5.0, marks=pytest.mark.slow)])
def test_the_leading_mode_grows_at_its_rate(analysed, tilting: Base, ratio: float) -> None:
    start = analysed(tilting, ratio)
    mode = start.leading
    assert mode.growth_rate > 0.01
    # An oscillating mode that stands would not grow as exp(alpha t) at every moment.
    assert mode.frequency == pytest.approx(0.0, abs=1e-9)
    run = evolve(start, Leading(SMALL), degree=6, until=24.0, every=8.0)
    eps = run.frames["eps"]
    assert_allclose(np.log(eps[1:] / eps[:-1]) / 8.0, mode.growth_rate, rtol=1e-2)
    assert_allclose(run.history["eps_exponential"], run.history["eps"], rtol=1e-2)
    # And so of a much smaller disturbance, beside which the solver's own error is not small.
    dynamics = train_dynamics(start.base, run.repulsion, wall_gap=run.state.wall_gap)
    change = Leading(1e-6).shapes(start)
    linear = mode.growth_rate * change
    rates = dynamics.rates(np.asarray(dynamics.base) + change)
    assert_allclose(rates, linear, rtol=0, atol=1e-2 * np.abs(linear).max())


def test_the_transient_disturbance_follows_the_propagator_through_its_peak(
    analysed, calm: Base
) -> None:
    start = analysed(calm, 1.0)
    # Its first step is short enough for a growth at first.
    run = evolve(
        start,
        FastestAtFirst(SMALL),
        degree=6,
        until=3.0,
        every=0.25,
        integrator=RungeKuttaChebyshev(),
    )
    eps, linear = run.frames["eps"], run.frames["eps_linear"]
    peak = int(np.argmax(linear))
    assert 0 < peak < len(linear) - 1
    assert linear[peak] > 1.05 * linear[0]
    assert linear[-1] < 0.95 * linear[peak]
    assert abs(int(np.argmax(eps)) - peak) <= 1
    assert_allclose(eps, linear, rtol=1e-2)
    # At first it grows nearly at the numerical abscissa, and not faster.
    history = run.history
    first = np.log(history["eps"][1] / history["eps"][0]) / history["time"][1]
    assert 0.9 * start.numerical_abscissa < first < 1.001 * start.numerical_abscissa


def test_half_the_tolerance_changes_the_size_by_less_than_the_tolerance(calm: Base) -> None:
    tolerances = (2e-3, 1e-3, 5e-4)
    runs = [
        evolve(
            calm,
            RandomDisplacement(0.3, seed=1),
            degree=6,
            until=8.0,
            every=1.0,
            integrator=RungeKuttaChebyshev(tolerance),
        )
        for tolerance in tolerances
    ]
    steps = [run.steps for run in runs]
    assert steps[0] < steps[1] < steps[2]
    eps = [run.frames["eps"] for run in runs]
    for tolerance, one, half in zip(tolerances, eps, eps[1:], strict=False):
        change = np.abs(half / one - 1.0).max()
        assert 1e-3 * tolerance < change < tolerance


@pytest.mark.parametrize(
    ("disturbance", "words"),
    [
        (Leading(0.1), "the leading mode, eps 0.1 r0"),
        (NumberedMode(2, 0.1, phase=0.5), "mode 2, eps 0.1 r0, phase 0.5"),
        (FastestAtFirst(1e-3), "what grows fastest at first, eps 0.001 r0"),
        (RandomDisplacement(0.1, seed=3), "random displacements, seed 3, eps 0.1 r0"),
        (FromFile(Path("run.nc")), "that of run.nc"),
        (FromFile(Path("run.nc"), 0.2), "that of run.nc, eps 0.2 r0"),
    ],
)
def test_disturbances_are_told_in_words(disturbance: Disturbance, words: str) -> None:
    assert str(disturbance) == words
