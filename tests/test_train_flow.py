"""The velocity of a train and its exact derivatives on the meridian."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain import Train
from celltrain.harmonics import Profile
from celltrain.meridian import flow_rate
from celltrain.meridian.double_layer import DoubleLayer
from celltrain.meridian.moments import SINGLE, member_matrix
from celltrain.meridian.train import TrainFlow
from celltrain.meridian.wall import WallFlow
from celltrain.steady.problem import SteadyProblem

DEGREE = 8
LARGEST = 3
PHASES = (0.0, 0.9, np.pi)

MakeFlow = Callable[[Profile], TrainFlow]


def train(packing: float) -> Train:
    return Train(diameter=3.6, packing=packing, cells=4, degree=DEGREE)


@pytest.fixture(scope="module", params=[0.3, 0.85], ids=["far", "near"])
def make_flow(request: pytest.FixtureRequest) -> MakeFlow:
    """Flows about shapes with the same rules, fine ones; near cells have images of their own."""
    problem = SteadyProblem(train(request.param))
    rules = problem.rules(shape())
    sizes = {"targets": 40, "image_sources": 90, "image_half_circle": 72, "sources": 70}
    rules = replace(rules, radial=60, half_circle=40, tolerance=1e-13, **sizes)
    assert rules.nearest == (0 if request.param < 0.5 else 1)

    def make(profile: Profile) -> TrainFlow:
        return TrainFlow(
            problem.membrane,
            profile,
            radius=problem.train.radius,
            period=problem.train.period,
            rules=rules,
            largest_azimuthal_number=LARGEST,
        )

    return make


@pytest.fixture(scope="module")
def flow(make_flow: MakeFlow) -> TrainFlow:
    return make_flow(shape())


def shape() -> Profile:
    """Not a steady one, and without a mirror plane."""
    rest = SteadyProblem(train(0.3)).rest
    random = np.random.default_rng(0).normal(size=(2, DEGREE))
    profile = rest + 0.06 * random / (1 + np.arange(DEGREE)) ** 2
    profile[1, 0] = 0.0
    profile[0, 2] -= 0.3
    return profile


def turned(profile: Profile) -> np.ndarray:
    """Every cell turned about the axis, in the members of m = 0."""
    return np.concatenate([np.zeros(2 * DEGREE - 1), profile[1, 1:]])


def test_dynamics_is_the_derivative_of_the_rates(make_flow: MakeFlow) -> None:
    here = shape()
    flow = make_flow(here)
    found = flow.blocks(0, [0.0])[0]
    assert np.abs(found.imag).max() < 1e-12
    random = np.random.default_rng(1)
    h = 2e-3
    for _ in range(4):
        amounts = random.normal(size=2 * DEGREE - 1) / (1 + np.arange(2 * DEGREE - 1) % DEGREE)
        change = np.stack([amounts[:DEGREE], np.append(0.0, amounts[DEGREE:])])
        rates = {i: make_flow(here + i * h * change).rates for i in (-2, -1, 1, 2)}
        slope = (8 * (rates[1] - rates[-1]) - rates[2] + rates[-2]) / (12 * h)
        along = found.real @ np.append(amounts, np.zeros(DEGREE - 1))
        assert_allclose(along, slope, rtol=0, atol=2e-7 * np.abs(slope).max())


def test_a_train_may_be_anywhere(flow: TrainFlow) -> None:
    moved = flow.blocks(0, [0.0])[0][:, 0]
    assert_allclose(moved, 0.0, atol=1e-10)


def test_cells_may_turn_about_the_axis(flow: TrainFlow) -> None:
    # The rates turn with them; those of a steady train have no radial part.
    radial = np.append(np.zeros(2 * DEGREE - 1), flow.rates[DEGREE : 2 * DEGREE - 1])
    assert np.abs(radial).max() > 0.1
    for block in flow.blocks(0, PHASES):
        assert_allclose(block @ turned(shape()), radial, rtol=0, atol=1e-9)


def test_volume_is_kept(flow: TrainFlow) -> None:
    n = flow.volume_gradient
    assert abs(n @ flow.rates) < 1e-13
    alike = flow.blocks(0, PHASES)
    # About a shape that is not steady the direction of n changes, too.
    curved = flow.membrane.volume_hessian(shape(), 0)
    for block in alike:
        assert_allclose(n @ block + flow.rates @ curved, 0.0, atol=1e-12 * np.abs(block).max())


@pytest.mark.parametrize("m", range(LARGEST + 1))
def test_opposite_phases(flow: TrainFlow, m: int) -> None:
    forward, backward, still, alternating = flow.blocks(m, [0.9, -0.9, 0.0, np.pi])
    size = np.abs(forward).max()
    assert np.abs(forward.imag).max() > 1e-6 * size
    assert_allclose(backward, forward.conj(), rtol=0, atol=1e-12 * size)
    assert_allclose(still.imag, 0.0, atol=1e-12 * size)
    assert_allclose(alternating.imag, 0.0, atol=1e-12 * size)


@pytest.mark.parametrize("m", range(LARGEST + 1))
def test_mobility_is_symmetric_and_positive(flow: TrainFlow, m: int) -> None:
    # From forces to velocities; no flow, held flow rate.
    forces = flow.sources.sources(m)
    single = member_matrix(flow.own.at, SINGLE, m)
    kept = np.ones(forces.shape[1], dtype=bool)
    if m == 0:
        kept[0] = False
    if m == 1:
        kept[2 * DEGREE - 3] = False
    for q in PHASES:
        velocity = single + flow.tail.velocity(m, q, flow.tail.of_resting_forces(m, forces))
        for p, image in flow.images.items():
            velocity = velocity + np.exp(1j * q * p) * member_matrix(image.at, SINGLE, m)
        wall = WallFlow(flow.wall_waves(q), m)
        velocity += wall.velocity(wall.of_resting_forces(forces))
        if m == 0 and q == 0.0:
            change = flow_rate.extra_flux_change(
                np.zeros(flow.sources.size),
                flow.source_places[1],
                flow.radius,
                flow.period,
                np.zeros_like(forces),
                forces,
            )
            parabola = flow_rate.parabola(flow.places[1], flow.radius)
            velocity[:, 2] -= np.outer(parabola, change)
        block = flow.targets.projection(m) @ velocity.reshape(-1, velocity.shape[-1])
        if q == 0.0:
            block = block[np.ix_(kept, kept)]
        assert_allclose(block, block.conj().T, rtol=0, atol=1e-10 * np.abs(block).max())
        # The pressure of a membrane's normal forces moves nothing.
        assert np.linalg.eigvalsh(0.5 * (block + block.conj().T)).min() > -1e-11


@pytest.fixture(scope="module")
def layer(flow: TrainFlow) -> DoubleLayer:
    return DoubleLayer(flow)


def rigid_motions(m: int) -> list[np.ndarray]:
    """Of a cell along and about the axis (m = 0), or across it (m = 1), as members."""
    profile, size = shape(), 3 * DEGREE - 2
    if m == 0:
        return [np.eye(size)[0], turned(profile)]
    upward, across = DEGREE - 1, DEGREE - 2
    sideways = np.zeros(upward + across + DEGREE)
    sideways[upward + across] = 1.0
    tilted = np.zeros_like(sideways)
    # About y: u_x = z, u_z = -x.
    tilted[:upward] = -profile[1, 1:] / np.sqrt(2)
    tilted[upward + across :] = profile[0]
    return [sideways, tilted]


@pytest.mark.parametrize("m", [0, 1])
def test_rigid_motions_of_the_double_layer(layer: DoubleLayer, m: int) -> None:
    for q, block in zip(PHASES, layer.blocks(m, PHASES), strict=True):
        for motion in rigid_motions(m):
            moved = block @ motion
            assert_allclose(moved, -0.5 * motion, rtol=0, atol=1e-10, err_msg=f"q = {q}")


@pytest.mark.parametrize("m", range(LARGEST + 1))
def test_double_layer_of_every_phase(layer: DoubleLayer, flow: TrainFlow, m: int) -> None:
    forward, backward, still = layer.blocks(m, [0.9, -0.9, 0.0])
    assert_allclose(backward, forward.conj(), rtol=0, atol=1e-12)
    assert_allclose(still.imag, 0.0, atol=1e-12)
    unit = np.eye(len(still))
    assert_allclose(layer.equation(m, [0.9], 1.0)[0], unit, rtol=0, atol=0)
    assert_allclose(layer.equation(m, [0.9], 4.0)[0], 2.5 * unit + 3 * forward, atol=1e-14)
    if m == 0:
        n = flow.volume_gradient
        assert_allclose(n @ forward, 0.0, atol=1e-12)
    # No mode of a cell grows or falls beyond those of rigid motions and inflation.
    values = np.linalg.eigvals(still)
    assert np.abs(values).max() < 0.5 + 1e-6
