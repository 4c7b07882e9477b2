"""The double layer: what is exact for it on spheres, and on any cells in the tube.

K w = (1/8 pi) PV int T_ijk(y - x) w_j n_k dS,   T_ijk(r) = -6 r_i r_j r_k/r^5
"""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain import Train
from celltrain.compiled.kernels import UNFOLD
from celltrain.flow import own_surface_rule
from celltrain.flow.own_surface import OwnSurfaceRule
from celltrain.harmonics import UNIT_DISPLACEMENT, coefficient_index
from celltrain.harmonics.grid import sphere_grid
from celltrain.harmonics.tables import harmonic_tables
from celltrain.train import CellsOperator, resting_shapes, train_operator

DEGREE = 7


@pytest.fixture(scope="module")
def grid():
    return sphere_grid(DEGREE, DEGREE + 1)


@pytest.fixture(scope="module")
def free_rule(grid) -> OwnSurfaceRule:
    """The rule for the kernels of free space."""
    theta = np.asarray(grid.theta)
    return own_surface_rule(DEGREE, theta, radial=20, azimuthal=30, parameter=0.0)


@pytest.fixture(scope="module")
def unit_sphere() -> np.ndarray:
    shape = np.zeros((1, 3, DEGREE * DEGREE))
    for i, order in enumerate((1, -1, 0)):
        shape[0, i, coefficient_index(1, order)] = np.sqrt(4 * np.pi / 3)
    return shape


def vector_harmonics(n: int, m: int, grid) -> dict[str, np.ndarray]:
    """Boundary values [point, 3] of flows about the unit sphere, by their names.

    V: gradient of r^-(n + 1) Y, W: gradient of r^n Y, X: r x gradient of Y.
    """
    theta, phi = grid.points()
    tables = harmonic_tables(n + 1, theta, phi)
    place = coefficient_index(n, m)
    y, down, across = (
        np.asarray(each)[:, place, None] for each in (tables.value, tables.d_theta, tables.d_phi)
    )
    across = across / np.sin(theta)[:, None]
    sine, cosine = np.sin(theta), np.cos(theta)
    radial = np.stack([sine * np.cos(phi), sine * np.sin(phi), cosine], axis=-1)
    along = np.stack([cosine * np.cos(phi), cosine * np.sin(phi), -sine], axis=-1)
    around = np.stack([-np.sin(phi), np.cos(phi), 0 * phi], axis=-1)
    slope = along * down + around * across
    return {
        "V": -(n + 1) * radial * y + slope,
        "W": n * radial * y + slope,
        "X": around * down - along * across,
    }


def eigenvalues(kind: str, n: int) -> tuple[float, float]:
    """Of the single and of the double layer on the unit sphere, by Green's identity.

    The flow inside with these boundary values has the traction 2 (n - 1) W or (n - 1) X, the one
    outside -2 (n + 2) V or -(n + 2) X; the jump of the tractions is the single layer's density.
    """
    if kind == "V":
        single = n / ((2 * n + 1) * (2 * n + 3))
        return single, 0.5 - 2 * (n + 2) * single
    if kind == "W":
        single = (n + 1) / ((2 * n + 1) * (2 * n - 1))
        return single, 2 * (n - 1) * single - 0.5
    return 1 / (2 * n + 1), (n - 1) / (2 * n + 1) - 0.5


@pytest.mark.parametrize("kind", ["V", "W", "X"])
@pytest.mark.parametrize("n", [1, 2, 3, 5])
def test_sphere_eigenvalues(free_rule, unit_sphere, grid, kind: str, n: int) -> None:
    values = vector_harmonics(n, min(2, n), grid)[kind]
    # V has components of degree n + 1.
    assert n + 1 < DEGREE
    coefficients = np.einsum("kp,pi->ik", grid.projection, values)[None]
    single, double = eigenvalues(kind, n)
    shape = jnp.asarray(unit_sphere)
    targets = jnp.einsum("pk,cik->cpi", grid.values, shape)
    targets = targets.reshape(1, grid.rings, grid.azimuths, 3)
    # With a parameter of 0 the near kernel is that in free space.
    kernel, _ = free_rule.double_layer(targets, grid.phi, shape)
    kernel = kernel[..., UNFOLD, :]
    found = np.einsum("craijk,cjk->crai", kernel, coefficients).reshape(values.shape)
    assert_allclose(found, double * values, rtol=0, atol=1e-9)
    found = free_rule.velocity(targets, grid.phi, shape, jnp.asarray(coefficients))
    assert_allclose(found.reshape(values.shape), single * values, rtol=0, atol=1e-9)


TRAIN = Train(
    diameter=5,
    packing=0.3,
    cells=2,
    degree=8,
    source_order=28,
    target_order=11,
    polar_radial=30,
    polar_azimuthal=44,
    tolerance=1e-9,
    viscosity_ratio=5.0,
)


@pytest.fixture(scope="module")
def operator() -> CellsOperator:
    return train_operator(TRAIN, cells=2)


@pytest.fixture(scope="module")
def shapes() -> np.ndarray:
    """A cell and a deformed sphere off the axis, without any symmetry."""
    random = np.random.default_rng(3)
    low = np.arange(TRAIN.degree**2) < 16
    round_ = resting_shapes(TRAIN.changed(reference="sphere"), 2)[1]
    shapes = np.stack([resting_shapes(TRAIN, 2)[0], round_])
    shapes += 0.04 * low * random.normal(size=shapes.shape)
    shapes[:, :2, 0] += 0.5 * random.normal(size=(2, 2))
    return shapes


@eqx.filter_jit
def flow_of_motions(operator: CellsOperator, shapes, motions):
    """K u as it is computed, without what is known of it."""
    interior = operator.interior_flow(shapes)
    own = jnp.einsum("cij,cj->ci", interior.near, motions.reshape(len(motions), -1))
    return own.reshape(motions.shape) + operator.outer_motion(shapes)(motions)


@eqx.filter_jit
def flow_at(operator: CellsOperator, points, shapes, motions):
    sources = operator.motion_sources(shapes, motions)
    loose = points[None, :, None]
    return operator.flow.velocity(loose, jnp.array([-1]), sources, background=False)[0, :, 0]


def test_rigid_motion_of_one_cell(operator: CellsOperator, shapes: np.ndarray) -> None:
    interior = eqx.filter_jit(lambda o, s: o.interior_flow(s))(operator, jnp.asarray(shapes))
    for rigid in np.moveaxis(np.asarray(interior.rigid), 1, 0):
        motions = rigid * np.array([1.0, 0.0])[:, None, None]
        found = flow_of_motions(operator, jnp.asarray(shapes), jnp.asarray(motions))
        assert_allclose(found, -0.5 * motions, rtol=0, atol=2e-8)


def test_stresslet_identity(operator: CellsOperator, shapes: np.ndarray) -> None:
    """A constant gives -1 inside, 0 outside: other cell, images, wall and flow rate included."""
    centres = shapes[:, :, 0] / UNIT_DISPLACEMENT
    # Two in the second cell, one in the first, two in the plasma.
    points = np.stack(
        [centres[1], centres[1] + [0.3, 0.2, 0.0], centres[0], [0.0, 0.0, -1.6], [1.0, 1.0, 1.7]]
    )
    for i in range(3):
        motions = np.zeros_like(shapes)
        motions[1, i, 0] = UNIT_DISPLACEMENT
        found = np.asarray(flow_at(operator, *map(jnp.asarray, (points, shapes, motions))))
        expected = -np.eye(3)[i] * np.array([1, 1, 0, 0, 0])[:, None]
        assert_allclose(found, expected, rtol=0, atol=1e-8)


def test_greens_identity_in_the_tube(operator: CellsOperator, shapes: np.ndarray) -> None:
    """v/2 = S t - K v for a Stokes flow v inside one cell, t its traction.

    v = r^2 e_z and p = 4 z, with vorticity and pressure; an ellipsoid askew, off the axis, for
    which v and t n dS/dOmega have degrees 2 and 3.
    """
    grid = operator.source_grid.grid
    turn = np.array([[1.1, 0.2, 0.3], [-0.1, 0.8, 0.2], [0.1, -0.3, 0.9]])
    sphere = resting_shapes(TRAIN.changed(reference="sphere"), 1)[0]
    shapes = np.stack([turn @ sphere, shapes[1]])
    shapes[0, :2, 0] += 0.9
    points = np.einsum("pk,ik->pi", grid.values, shapes[0])
    down, across = np.einsum("dpk,ik->dpi", operator.source_grid.tangents, shapes[0])
    normal = np.cross(down, across)
    x, y, z = points.T
    gradient = np.zeros((len(points), 3, 3))
    gradient[:, 2, 0], gradient[:, 2, 1] = 2 * x, 2 * y
    stress = gradient + np.swapaxes(gradient, 1, 2) - 4 * z[:, None, None] * np.eye(3)
    forces, motions = np.zeros_like(shapes), np.zeros_like(shapes)
    traction = np.einsum("pij,pj->pi", stress, normal)
    forces[0] = (grid.projection @ traction).T
    velocity = np.stack([0 * x, 0 * x, x * x + y * y], axis=-1)
    motions[0] = (grid.projection @ velocity).T

    @eqx.filter_jit
    def single_layer(operator, shapes, forces):
        targets = operator.targets(shapes)
        own = operator.own_velocity(targets, shapes, forces)
        owners = jnp.arange(2)
        sources = operator.sources(shapes, forces)
        outer = operator.flow.velocity(targets, owners, sources, background=False)
        return operator.project(own + outer)

    both = map(jnp.asarray, (shapes, forces))
    single = np.asarray(single_layer(operator, *both))
    double = np.asarray(flow_of_motions(operator, jnp.asarray(shapes), jnp.asarray(motions)))
    assert_allclose(single - double, 0.5 * motions, rtol=0, atol=1e-8)
