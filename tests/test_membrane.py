"""The membrane: its energy, the force that is the energy's gradient, and the laws."""

from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from celltrain.harmonics import degrees_and_orders
from celltrain.harmonics.grid import sphere_grid
from celltrain.harmonics.tables import harmonic_tables
from celltrain.laws import ConstitutiveLaw, ElasticBending, NeoHookean, Skalak
from celltrain.membrane import reference_coefficients
from celltrain.membrane.energy import Membrane, make_membrane
from celltrain.membrane.geometry import volume_rule

DEGREE = 8
SHEAR, DILATATION, BENDING = 1.3, 19.0, 0.05
SKALAK = Skalak(SHEAR, DILATATION)
NEO_HOOKEAN = NeoHookean(SHEAR)


def membrane(law: ConstitutiveLaw, shape: str = "biconcave", bending: float = BENDING) -> Membrane:
    reference = reference_coefficients(DEGREE, shape)
    return make_membrane(law, ElasticBending(bending), reference, energy_order=3 * DEGREE)


@pytest.fixture(scope="module")
def cell() -> Membrane:
    return membrane(SKALAK)


@pytest.fixture(scope="module")
def deformed(cell: Membrane) -> np.ndarray:
    """A cell deformed by about a tenth, at low degrees more than at high ones."""
    degree = degrees_and_orders(DEGREE)[0]
    random = np.random.default_rng(0).normal(size=cell.reference_shape.shape)
    return np.asarray(cell.reference_shape) + 0.1 * random / (1 + degree) ** 2


#: About an oblique axis.
ROTATION = Rotation.from_rotvec([0.9, -1.1, 0.6]).as_matrix()


def moved(shape: np.ndarray) -> np.ndarray:
    """Turned and displaced."""
    turned = ROTATION @ shape
    turned[:, 0] += [0.3, -2.0, 5.0]
    return turned


@eqx.filter_jit
def energy(membrane: Membrane, shape: jax.Array) -> jax.Array:
    return membrane.energy(jnp.asarray(shape))


@eqx.filter_jit
def force(membrane: Membrane, shape: jax.Array) -> jax.Array:
    return membrane.force(jnp.asarray(shape))


@pytest.mark.parametrize("law", [SKALAK, NEO_HOOKEAN], ids=["skalak", "neo_hookean"])
@pytest.mark.parametrize("shape", ["biconcave", "sphere"])
def test_nothing_is_stored_and_nothing_pulls_at_rest(law: ConstitutiveLaw, shape: str) -> None:
    resting = membrane(law, shape)
    assert_allclose(energy(resting, resting.reference_shape), 0.0, atol=1e-12)
    assert_allclose(force(resting, resting.reference_shape), 0.0, atol=1e-11)


def test_force_is_the_gradient_of_the_energy(cell: Membrane, deformed: np.ndarray) -> None:
    step = np.random.default_rng(2).normal(size=deformed.shape)
    step /= np.linalg.norm(step)
    exact = -float(np.sum(np.asarray(force(cell, deformed)) * step))
    assert abs(exact) > 0.1

    def error(h: float) -> float:
        ahead, behind = energy(cell, deformed + h * step), energy(cell, deformed - h * step)
        return abs(float(ahead - behind) / (2 * h) - exact)

    assert np.log10(error(1e-2) / error(1e-3)) == pytest.approx(2, abs=0.05)
    assert error(1e-4) < 1e-5 * abs(exact)


def test_derivative_of_the_force(
    cell: Membrane, deformed: np.ndarray, difference_order: Callable[..., float]
) -> None:
    step = np.random.default_rng(3).normal(size=deformed.shape)
    step /= np.linalg.norm(step)
    order = difference_order(lambda each: force(cell, each), deformed, step, (1e-3, 1e-4))
    assert order == pytest.approx(2, abs=0.05)


def test_energy_does_not_see_rigid_motions(cell: Membrane, deformed: np.ndarray) -> None:
    stored = float(energy(cell, deformed))
    assert stored > 0.1
    assert_allclose(energy(cell, moved(deformed)), stored, rtol=1e-12)
    expected = ROTATION @ np.asarray(force(cell, deformed))
    assert_allclose(force(cell, moved(deformed)), expected, rtol=0, atol=1e-11)


@pytest.mark.parametrize("law", [SKALAK, NEO_HOOKEAN], ids=["skalak", "neo_hookean"])
def test_energy_of_a_sphere_does_not_see_its_poles(law: ConstitutiveLaw) -> None:
    # An ellipsoid A n, and A R n: the same deformation with the poles elsewhere.
    ball = membrane(law, "sphere")
    stretch = np.array([[1.2, 0.2, 0.0], [0.1, 0.9, -0.2], [0.0, 0.1, 1.1]])
    # Of the identity the members x, y, z of degree 1.
    members = [3, 1, 2]
    identity = np.asarray(ball.reference_shape)
    swapped = identity.copy()
    swapped[:, members] = identity[:, members] @ ROTATION
    shape, swapped = stretch @ identity, stretch @ swapped
    stored = float(energy(ball, shape))
    assert stored > 0.1
    assert_allclose(energy(ball, swapped), stored, rtol=1e-11)


def test_membrane_pulls_itself_nowhere(cell: Membrane, deformed: np.ndarray) -> None:
    pull = np.asarray(force(cell, deformed))
    size = np.abs(pull).max()
    assert size > 0.1
    assert_allclose(pull[:, 0], 0.0, atol=1e-12 * size)
    # int x x F dOmega, by orthonormality.
    torque = np.cross(deformed, pull, axis=0).sum(axis=1)
    assert_allclose(torque, 0.0, atol=1e-11 * size)


@pytest.mark.parametrize("degree", [7, 8])
def test_volumes_are_exact_whatever_the_shape(degree: int) -> None:
    """As on a grid of twice as many rings, for shapes with as much of each harmonic."""
    shape = jnp.asarray(np.random.default_rng(1).normal(size=(3, degree**2)))
    grid = sphere_grid(1, 3 * degree)
    theta, phi = grid.points()
    tables = harmonic_tables(degree, theta, phi)
    x, along, around = (each @ shape.T for each in (tables.value, tables.d_theta, tables.d_phi))
    element = jnp.sum(x * jnp.cross(along, around), axis=1) / (3.0 * np.sin(theta))
    expected = jnp.sum(grid.weights * element)
    scale = jnp.sum(grid.weights * jnp.abs(element))
    assert_allclose(volume_rule(degree).volume(shape), expected, rtol=0, atol=1e-13 * scale)


def test_volume_and_its_gradient(cell: Membrane, deformed: np.ndarray) -> None:
    ball = membrane(SKALAK, "sphere")
    assert_allclose(ball.volume(ball.reference_shape), 4 * np.pi / 3, rtol=1e-13)
    # int 2 pi rho 2 z drho of the disc's profile; close to that of the sphere.
    disc = 2 * np.pi * 1.38581894**3 * (0.207 / 3 + 2.003 * 2 / 15 - 1.123 * 8 / 105)
    assert_allclose(cell.volume(cell.reference_shape), disc, rtol=1e-12)
    assert_allclose(disc, 4 * np.pi / 3, rtol=1e-4)
    held = cell.volume(jnp.asarray(deformed))
    assert_allclose(cell.volume(jnp.asarray(moved(deformed))), held, rtol=1e-12)
    # Of the unit sphere it is the normal, which is the position.
    normal = ball.volume_gradient(ball.reference_shape)
    assert_allclose(normal, ball.reference_shape, rtol=0, atol=1e-12)
    step = 1e-6 * np.random.default_rng(4).normal(size=deformed.shape)
    change = cell.volume(jnp.asarray(deformed + step)) - cell.volume(jnp.asarray(deformed - step))
    expected = 2 * np.sum(np.asarray(cell.volume_gradient(jnp.asarray(deformed))) * step)
    assert_allclose(change, expected, rtol=1e-6)


def test_laws_shear_alike_at_small_strain() -> None:
    # Stretch 1 + e along, 1/(1 + e) across: W = Es e^2 + O(e^3), whatever the dilatation.
    strain = np.array([1e-3, 1e-2])
    stretch = 1 + strain
    first, second = stretch**2 + stretch**-2 - 2, 0 * strain
    for law in (SKALAK, NEO_HOOKEAN):
        stored = law.energy_density(first, second)
        assert (np.abs(stored / (SHEAR * strain**2) - 1) < 5 * strain).all()


def test_neo_hookean_dilates_three_times_as_hard_as_it_shears() -> None:
    # Stretch 1 + e all around: W = 3 Es e^2, against Es e^2 in shear.
    first = (1 + 1e-4) ** 2
    stored = NEO_HOOKEAN.energy_density(2 * first - 2, first**2 - 1)
    assert_allclose(stored, 3 * SHEAR * 1e-8, rtol=1e-2)


@pytest.mark.parametrize("stretches", [(0.5, 0.8), (0.7, 1.6), (1.0, 2.0), (1.5, 1.9)])
def test_neo_hookean_tensions_are_those_of_an_incompressible_sheet(
    stretches: tuple[float, float],
) -> None:
    # A sheet of thickness h and shear modulus G = Es/(2 h) with stretch l3 = 1/(l1 l2) across and
    # the pressure that makes that side free: T1 = G h l3 (l1^2 - l3^2), at any strain.
    first, second = stretches
    across = 1.0 / (first * second)

    def stored(along: jax.Array) -> jax.Array:
        return NEO_HOOKEAN.energy_density(along**2 + second**2 - 2, (along * second) ** 2 - 1)

    tension = jax.grad(stored)(first) / second
    assert_allclose(tension, SHEAR / 2 * across * (first**2 - across**2), rtol=1e-13)


@pytest.mark.parametrize("law", [SKALAK, NEO_HOOKEAN], ids=["skalak", "neo_hookean"])
@pytest.mark.parametrize("stretch", [0.9, 1.2])
def test_tension_of_a_dilated_sphere(law: ConstitutiveLaw, stretch: float) -> None:
    # By the strong form: a tension T pulls inward with 2 T/s on the area s^2 per solid angle, and
    # bending stores Eb (1/s - 1)^2 per solid angle.
    ball = membrane(law, "sphere")
    if isinstance(law, Skalak):
        # T_1 = (1/stretch_2) dW/dstretch_1, at equal stretches.
        tension = SHEAR / 2 * (stretch**2 - 1) + DILATATION / 2 * stretch**2 * (stretch**4 - 1)
    else:
        tension = SHEAR / 2 * (1 - stretch**-6)
    bending = 2 * BENDING * (1 / stretch - 1) / stretch**2
    radial = -2 * tension * stretch + bending
    expected = radial * np.asarray(ball.reference_shape)
    found = force(ball, stretch * ball.reference_shape)
    assert_allclose(found, expected, rtol=0, atol=1e-10)


def test_reference_shape_is_the_discs() -> None:
    grid = sphere_grid(DEGREE, 12)
    theta, phi = grid.points()
    x, y, z = reference_coefficients(DEGREE, "biconcave") @ np.asarray(grid.values).T
    radius, square = 1.38581894, np.sin(theta) ** 2
    height = radius / 2 * (0.207 + 2.003 * square - 1.123 * square**2) * np.cos(theta)
    assert_allclose(x, radius * np.sin(theta) * np.cos(phi), rtol=0, atol=1e-12)
    assert_allclose(y, radius * np.sin(theta) * np.sin(phi), rtol=0, atol=1e-12)
    assert_allclose(z, height, rtol=0, atol=1e-12)
