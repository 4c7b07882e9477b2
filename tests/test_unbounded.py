"""Cells in unbounded space: exact results for spheres, small deformation, and what follows them."""

import math
from collections.abc import Callable

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain.diagnostics import best_ellipsoid, cell_moments, stresslets
from celltrain.evolution import CellsInFlow, Repulsion, RungeKuttaChebyshev, follow
from celltrain.flow import Sources
from celltrain.harmonics import UNIT_DISPLACEMENT, displaced, real_harmonics, surface_points
from celltrain.parameters import CaseError, Cell, Resolution
from celltrain.proximity.distances import cell_distance, wall_distance
from celltrain.proximity.overlaps import overlaps
from celltrain.surroundings import (
    FlowRules,
    RoundTube,
    Surroundings,
    UnboundedSpace,
    simple_shear,
)
from celltrain.train import CellsOperator

DEGREE = 6
RESOLUTION = Resolution(degree=DEGREE, polar_radial=24, polar_azimuthal=36)
# A flow without symmetry: strain and rotation.
GRADIENT = ((0.3, 0.8, -0.2), (0.1, -0.5, 0.4), (-0.6, 0.2, 0.2))
STRAIN = 0.5 * (np.array(GRADIENT) + np.array(GRADIENT).T)
ROTATION = np.array(GRADIENT) - STRAIN
# Of the neo-Hookean law, with Es = 2 Gs.
SHEAR_MODULUS = 7.0
CAPSULE = Cell(
    reference="sphere",
    law="neo_hookean",
    shear_modulus=2.0 * SHEAR_MODULUS,
    bending_modulus=0.0,
)
Rates = Callable[[CellsOperator, np.ndarray], np.ndarray]


def cells(viscosity_ratio: float = 1.0, cell: Cell = CAPSULE) -> CellsInFlow:
    return CellsInFlow(cell, UnboundedSpace(GRADIENT), RESOLUTION, viscosity_ratio)


@pytest.fixture(scope="module")
def operator() -> CellsOperator:
    return cells().operator(close=False)


@pytest.fixture(scope="module")
def viscous() -> CellsOperator:
    return cells(viscosity_ratio=5.0).operator(close=False)


@pytest.fixture(scope="module")
def rates() -> Rates:
    compiled = eqx.filter_jit(lambda operator, shapes: operator.rates(shapes))
    return lambda operator, shapes: np.asarray(compiled(operator, jnp.asarray(shapes)))


@pytest.fixture(scope="module")
def sphere() -> np.ndarray:
    return cells().resting([(0.0, 0.0, 0.0)])


def moved(operator: CellsOperator, shapes: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Coefficients of matrix . x on the cells."""
    return np.einsum("ij,cjk->cik", matrix, shapes)


def rigid_forces(shapes: np.ndarray) -> np.ndarray:
    """Force on the fluid that a rigid unit sphere exerts in the strain: -5 E.n for each area."""
    return -5.0 * np.einsum("ij,cjk->cik", STRAIN, shapes)


def test_a_rigid_sphere_in_a_linear_flow(operator: CellsOperator, sphere: np.ndarray) -> None:
    velocity = eqx.filter_jit(lambda operator, *given: operator.surface_velocity(*given))
    found = velocity(operator, jnp.asarray(sphere), jnp.asarray(rigid_forces(sphere)))
    points = np.asarray(operator.targets(jnp.asarray(sphere)))
    assert_allclose(found, points @ ROTATION.T, rtol=0, atol=1e-9)


def test_the_flow_around_a_rigid_sphere(sphere: np.ndarray) -> None:
    operator = cells().operator()
    directions = np.random.default_rng(0).normal(size=(30, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    # Close to the surface, too, where the graded rule serves.
    distance = np.geomspace(1.001, 20.0, 30)[:, None]
    x = directions * distance
    along = np.sum(x * (x @ STRAIN), axis=1, keepdims=True)
    expected = -2.5 * x * along * (distance**-5 - distance**-7) - x @ STRAIN / distance**5

    @eqx.filter_jit
    def flow(operator, points, shapes, forces):
        sources = operator.sources(shapes, forces)
        targets = points[None, :, None]
        owners = jnp.array([-1])
        return operator.flow.velocity(targets, owners, sources, background=False)[0, :, 0]

    found = flow(operator, *(jnp.asarray(each) for each in (x, sphere, rigid_forces(sphere))))
    assert_allclose(found, expected, rtol=0, atol=2e-6)


@pytest.mark.parametrize("ratio", [5.0, 0.2])
def test_a_sphere_without_forces_strains_as_one(
    viscous: CellsOperator, rates: Rates, sphere: np.ndarray, ratio: float
) -> None:
    """Fluid of the viscosity ratio lam in a sphere: its rate of strain is 5/(2 lam + 3) E."""
    operator = eqx.tree_at(lambda o: o.viscosity_ratio, viscous, jnp.asarray(ratio))
    expected = moved(operator, sphere, ROTATION + 5.0 / (2.0 * ratio + 3.0) * STRAIN)
    assert_allclose(rates(operator, sphere), expected, rtol=0, atol=1e-7)


def steady_in_strain(operator: CellsOperator, rates: Rates, sphere: np.ndarray) -> np.ndarray:
    """Change of the sphere's shape that makes it steady in the strain, to first order.

    By symmetry a E.n + b (n.E.n) n, of which the rates are sums of two such fields again.
    """
    step = 1e-4
    still = eqx.tree_at(lambda o: o.flow.gradient, operator, jnp.zeros((3, 3)))
    strained = eqx.tree_at(lambda o: o.flow.gradient, operator, jnp.asarray(STRAIN))
    grid = operator.target_grid
    n = surface_points(sphere[0], np.asarray(grid.values))
    along = np.sum(n * (n @ STRAIN), axis=1, keepdims=True)
    radial = (np.asarray(grid.projection) @ (along * n)).T[None]
    fields = [moved(operator, sphere, STRAIN), radial]
    slopes = [
        (rates(still, sphere + step * each) - rates(still, sphere - step * each)) / (2 * step)
        for each in fields
    ]
    columns = np.stack([each.ravel() for each in slopes], axis=1)
    driven = rates(strained, sphere).ravel()
    amounts, residual, *_ = np.linalg.lstsq(columns, -driven, rcond=None)
    assert float(residual[0]) < 1e-10 * np.sum(driven**2)
    return np.tensordot(amounts, np.stack(fields), axes=1)


def deformation(operator: CellsOperator, shape: np.ndarray) -> np.ndarray:
    """Semi-axes of the cell's ellipsoid of inertia."""
    return np.asarray(best_ellipsoid(cell_moments(operator.membrane, shape).solid).semi_axes)


@pytest.mark.parametrize("ratio", [1.0, 5.0])
def test_small_deformation(
    operator: CellsOperator,
    viscous: CellsOperator,
    rates: Rates,
    sphere: np.ndarray,
    ratio: float,
) -> None:
    """In simple shear D = 25/12 mu k a/Gs: semi-axes 1 + 25/6 E/Gs, whatever the viscosity."""
    chosen = operator if ratio == 1.0 else viscous
    change = steady_in_strain(chosen, rates, sphere)
    size = 1e-3
    axes = deformation(chosen, jnp.asarray(sphere[0] + size * change[0]))
    expected = 25.0 / 6.0 / SHEAR_MODULUS * np.linalg.eigvalsh(STRAIN)
    assert_allclose((axes - 1.0) / size, expected, rtol=0, atol=2e-3)


def test_laws_with_the_same_moduli_deform_alike(sphere: np.ndarray, rates: Rates) -> None:
    """A Skalak membrane with Ed = Es (C = 1) has the neo-Hookean one's small deformation."""
    modulus = 2.0 * SHEAR_MODULUS
    skalak = Cell(
        reference="sphere", shear_modulus=modulus, dilatation_modulus=modulus, bending_modulus=0.0
    )
    found, expected = (
        steady_in_strain(cells(cell=cell).operator(close=False), rates, sphere)
        for cell in (skalak, CAPSULE)
    )
    assert_allclose(found, expected, rtol=0, atol=1e-6)


def test_stresslets(
    operator: CellsOperator, viscous: CellsOperator, rates: Rates, sphere: np.ndarray
) -> None:
    """That of a rigid sphere, 20 pi/3 E, which a steady capsule has to first order, too."""
    rigid = 20.0 * math.pi / 3.0 * STRAIN
    still = jnp.zeros_like(sphere)
    found = stresslets(operator, jnp.asarray(sphere), jnp.asarray(rigid_forces(sphere)), still)
    assert_allclose(found[0], rigid, rtol=0, atol=1e-12)
    size = 1e-4
    shapes = jnp.asarray(sphere + size * steady_in_strain(operator, rates, sphere))
    found = stresslets(operator, shapes, operator.forces(shapes), still)
    assert_allclose(found[0] / size, rigid, rtol=0, atol=0.02)
    # Without forces, the stress of the fluid inside: 5 (lam - 1)/(2 lam + 3) 4 pi/3 2 E.
    ratio = float(viscous.viscosity_ratio)
    motion = jnp.asarray(rates(viscous, sphere))
    found = stresslets(viscous, jnp.asarray(sphere), still, motion)
    fluid = 40.0 * math.pi / 3.0 * (ratio - 1.0) / (2.0 * ratio + 3.0)
    assert_allclose(found[0], fluid * STRAIN, rtol=0, atol=1e-6)


def test_point_forces_and_the_background(operator: CellsOperator) -> None:
    random = np.random.default_rng(1)
    points, forces = random.normal(size=(2, 2, 8, 3))
    targets = random.normal(size=(20, 3)) + np.array([4.0, 0.0, 0.0])
    d = targets[:, None] - points.reshape(-1, 3)
    f, r = forces.reshape(-1, 3), np.linalg.norm(d, axis=2, keepdims=True)
    expected = np.sum(f / r + d * np.sum(d * f, axis=2, keepdims=True) / r**3, axis=1)
    expected = expected / (8.0 * math.pi) + targets @ np.array(GRADIENT).T
    sources = Sources(jnp.asarray(points)[:, :, None], jnp.asarray(forces)[:, :, None])
    flow = operator.flow.velocity(jnp.asarray(targets)[None, :, None], jnp.array([-1]), sources)
    assert_allclose(flow[0, :, 0], expected, rtol=0, atol=1e-12)


def test_a_wide_tube_is_unbounded() -> None:
    """What wall and images add to forces without a sum falls as the cube of the tube's size."""
    random = np.random.default_rng(2)
    points, forces, targets = random.normal(size=(3, 12, 3))
    forces -= forces.mean(axis=0)
    sources = Sources(jnp.asarray(points)[None, :, None], jnp.asarray(forces)[None, :, None])
    rules = FlowRules(
        near_cutoff=2.5,
        tolerance=1e-7,
        wall_gap=3.0,
        extent=2.5,
        close=None,
        near_wall=True,
        coarse_beyond=math.inf,
    )

    def velocity(around: Surroundings) -> np.ndarray:
        made = around.flow(rules)
        given = (jnp.asarray(targets)[None, :, None], jnp.array([-1]), sources)
        found = eqx.filter_jit(made.velocity)(*given, background=False)
        return np.asarray(found)[0, :, 0]

    free = velocity(UnboundedSpace())
    errors = [
        np.linalg.norm(velocity(RoundTube(radius, 4.0 * radius)) - free) for radius in (8.0, 16.0)
    ]
    assert errors[0] < 0.03 * np.linalg.norm(free)
    assert errors[0] / errors[1] == pytest.approx(8.0, rel=0.1)


def test_a_cell_turns_with_the_fluid() -> None:
    """At rest in a flow that rotates as a whole it is carried with it, to where that goes."""
    rate = 0.7
    spin = UnboundedSpace(((0.0, -rate, 0.0), (rate, 0.0, 0.0), (0.0, 0.0, 0.0)))
    turning = CellsInFlow(Cell(), spin, Resolution(degree=DEGREE))
    shapes = turning.resting([(2.0, 0.0, 0.5)])
    method = RungeKuttaChebyshev(tolerance=1e-5)
    found = list(follow(turning, shapes, until=1.0, every=0.4, integrator=method))
    assert [each.time for each in found] == pytest.approx([0.0, 0.4, 0.8, 1.0])
    for each in found:
        c, s = math.cos(rate * each.time), math.sin(rate * each.time)
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        assert_allclose(each.shapes, turn @ shapes, rtol=0, atol=2e-4)


def test_two_cells_stay_each_others_image() -> None:
    """In simple shear, turned by pi about the middle; each makes way for the other."""
    pair = CellsInFlow(CAPSULE, simple_shear(1.0), RESOLUTION, repulsion=Repulsion(0.0))
    shapes = pair.resting([(-1.3, 0.4, 0.0), (1.3, -0.4, 0.0)])
    last = list(follow(pair, shapes, until=1.0, every=1.0))[-1].shapes
    turn = np.diag([-1.0, -1.0, 1.0])
    theta, phi = np.random.default_rng(3).uniform(0.0, math.pi, size=(2, 20))
    here, there = (
        surface_points(last[cell], real_harmonics(DEGREE, theta, phi + angle))
        for cell, angle in ((0, 0.0), (1, math.pi))
    )
    assert_allclose(there, here @ turn, rtol=0, atol=1e-6)
    assert last[0, 1, 0] > shapes[0, 1, 0]


def test_a_capsule_in_a_tube_is_carried_along_its_axis() -> None:
    """Beyond the end of the period, and slower than the fluid on the axis would be without it."""
    tube = CellsInFlow(CAPSULE, RoundTube(1.7, 4.0), Resolution(degree=DEGREE, tolerance=1e-4))
    shapes = tube.resting([(0.0, 0.0, 1.9)])
    found = list(follow(tube, shapes, until=0.3, every=0.1))
    heights = np.array([each.shapes[0, 2, 0] for each in found]) / UNIT_DISPLACEMENT
    assert heights[-1] > 2.2
    speeds = np.diff(heights) / 0.1
    assert ((speeds > 1.2) & (speeds < 2.0)).all()
    assert_allclose(found[-1].shapes[0, :2, 0], 0.0, atol=1e-5)


def test_distances_where_nothing_recurs() -> None:
    shapes = cells().resting([(0.0, 0.0, 0.0), (0.0, 0.0, 2.3), (0.0, 2.7, 2.3)])
    assert_allclose(cell_distance(shapes, math.inf), [0.3, 0.3, 0.7], atol=1e-7)
    assert cell_distance(shapes[:1], math.inf) == [math.inf]
    assert (wall_distance(shapes, UnboundedSpace().wall) == math.inf).all()
    assert overlaps(shapes, period=math.inf) == ()
    shapes[1] = displaced(shapes[1], np.array([0.0, 0.0, -0.5]))
    assert [(each.first, each.second) for each in overlaps(shapes, period=math.inf)] == [(0, 1)]


def test_what_makes_no_sense_is_refused() -> None:
    with pytest.raises(CaseError, match=r"trace is 0\.5"):
        UnboundedSpace(((0.5, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
    with pytest.raises(CaseError, match="three rows of three numbers"):
        UnboundedSpace(((math.nan, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
    with pytest.raises(CaseError, match="radius = -1"):
        RoundTube(-1.0, 5.0)
    with pytest.raises(CaseError, match="viscosity_ratio = 0"):
        cells(viscosity_ratio=0.0)
    shapes = cells().resting([(0.0, 0.0, 0.0), (0.5, 0.0, 0.0)])
    with pytest.raises(CaseError, match="overlap"):
        follow(cells(), shapes, until=1.0)
    with pytest.raises(CaseError, match="at degree 6 they are"):
        follow(cells(), shapes[..., :-1], until=1.0)
    with pytest.raises(CaseError, match="until = 0"):
        follow(cells(), shapes[:1], until=0.0)
    with pytest.raises(CaseError, match="that of a tube"):
        cells().operator().effective_viscosity(jnp.asarray(shapes), jnp.zeros_like(shapes))
