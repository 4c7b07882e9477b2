"""Marching a train: the integrators as formulas, then on trains; disturbances; predictions."""

import dataclasses
import itertools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.linalg
from numpy.testing import assert_allclose, assert_array_equal

from celltrain import Base, CaseError, Stability
from celltrain.diagnostics import disturbance_amplitude
from celltrain.evolution import (
    Disturbance,
    FastestAtFirst,
    ForwardEuler,
    FromFile,
    Leading,
    NumberedMode,
    RandomDisplacement,
    Repulsion,
    RungeKuttaChebyshev,
    evolve,
    linear_prediction,
)
from celltrain.evolution.dynamics import Dynamics, train_dynamics
from celltrain.evolution.methods.chebyshev import (
    chebyshev_step,
    embedded_error,
    largest_stable_step,
    stage_count,
)
from celltrain.evolution.methods.radius import spectral_radius
from celltrain.evolution.record.interpolation import interpolated
from celltrain.evolution.start import at_degree
from celltrain.harmonics import UNIT_DISPLACEMENT, azimuthal_basis
from celltrain.membrane import place_cells
from celltrain.proximity.overlaps import overlaps
from celltrain.proximity.walls import RoundWall
from celltrain.stability import PaperNorm


def stiff_system() -> np.ndarray:
    """A matrix that is not normal, with eigenvalues from 0.5 down to -400."""
    random = np.random.default_rng(0)
    values = np.concatenate([[0.5, -0.3, -1.0, -2.0], -np.geomspace(5, 400, 8)])
    vectors = np.linalg.qr(random.normal(size=(12, 12)))[0]
    vectors = vectors + 0.2 * random.normal(size=(12, 12)) / np.sqrt(12)
    return vectors @ np.diag(values) @ np.linalg.inv(vectors)


@pytest.mark.parametrize("stages", [2, 3, 7, 20, 150])
def test_stability_polynomial_of_the_chebyshev_method(stages: int) -> None:
    def polynomial(z: np.ndarray) -> np.ndarray:
        return chebyshev_step(lambda y: z * y, np.ones_like(z), z, 1.0, stages)

    # Bounded by one on the whole interval of stability, and below it inside.
    assert stage_count(1.0, 1e-9) == 2
    longest = largest_stable_step(stages, 1.0)
    assert stage_count(longest, 1.0) == stages
    assert stage_count(longest * 1.01, 1.0) == stages + 1
    z = -np.linspace(0.0, longest, 4001)
    assert np.abs(polynomial(z)).max() <= 1.0 + 1e-12
    assert np.abs(polynomial(z[z < -4.0])).max(initial=0.0) < 0.97
    # It grows not far beyond: stages are not wasted.
    assert abs(polynomial(np.array([-0.9 * stages**2]))[0]) > 1.0
    # Second order: 1 + z + z^2/2 + O(z^3).
    small = np.array([1e-3, -1e-3, 1e-2, -1e-2])
    assert_allclose(
        polynomial(small), 1 + small + small**2 / 2, rtol=0, atol=np.abs(small**3).max()
    )
    left = polynomial(small) - (1 + small + small**2 / 2)
    assert np.all(np.abs(left) < np.abs(small) ** 3)


def test_order_of_the_chebyshev_method_on_a_stiff_system() -> None:
    matrix = stiff_system()
    # Of the fast transients the method only says that they decay, so they are over here.
    start = scipy.linalg.expm(0.3 * matrix) @ np.random.default_rng(1).normal(size=12)
    exact = scipy.linalg.expm(2.0 * matrix) @ start
    errors = []
    for count in (16, 32, 64, 128):
        step, here = 2.0 / count, start
        for _ in range(count):
            here = chebyshev_step(
                lambda y: matrix @ y, here, matrix @ here, step, stage_count(step, 420.0)
            )
        errors.append(np.abs(here - exact).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert_allclose(orders[-2:], 2.0, atol=0.15)
    assert errors[-1] < 1e-3


def test_embedded_error_estimates_the_local_error() -> None:
    matrix = np.array([[-0.3, 2.0], [-2.0, -0.3]])
    start = np.array([1.0, 0.5])
    sizes = []
    for step in (0.2, 0.1, 0.05):
        end = chebyshev_step(lambda y: matrix @ y, start, matrix @ start, step, 4)
        estimate = embedded_error(start, matrix @ start, end, matrix @ end, step)
        true = np.linalg.norm(scipy.linalg.expm(step * matrix) @ start - end)
        sizes.append(np.linalg.norm(estimate))
        assert 0.2 < sizes[-1] / true < 5.0
    assert_allclose(np.log2(np.array(sizes[:-1]) / sizes[1:]), 3.0, atol=0.2)


def test_interpolation_is_exact_for_cubic_polynomials() -> None:
    cubic = np.polynomial.Polynomial([0.3, -1.2, 0.7, 2.1])
    slope = cubic.deriv()
    ends = [(t, np.array([cubic(t)]), np.array([slope(t)])) for t in (0.4, 1.9)]
    for t in (0.4, 0.9, 1.3, 1.9):
        assert_allclose(interpolated(t, *ends), cubic(t), rtol=1e-13)


def test_power_iteration_finds_the_spectral_radius() -> None:
    matrix = stiff_system()
    random = np.random.default_rng(2)

    def rates(y: np.ndarray) -> np.ndarray:
        return matrix @ y + 0.1 * np.sin(y)

    at = random.normal(size=12)
    exact = np.abs(np.linalg.eigvals(matrix + 0.1 * np.diag(np.cos(at)))).max()
    found = spectral_radius(rates, at, rates(at), random.normal(size=12))
    assert_allclose(found.radius, exact, rtol=3e-2)
    # From the direction found before, two evaluations confirm it.
    again = spectral_radius(rates, at, rates(at), found.direction)
    assert again.evaluations == 2
    assert_allclose(again.radius, exact, rtol=2e-2)


@pytest.fixture(scope="session")
def dynamics(coarse_base: Base) -> Dynamics:
    return train_dynamics(coarse_base, Repulsion(), wall_gap=0.8)


@pytest.fixture(scope="session")
def single(coarse_base: Base) -> Base:
    """A train of one cell, which costs least; its steady shape is that of any number of cells."""
    return dataclasses.replace(coarse_base, train=coarse_base.train.changed(cells=1))


def disturbed(dynamics: Dynamics, start: Stability, size: float) -> np.ndarray:
    shapes = np.asarray(dynamics.base) + Leading(size).shapes(start)
    return dynamics.settle(shapes).shapes


def test_the_steady_train_is_at_rest_in_its_frame(dynamics: Dynamics) -> None:
    rates = dynamics.rates(np.asarray(dynamics.base))
    assert dynamics.displacement(rates) == 0.0
    assert dynamics.departure(np.asarray(dynamics.base)) == 0.0
    moved = dynamics.tube_rates(rates)[:, 2, 0] / UNIT_DISPLACEMENT
    assert_allclose(moved, dynamics.cell_velocity, rtol=1e-14)
    # What its frame takes with it is what the operator's rules leave.
    left = dynamics.steady_rates - dynamics.tube_rates(np.zeros_like(rates))
    assert 1e-9 < dynamics.displacement(left) < 1e-3


def test_a_steady_train_stays_at_rest(coarse_base: Base) -> None:
    change = np.zeros((3, 3, 36))
    still = evolve(coarse_base, NoDisturbance(change), degree=6, until=5.0, every=5.0)
    assert still.frames["eps"][-1] < 1e-10


@dataclasses.dataclass(frozen=True)
class NoDisturbance(Disturbance):
    """A given change of the shapes."""

    change: np.ndarray

    def shapes(self, start: Base | Stability) -> np.ndarray:
        return self.change


def test_starts_of_another_degree_are_computed_at_the_simulations(
    coarse_base: Base, coarse_stability: Stability
) -> None:
    assert at_degree(coarse_base, 6) is coarse_base
    assert at_degree(coarse_stability, 6) is coarse_stability
    case = coarse_base.train
    found = at_degree(coarse_base, None)
    assert isinstance(found, Base)
    assert found.train == case.changed(degree=12)
    assert found.residual < 1e-9
    assert found.cell_velocity == pytest.approx(coarse_base.cell_velocity, rel=2e-2)
    few = dataclasses.replace(coarse_stability, azimuthal_numbers=(0, 1))
    for start, degree, numbers in (
        (coarse_stability, 7, tuple(range(8))),
        (few, 7, (0, 1)),
        (case, None, tuple(range(7))),
        (case.changed(degree=None), 7, tuple(range(8))),
    ):
        result = at_degree(start, degree)
        assert isinstance(result, Stability)
        assert result.azimuthal_numbers == numbers
        assert result.base.train.degree == (6 if degree is None else degree)


def test_order_of_the_chebyshev_method_on_a_train(single: Base) -> None:
    dynamics = train_dynamics(single, Repulsion(), wall_gap=0.8)
    start = np.asarray(dynamics.base) + RandomDisplacement(0.5, seed=1).shapes(single)
    # Of the fast modes the method only says that they decay, so they are over here.
    for _ in range(6):
        start = chebyshev_step(dynamics.rates, start, dynamics.rates(start), 0.2, 6)
    first = dynamics.rates(start)
    found = []
    for count in (2, 4, 8, 16):
        step, here, rate = 1.6 / count, start, first
        for _ in range(count):
            # As many stages for short steps as for long ones: the error depends on them.
            here = chebyshev_step(dynamics.rates, here, rate, step, 7)
            rate = dynamics.rates(here)
        found.append(here)
    changes = [dynamics.displacement(b - a) for a, b in itertools.pairwise(found)]
    assert changes[0] > changes[1] > changes[2]
    assert changes[2] < 1e-4
    assert_allclose(0.5 * np.log2(changes[0] / changes[2]), 2.0, atol=0.2)


def test_cells_that_leave_the_window_are_put_back(
    dynamics: Dynamics, coarse_stability: Stability
) -> None:
    train = coarse_stability.base.train
    here = disturbed(dynamics, coarse_stability, 0.3)
    gone = here.copy()
    gone[:, 2, 0] += UNIT_DISPLACEMENT * train.length * np.array([0.0, 2.0, -1.0])
    settled = dynamics.settle(gone)
    assert settled.laps.tolist() == [0, 2, -1]
    assert_allclose(settled.shapes, here, rtol=0, atol=1e-12)
    assert_allclose(dynamics.continuous(settled.shapes, settled.laps), gone, rtol=0, atol=1e-12)
    # The disturbance is that of where the cells have gone: two lengths and one.
    assert_allclose(settled.measures.eps_x, train.length * np.sqrt(5.0), rtol=2e-2)
    # All moved by a third of the window: the last cell changes ends, the flow is the same.
    moved = here.copy()
    moved[:, 2, 0] += UNIT_DISPLACEMENT * train.period
    wrapped = dynamics.settle(moved)
    assert wrapped.laps.tolist() == [0, 0, 1]
    error = dynamics.rates(wrapped.shapes) - dynamics.rates(here)
    assert dynamics.displacement(error) < 1e-6


def test_volumes_and_what_is_measured(dynamics: Dynamics, coarse_stability: Stability) -> None:
    shapes = np.asarray(dynamics.base) * 1.01
    shapes[:, 2, 0] = np.asarray(dynamics.base)[:, 2, 0]
    settled = dynamics.settle(shapes)
    volumes = jax.vmap(dynamics.operator.membrane.volume)(jnp.asarray(settled.shapes))
    assert_allclose(volumes, np.asarray(dynamics.volumes), rtol=1e-8)
    # A swelling by 1 % is taken back along the normal: by about 0.01 times the cell's size.
    assert 0.005 < settled.measures.volume_correction < 0.03
    steady = dynamics.settle(np.asarray(dynamics.base))
    assert steady.measures.volume_correction < 1e-10
    assert steady.measures.eps < 1e-9
    assert settled.measures.energy > steady.measures.energy > 0.0
    sphere = 4 * np.pi * len(shapes)
    assert steady.measures.area > sphere
    moved = np.asarray(dynamics.base).copy()
    moved[1, 0, 0] += 0.3 * UNIT_DISPLACEMENT
    shifted = dynamics.settle(moved)
    assert_allclose(shifted.measures.eps_x, 0.3, rtol=1e-9)
    assert_allclose(shifted.measures.eps, 0.3 * np.sqrt(2.0), rtol=1e-9)


def test_the_amplitude_is_the_norm_of_the_paper(coarse_stability: Stability) -> None:
    # One cell disturbed by a member of a basis: the Gram matrix of the norm gives its square.
    base = coarse_stability.base
    for m in (0, 1, 2):
        gram = PaperNorm().grams(base.coefficients, [m])[m]
        basis = azimuthal_basis(base.train.degree, m)
        amounts = np.random.default_rng(m).normal(size=len(basis))
        change = np.zeros((3, 3, basis.shape[-1]))
        change[1] = np.einsum("u,uik->ik", amounts, basis)
        assert_allclose(disturbance_amplitude(change) ** 2, amounts @ gram @ amounts, rtol=1e-12)


@pytest.mark.parametrize(
    "disturbance",
    [
        Leading(0.1),
        Leading(0.02, phase=1.0),
        NumberedMode(5, 0.3),
        FastestAtFirst(1e-3),
        RandomDisplacement(0.2),
    ],
)
def test_disturbances_have_the_amplitude_asked_for(coarse_stability, disturbance) -> None:
    change = disturbance.shapes(coarse_stability)
    assert change.shape == (3, 3, 36)
    assert_allclose(disturbance_amplitude(change), disturbance.amplitude, rtol=1e-12)


def test_modes_as_disturbances(coarse_stability: Stability) -> None:
    first = next(mode for mode in coarse_stability.modes if not mode.neutral)
    assert_array_equal(
        Leading(0.1).shapes(coarse_stability), NumberedMode(1, 0.1).shapes(coarse_stability)
    )
    assert Leading(0.1).growth_rate(coarse_stability) == first.growth_rate
    fifth = [mode for mode in coarse_stability.modes if not mode.neutral][4]
    assert NumberedMode(5, 0.1).growth_rate(coarse_stability) == fifth.growth_rate
    along = np.vdot(NumberedMode(5, 1.0).shapes(coarse_stability), coarse_stability.shape(fifth))
    sizes = [np.linalg.norm(each(coarse_stability)) for each in (NumberedMode(5, 1.0).shapes,)]
    assert_allclose(along, sizes[0] * np.linalg.norm(coarse_stability.shape(fifth)), rtol=1e-12)
    for number in (0, 10000):
        with pytest.raises(CaseError, match=f"mode {number} .* allowed: (1 to|a whole)"):
            NumberedMode(number, 0.1).shapes(coarse_stability)
    with pytest.raises(CaseError, match="its stability is needed"):
        Leading(0.1).shapes(coarse_stability.base)
    with pytest.raises(CaseError, match=r"amplitude = -1"):
        Leading(-1.0)


def test_random_displacements_are_rigid_and_fixed_by_their_seed(coarse_base: Base) -> None:
    one, same = (RandomDisplacement(0.2, seed=3).shapes(coarse_base) for _ in range(2))
    other = RandomDisplacement(0.2, seed=4).shapes(coarse_base)
    assert_array_equal(one, same)
    assert np.abs(one - other).max() > 1e-2
    assert np.all(one[:, :, 1:] == 0.0)
    assert len(np.unique(one[:, :, 0])) == 9
    # The root of the sum of squares of the displacements times sqrt(2) is eps.
    assert_allclose(np.sqrt(2 * np.sum((one[:, :, 0] / UNIT_DISPLACEMENT) ** 2)), 0.2, rtol=1e-12)


def test_disturbances_from_arrays(coarse_base: Base, tmp_path) -> None:
    change = np.random.default_rng(5).normal(size=(3, 3, 36))
    path = tmp_path / "change.npy"
    np.save(path, change)
    assert_array_equal(FromFile(path).shapes(coarse_base), change)
    assert_allclose(disturbance_amplitude(FromFile(path, 0.1).shapes(coarse_base)), 0.1, rtol=1e-12)
    np.save(path, change[:2])
    with pytest.raises(CaseError, match=r"\(2, 3, 36\).*\(3, 3, 36\)"):
        FromFile(path).shapes(coarse_base)
    with pytest.raises(CaseError, match=r"missing\.npy"):
        FromFile(tmp_path / "missing.npy").shapes(coarse_base)


def test_linear_prediction_of_a_mode_and_of_the_transient(coarse_stability: Stability) -> None:
    rate = coarse_stability.leading.growth_rate
    # A wave of three cells, whose size does not depend on its phase.
    assert coarse_stability.leading.wave_number == 1
    leading = linear_prediction(coarse_stability, Leading(1e-3).shapes(coarse_stability))
    for time in (0.0, 3.0, 40.0):
        assert_allclose(leading.eps(time), 1e-3 * np.exp(rate * time), rtol=1e-8)
    # Several times at once, evenly spread and not, in both sizes.
    times = np.array([0.0, 2.0, 4.0, 40.0])
    eps, eps_x = leading.sizes(times)
    displaced = Leading(1e-3).shapes(coarse_stability)
    first = np.sqrt(np.sum(displaced**2) / (4.0 * np.pi))
    for size, begin in ((eps, 1e-3), (eps_x, first)):
        assert_allclose(size, begin * np.exp(rate * times), rtol=1e-8)
    # At first the transient grows at the numerical abscissa, and nothing else does.
    step = 1e-5
    transient = linear_prediction(coarse_stability, FastestAtFirst(1.0).shapes(coarse_stability))
    growth = (transient.eps(step) - transient.eps(0.0)) / step
    assert_allclose(growth, coarse_stability.numerical_abscissa, rtol=1e-3)
    few = dataclasses.replace(coarse_stability, azimuthal_numbers=(1,))
    assert np.isnan(linear_prediction(few, Leading(1.0).shapes(coarse_stability)).eps(1.0))


def test_a_small_mode_grows_as_predicted(coarse_stability: Stability) -> None:
    run = evolve(coarse_stability, Leading(1e-3), degree=6, until=30.0, every=10.0)
    assert run.ending.kind == "complete"
    assert run.times.tolist() == [0.0, 10.0, 20.0, 30.0]
    eps = run.frames["eps"]
    assert_allclose(eps[0], 1e-3, rtol=1e-6)
    rates = np.log(eps[1:] / eps[:-1]) / 10.0
    assert_allclose(rates, coarse_stability.leading.growth_rate, rtol=1e-2)
    assert_allclose(eps, run.frames["eps_linear"], rtol=1e-3)
    history = run.history
    assert_allclose(history["eps_exponential"], history["eps_linear"], rtol=1e-6)
    assert history["volume_correction"].max() < 1e-5
    # Each step was within its tolerance; steps grew to fifty times what Euler's method may take.
    allowed = 1e-3 * np.maximum(1e-3, history["eps_x"])
    assert np.all(history["error"] <= allowed)
    assert history["size"].max() > 5.0
    assert run.work.evaluations < 40


def test_any_small_disturbance_evolves_as_predicted(coarse_stability: Stability) -> None:
    # Random displacements hold m = 0 and both families of m = 1, and all wave numbers.
    run = evolve(coarse_stability, RandomDisplacement(1e-3, seed=1), degree=6, until=6.0, every=2.0)
    eps, linear = run.frames["eps"], run.frames["eps_linear"]
    assert_allclose(eps, linear, rtol=5e-3)
    assert np.abs(np.diff(linear)).min() > 1e-5


def test_large_and_small_steps_agree(single: Base) -> None:
    runs = [
        evolve(single, RandomDisplacement(0.5), degree=6, until=1.0, every=1.0, integrator=method)
        for method in (RungeKuttaChebyshev(tolerance=1e-3), ForwardEuler(0.0125))
    ]
    adaptive, euler = (run.disturbances[-1] for run in runs)
    assert np.linalg.norm(adaptive - euler) < 2e-3 * np.linalg.norm(euler)
    assert runs[1].work.evaluations == 81
    assert runs[0].work.evaluations < 60
    assert runs[0].history["volume_correction"][1:].max() < 1e-5
    assert runs[1].history["volume_correction"][1:].max() < 1e-5


def test_overlaps_are_named(coarse_base: Base) -> None:
    train = coarse_base.train
    shapes = place_cells(coarse_base.coefficients, train, 3)

    def met(shapes: np.ndarray) -> list[str]:
        found = overlaps(shapes, period=train.length, wall=RoundWall(train.radius))
        return [str(each) for each in found]

    assert met(shapes) == []
    ahead = shapes.copy()
    ahead[1, 2, 0] += (train.period - 0.5) * UNIT_DISPLACEMENT
    assert "cell 1 and cell 2 overlap" in met(ahead)[0]
    last = shapes.copy()
    last[2, 2, 0] += (train.period - 0.5) * UNIT_DISPLACEMENT
    assert "overlap" in met(last)[0]
    aside = shapes.copy()
    aside[2, 0, 0] += 2.0 * UNIT_DISPLACEMENT
    assert "cell 2" in met(aside)[0]
    assert "wall" in met(aside)[0]
