"""The exponential method: its steps, and the choice between it and the stabilised one."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from same_runs import assert_same
from scipy.integrate import solve_ivp

from celltrain.evolution import (
    Automatic,
    CellsInFlow,
    ExponentialAdams,
    FastestAtFirst,
    Leading,
    RandomDisplacement,
    Repulsion,
    RungeKuttaChebyshev,
    StepFailed,
    evolve,
    follow,
    resume,
)
from celltrain.evolution.dynamics import Dynamics, train_dynamics
from celltrain.evolution.linear_part import LinearPart, step_of
from celltrain.evolution.methods import AutomaticMemory, ExponentialMemory, Manner, Step, Work
from celltrain.evolution.methods.automatic import (
    AGAIN,
    ASSUMED_COST,
    COUNTED,
    SETTLING_EXPONENTIAL,
    SETTLING_STABILISED,
    _counted,
)
from celltrain.evolution.methods.control import step_factor, with_volumes
from celltrain.evolution.methods.runge_kutta_chebyshev import RADIUS_STEPS
from celltrain.evolution.state import State
from celltrain.harmonics import Shapes
from celltrain.parameters import CaseError, Resolution
from celltrain.stability import Stability
from celltrain.steady import Base
from celltrain.surroundings import simple_shear


@pytest.fixture(scope="module")
def dynamics(coarse_base: Base) -> Dynamics:
    return train_dynamics(coarse_base, Repulsion(), wall_gap=0.8)


def test_which_corrections_of_volumes_are_allowed(dynamics: Dynamics) -> None:
    state = dynamics.state(0.0, np.asarray(dynamics.base))

    def followed(relative: float, correction: float, tolerance: float) -> tuple[float, bool]:
        measures = replace(state.measures, volume_correction=correction)
        return with_volumes(relative, replace(state, measures=measures), tolerance)

    assert followed(0.7, 1e-7, 1e-3) == (0.7, True)
    assert followed(1.01, 1e-7, 1e-3) == (1.01, False)
    # At the bound the next step is a little shorter, not by the margin that errors have.
    relative, accepted = followed(0.1, 1e-5, 1e-3)
    assert accepted
    assert step_factor(1.0, relative, 0.0, 0.0) == pytest.approx(0.95)
    assert not followed(0.1, 1.01e-5, 1e-3)[1]
    # Not less than this, however small the tolerance is.
    assert followed(0.1, 0.99e-6, 1e-9)[1]
    assert not followed(0.1, 1.01e-6, 1e-9)[1]
    for each in (followed(np.nan, 0.0, 1e-3), followed(0.1, np.nan, 1e-3)):
        assert np.isnan(each[0])
        assert not each[1]


@pytest.mark.parametrize("method", [ExponentialAdams(1e-2), RungeKuttaChebyshev(1e-2)])
def test_steps_are_shortened_where_volumes_would_change(
    method: Any, coarse_base: Base, monkeypatch: pytest.MonkeyPatch
) -> None:
    single = replace(coarse_base, train=coarse_base.train.changed(cells=1))

    def corrections() -> np.ndarray:
        settings = {"degree": 6, "until": 2.0, "every": 2.0, "integrator": method}
        run = evolve(single, RandomDisplacement(0.3, seed=1), **settings)
        return run.history["volume_correction"][1:]

    free = corrections()
    allowed = free.max() / 5.0
    monkeypatch.setattr("celltrain.evolution.methods.control.VOLUME_SHARE", 0.0)
    monkeypatch.setattr("celltrain.evolution.methods.control.SMALLEST_CORRECTION", allowed)
    bounded = corrections()
    assert 0.1 * allowed < bounded.max() <= allowed
    assert len(bounded) > len(free)


def test_of_a_small_disturbance_a_long_step_is_exact(coarse_stability: Stability) -> None:
    """A step of 8 r0/U, eighty times what Euler's method may take."""
    small = 1e-6
    dynamics = train_dynamics(coarse_stability.base, Repulsion(), wall_gap=0.8)
    begin = dynamics.state(0.0, np.asarray(dynamics.base) + Leading(small).shapes(coarse_stability))
    method = ExponentialAdams()
    step = method.advance(dynamics, begin, replace(method.begin(begin), step=8.0))
    assert step.manner.size == 8.0
    assert step.work == Work(rejected=0, evaluations=2)
    growth = step.state.measures.eps / begin.measures.eps
    assert_allclose(growth, np.exp(8.0 * coarse_stability.leading.growth_rate), rtol=1e-3)


def marched(dynamics: Dynamics, begin: State, sizes: list[float]) -> State:
    """The state after steps of these sizes, whatever their errors."""
    method = ExponentialAdams(1e6)
    state, memory = begin, method.begin(begin)
    for size in sizes:
        step = method.advance(dynamics, state, replace(memory, step=size))
        assert step.manner.size == size
        state, memory = step.state, step.memory
    return state


@pytest.fixture(scope="module")
def displaced_cell(coarse_base: Base) -> tuple[Dynamics, State, Shapes]:
    """One cell, displaced, and its shape 1 r0/U later, as good as exactly."""
    single = replace(coarse_base, train=coarse_base.train.changed(cells=1))
    dynamics = train_dynamics(single, Repulsion(), wall_gap=0.8)
    disturbance = RandomDisplacement(0.3, seed=1)
    begin = dynamics.state(0.0, np.asarray(dynamics.base) + disturbance.shapes(single))

    def rates(time: float, shapes: np.ndarray) -> np.ndarray:
        del time
        return dynamics.rates(shapes.reshape(begin.shapes.shape)).ravel()

    accurate = {"rtol": 1e-9, "atol": 1e-9}
    found = solve_ivp(rates, (0.0, 1.0), begin.shapes.ravel(), method="DOP853", **accurate)
    return dynamics, begin, found.y[:, -1].reshape(begin.shapes.shape)


@pytest.mark.parametrize(
    ("pattern", "levels"),
    [((0,), (-4, -6, -8)), ((0, 2, 2), (-6, -8))],
    ids=["equal steps", "unequal steps"],
)
def test_order_of_the_method_on_a_train(
    pattern: tuple[int, ...],
    levels: tuple[int, ...],
    displaced_cell: tuple[Dynamics, State, Shapes],
) -> None:
    dynamics, begin, exact = displaced_cell
    errors = []
    for level in levels:
        part = [step_of(level - shorter) for shorter in pattern]
        end = marched(dynamics, begin, part * round(1.0 / sum(part)))
        errors.append(float(np.abs(end.shapes - exact).max()))
    assert errors[-1] > 1e-7
    assert_allclose(np.log2(np.array(errors[:-1]) / errors[1:]), 3.0, atol=0.5)


class NoLinearPart(LinearPart):
    """L = 0, of which the functions are 1, 1/2 and 1/6."""

    def turns(self, shapes: np.ndarray) -> np.ndarray:
        return np.zeros((len(shapes), 3, 3))

    def applied(self, turns: np.ndarray, change: np.ndarray) -> np.ndarray:
        return 0.0 * change

    def phi_1(self, level: int, turns: np.ndarray, change: np.ndarray) -> np.ndarray:
        return change

    def phi_2(self, level: int, turns: np.ndarray, change: np.ndarray) -> np.ndarray:
        return change / 2.0

    def phi_3(self, level: int, turns: np.ndarray, change: np.ndarray) -> np.ndarray:
        return change / 6.0


class Clock:
    """The first number goes evenly, the rate of the second is the square of the first."""

    def __init__(self, like: State, base: Base) -> None:
        self.like, self.linear_part = like, NoLinearPart(base)

    def rates(self, shapes: np.ndarray) -> np.ndarray:
        rates = np.zeros_like(shapes)
        rates[0, 0, 0], rates[0, 0, 1] = 1.0, shapes[0, 0, 0] ** 2
        return rates

    def state(self, time: float, shapes: np.ndarray) -> State:
        return replace(self.like, time=time, shapes=shapes, rates=self.rates(shapes))

    def continuous(self, shapes: np.ndarray, laps: np.ndarray) -> np.ndarray:
        del laps
        return shapes

    def displacement(self, change: np.ndarray) -> float:
        return float(np.abs(change).max())

    departure = displacement


def test_of_rates_that_are_parabolas_unequal_steps_are_exact(
    dynamics: Dynamics, coarse_base: Base
) -> None:
    clock: Any = Clock(dynamics.state(0.0, np.asarray(dynamics.base)), coarse_base)
    begin = clock.state(0.0, np.zeros_like(dynamics.base))
    # The first step, which knows none before, is of second order: its error is taken away.
    first = marched(clock, begin, [0.5])
    error = first.shapes[0, 0, 1] - 0.5**3 / 3.0
    end = marched(clock, begin, [0.5, 0.25, 1.0, 1.0, step_of(1)])
    assert_allclose(end.shapes[0, 0, 1] - error, end.time**3 / 3.0, rtol=1e-13)


def test_estimated_errors_are_near_the_true_ones(coarse_base: Base) -> None:
    single = replace(coarse_base, train=coarse_base.train.changed(cells=1))
    dynamics = train_dynamics(single, Repulsion(), wall_gap=0.8)
    method = ExponentialAdams()
    shapes = np.asarray(dynamics.base) + RandomDisplacement(0.3, seed=1).shapes(single)
    state = dynamics.state(0.0, shapes)
    memory = method.begin(state)
    ratios = []
    for _ in range(6):
        step = method.advance(dynamics, state, memory)
        exact, small = state, 8
        for _ in range(small):
            fine = replace(method.begin(exact), step=step.manner.size / small)
            fixed = ExponentialAdams(1e3, largest_step=step.manner.size / small)
            exact = fixed.advance(dynamics, exact, fine).state
        assert exact.time == pytest.approx(step.state.time, rel=1e-12)
        wrong = dynamics.displacement(step.state.shapes - exact.shapes)
        ratios.append(step.manner.error / wrong)
        state, memory = step.state, step.memory
    assert 0.3 < np.median(ratios) < 30.0
    assert min(ratios) > 0.1


def test_it_takes_few_evaluations_to_the_same_end(coarse_stability: Stability) -> None:
    settings = {"degree": 6, "until": 10.0, "every": 10.0}
    exponential, stabilised = (
        evolve(coarse_stability, Leading(0.02), integrator=method, **settings)
        for method in (ExponentialAdams(), RungeKuttaChebyshev())
    )
    assert exponential.work.evaluations < stabilised.work.evaluations / 2
    assert_allclose(exponential.frames["eps"], stabilised.frames["eps"], rtol=2e-3)


def test_frames_within_steps_follow_the_linear_dynamics(coarse_stability: Stability) -> None:
    """However fast it is: modes decay at up to 21 U/r0."""
    fast = FastestAtFirst(1e-4)
    run = evolve(coarse_stability, fast, degree=6, until=4.0, every=0.1)
    assert run.history["size"].max() > 5 * 0.1
    assert np.isnan(run.history["radius"]).all()
    assert_allclose(run.frames["eps"], run.frames["eps_linear"], rtol=3e-3)


def test_steps_that_fail_and_steps_that_lead_nowhere_end_a_run(
    coarse_base: Base, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Exponential steps fail, and after stabilised ones cells overlap: shorter ones are tried."""
    single = replace(coarse_base, train=coarse_base.train.changed(cells=1))

    def failing(*_: object) -> Step[ExponentialMemory]:
        raise StepFailed("step_too_small", "never", rejected=3, evaluations=5)

    monkeypatch.setattr(ExponentialAdams, "advance", failing)
    calls = []

    def overlaps(self: Dynamics, shapes: np.ndarray) -> list[str]:
        calls.append(shapes)
        return ["cell 0 and cell 1 overlap"] if len(calls) > 2 else []

    monkeypatch.setattr(Dynamics, "overlaps", overlaps)
    run = evolve(single, RandomDisplacement(0.1), degree=6, until=1.0, every=1.0)
    assert run.ending.kind == "overlap"
    assert len(calls) < 20
    # What was tried in vain is counted.
    assert run.work.rejected >= 3
    assert run.work.evaluations > 5


def test_where_stabilised_steps_fail_exponential_ones_go_on(
    coarse_base: Base, monkeypatch: pytest.MonkeyPatch
) -> None:
    def failing(*_: object) -> Step[Any]:
        raise StepFailed("not_finite", "never")

    monkeypatch.setattr(RungeKuttaChebyshev, "advance", failing)
    monkeypatch.setattr("celltrain.evolution.methods.automatic.ASSUMED_COST", 0.0)
    single = replace(coarse_base, train=coarse_base.train.changed(cells=1))
    largest = Automatic(largest_step=0.1)
    run = evolve(
        single, RandomDisplacement(0.1), degree=6, until=3.0, every=3.0, integrator=largest
    )
    assert run.ending.kind == "complete"
    assert isinstance(run.memory, AutomaticMemory)
    assert run.memory.stabilised_cost == np.inf


def test_other_cells_are_refused_at_once(coarse_base: Base) -> None:
    cells = CellsInFlow(coarse_base.train.cell, simple_shear(1.0), Resolution(degree=6))
    for method in (Automatic(), ExponentialAdams()):
        with pytest.raises(CaseError, match="allowed: RungeKuttaChebyshev, ForwardEuler"):
            next(follow(cells, cells.resting([[0.0, 0.0, 0.0]]), until=1.0, integrator=method))


def test_cells_without_a_train_are_refused(dynamics: Dynamics) -> None:
    state = dynamics.state(0.0, np.asarray(dynamics.base))
    method = ExponentialAdams()
    with pytest.raises(CaseError, match="allowed: RungeKuttaChebyshev"):
        method.advance(replace(dynamics, linear_part=None), state, method.begin(state))


@pytest.mark.parametrize("method", [ExponentialAdams, Automatic])
@pytest.mark.parametrize("name", ["tolerance", "largest_step"])
def test_settings(method: Callable[..., object], name: str) -> None:
    with pytest.raises(CaseError, match=rf"{name} = -1"):
        method(**{name: -1.0})


def taken(memory: Any, state: State, evaluations: int, size: float) -> Step[Any]:
    """A step that nobody took."""
    return Step(state, memory, Manner(size, 2, 0.0, 1.0), Work(evaluations=evaluations))


def test_the_cheaper_method_goes_on(dynamics: Dynamics) -> None:
    state = dynamics.state(0.0, np.asarray(dynamics.base))

    def after(memory: AutomaticMemory, steps: int, evaluations: int, size: float) -> Any:
        for _ in range(steps):
            memory = _counted(taken(memory.exponential, state, evaluations, size), memory).memory
        return memory

    begin = Automatic().begin(state)
    assert not begin.stabilised
    # Both methods have taken a step before.
    begin = replace(
        begin,
        exponential=replace(begin.exponential, last_step=1.0, last_error=0.5),
        chebyshev=replace(begin.chebyshev, last_step=1.0, last_error=0.5),
    )
    # What the first steps cost says nothing.
    settled = after(begin, SETTLING_EXPONENTIAL, 2, 0.01)
    cheap = after(settled, 3 * COUNTED, 2, 1.0)
    assert not cheap.stabilised
    assert cheap.exponential.last_step == 1.0
    assert cheap.spent == 2 * (SETTLING_EXPONENTIAL + 3 * COUNTED)
    assert not after(cheap, COUNTED - 1, 2, 0.1).stabilised
    dear = after(cheap, COUNTED, 2, 0.1)
    assert (dear.stabilised, dear.stabilised_cost) == (True, ASSUMED_COST)
    # What was known of the spectral radius is of a time long ago, and the last step not of ours.
    assert dear.chebyshev.radius_age == RADIUS_STEPS
    for each in (dear.exponential, dear.chebyshev):
        assert (each.last_step, each.last_error) == (0.0, 0.0)
    # Stabilised steps go on until the others are tried again, whatever they cost.
    settled = after(dear, SETTLING_STABILISED, 16, 0.01)
    assert settled.stabilised_cost == ASSUMED_COST
    counted = after(settled, COUNTED, 16, 2.0)
    assert (counted.stabilised, counted.stabilised_cost) == (True, pytest.approx(8.0))
    memory, steps = dear, 0
    while memory.stabilised:
        memory, steps = after(memory, 1, 16, 1.0), steps + 1
    assert 16 * (steps - COUNTED) < AGAIN <= 16 * steps
    assert memory.stabilised_cost == pytest.approx(16.0)
    # Which they are if they cost less than that.
    tried = SETTLING_EXPONENTIAL + COUNTED
    assert not after(memory, tried, 2, 0.2).stabilised
    assert after(memory, tried, 2, 0.1).stabilised


@pytest.mark.parametrize("steps", [3, 4, 5])
def test_runs_go_on_bit_for_bit_across_changes_of_the_method(
    steps: int, coarse_base: Base, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Two steps by each method, and two again; files end at each place in these."""
    for name, value in (
        ("COUNTED", 1),
        ("SETTLING_EXPONENTIAL", 1),
        ("SETTLING_STABILISED", 1),
        ("ASSUMED_COST", 0.0),
        ("AGAIN", 0),
    ):
        monkeypatch.setattr(f"celltrain.evolution.methods.automatic.{name}", value)
    single = replace(coarse_base, train=coarse_base.train.changed(cells=1))
    settings = {"degree": 6, "until": 50.0, "every": 0.2}
    whole = evolve(single, RandomDisplacement(0.2), most_steps=6, **settings)
    exponential = np.isnan(whole.history["radius"][1:])
    assert exponential.tolist() == [True, True, False, False, True, True]
    path = tmp_path / "run.nc"
    evolve(single, RandomDisplacement(0.2), most_steps=steps, path=path, **settings)
    assert_same(resume(path, most_steps=6 - steps), whole)


def test_where_exponential_steps_fail_stabilised_ones_go_on(
    coarse_base: Base, monkeypatch: pytest.MonkeyPatch
) -> None:
    def failing(*_: object) -> Step[ExponentialMemory]:
        raise StepFailed("step_too_small", "never")

    monkeypatch.setattr(ExponentialAdams, "advance", failing)
    single = replace(coarse_base, train=coarse_base.train.changed(cells=1))
    run = evolve(single, RandomDisplacement(0.1), degree=6, until=0.2, every=0.2)
    assert run.ending.kind == "complete"
    assert isinstance(run.memory, AutomaticMemory)
    assert run.memory.stabilised
    assert np.isfinite(run.history["radius"][1:]).all()
