"""Measures of single cells and of frames: shapes and motions for which they are known exactly."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation
from scipy.special import ellipeinc, ellipkinc

from celltrain.diagnostics import (
    ENERGY_PARTS,
    FRAME_QUANTITIES,
    CellMoments,
    CellMotion,
    best_ellipsoid,
    cell_moments,
    cell_motion,
    deformation_spectrum,
    disturbance_amplitude,
    energy_parts,
    frame,
    isotropic_tension,
)
from celltrain.harmonics import UNIT_DISPLACEMENT, azimuthal_basis, degrees_and_orders
from celltrain.laws import ConstitutiveLaw, ElasticBending, NeoHookean, Skalak
from celltrain.membrane import place_cells, reference_coefficients
from celltrain.membrane.energy import Membrane, make_membrane
from celltrain.parameters import CaseError, Train
from celltrain.proximity.distances import cell_distance, wall_distance
from celltrain.proximity.walls import RoundWall
from celltrain.stability import PaperNorm

DEGREE = 8
SHEAR, DILATATION, BENDING = 1.3, 19.0, 0.05
SKALAK = Skalak(SHEAR, DILATATION)
NEO_HOOKEAN = NeoHookean(SHEAR)
#: Semi-axes of an ellipsoid, about an oblique axis, somewhere.
AXES = np.array([0.7, 1.1, 1.4])
TURN = Rotation.from_rotvec([0.9, -1.1, 0.6]).as_matrix()
PLACE = np.array([0.3, -2.0, 50.0])


def membrane(law: ConstitutiveLaw = SKALAK, shape: str = "biconcave") -> Membrane:
    reference = reference_coefficients(DEGREE, shape)
    return make_membrane(law, ElasticBending(BENDING), reference, energy_order=3 * DEGREE)


def affine(matrix: np.ndarray, place: np.ndarray, degree: int = DEGREE) -> np.ndarray:
    """Coefficients of x = matrix . r + place, r on the unit sphere."""
    coefficients = np.zeros((3, degree**2))
    # x, y, z of the sphere are the harmonics 3, 1, 2, times sqrt(4 pi/3).
    coefficients[:, [3, 1, 2]] = np.sqrt(4 * np.pi / 3) * matrix
    coefficients[:, 0] = UNIT_DISPLACEMENT * place
    return coefficients


def cross(vector: np.ndarray) -> np.ndarray:
    """The matrix of vector x."""
    x, y, z = vector
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


@pytest.fixture(scope="module")
def cell() -> Membrane:
    return membrane()


@pytest.fixture(scope="module")
def deformed(cell: Membrane) -> np.ndarray:
    """A cell without any symmetry."""
    degree = degrees_and_orders(DEGREE)[0]
    random = np.random.default_rng(0).normal(size=cell.reference_shape.shape)
    return np.asarray(cell.reference_shape) + 0.1 * random / (1 + degree) ** 2


@eqx.filter_jit
def moments(cell: Membrane, shape: jax.Array) -> CellMoments:
    return cell_moments(cell, shape)


@eqx.filter_jit
def motion(cell: Membrane, shape: jax.Array, rates: jax.Array) -> CellMotion:
    return cell_motion(cell, shape, rates)


@eqx.filter_jit
def parts(cell: Membrane, shape: jax.Array) -> tuple[jax.Array, jax.Array]:
    return energy_parts(cell, shape), cell.energy(shape)


def ellipsoid_area(axes: np.ndarray) -> float:
    """Area of an ellipsoid by Legendre's formula."""
    c, b, a = np.sort(axes)
    phi = np.arccos(c / a)
    modulus = a**2 * (b**2 - c**2) / (b**2 * (a**2 - c**2))
    second, first = ellipeinc(phi, modulus), ellipkinc(phi, modulus)
    inner = second * np.sin(phi) ** 2 + first * np.cos(phi) ** 2
    return float(2 * np.pi * (c**2 + a * b / np.sin(phi) * inner))


def test_an_ellipsoid_is_measured_exactly(cell: Membrane) -> None:
    shape = affine(TURN @ np.diag(AXES), PLACE)
    found = moments(cell, jnp.asarray(shape))
    assert_allclose(found.volume, 4 / 3 * np.pi * AXES.prod(), rtol=1e-12)
    assert_allclose(found.area, ellipsoid_area(AXES), rtol=1e-9)
    assert_allclose(found.centroid, PLACE, atol=1e-12)
    ellipsoid = best_ellipsoid(found.solid)
    assert_allclose(ellipsoid.semi_axes, AXES, rtol=1e-12)
    turned = TURN * np.sign(TURN[np.abs(TURN).argmax(axis=0), range(3)])
    assert_allclose(ellipsoid.axes, turned.T, atol=1e-11)
    assert_allclose(np.cos(ellipsoid.inclination), abs(TURN[2, 0]), rtol=1e-12)
    squares = AXES**2
    inertia = found.volume / 5 * TURN @ np.diag(squares.sum() - squares) @ TURN.T
    assert_allclose(found.inertia, inertia, atol=1e-11)


def test_a_cell_at_rest_lies_across_the_tube(cell: Membrane) -> None:
    ellipsoid = best_ellipsoid(moments(cell, cell.reference_shape).solid)
    assert_allclose(ellipsoid.inclination, 0.0, atol=1e-7)
    assert_allclose(ellipsoid.axes[0], [0, 0, 1], atol=1e-7)
    assert ellipsoid.semi_axes[0] < 0.6 * ellipsoid.semi_axes[1]


def test_moments_do_not_depend_on_the_place(cell: Membrane, deformed: np.ndarray) -> None:
    here = moments(cell, jnp.asarray(deformed))
    there = moments(cell, jnp.asarray(deformed + affine(np.zeros((3, 3)), PLACE)))
    assert_allclose(there.centroid - here.centroid, PLACE, atol=1e-12)
    for name in ("volume", "area", "solid", "shell"):
        assert_allclose(getattr(there, name), getattr(here, name), atol=1e-12)


@pytest.mark.parametrize("kind", ["biconcave", "sphere", "without symmetry"])
def test_rigid_motion_is_tumbling_alone(cell: Membrane, deformed: np.ndarray, kind: str) -> None:
    shape = deformed if kind == "without symmetry" else reference_coefficients(DEGREE, kind)
    rate, drift = np.array([0.3, -0.2, 0.5]), np.array([1.5, 0.1, -0.4])
    centre = np.asarray(moments(cell, jnp.asarray(shape)).centroid)
    # Two radii off the axis and turning about the centroid, which moves.
    rates = cross(rate) @ shape + affine(np.zeros((3, 3)), drift - np.cross(rate, centre))
    found = motion(cell, jnp.asarray(shape), jnp.asarray(rates))
    assert_allclose(found.centroid_velocity, drift, atol=1e-12)
    assert_allclose(found.membrane_rotation_rate, rate, atol=1e-11)
    assert_allclose(found.rotation_rate, rate, atol=1e-10)
    assert_allclose(found.tumbling, np.linalg.norm(rate), rtol=1e-10)
    assert_allclose(found.tank_treading, 0.0, atol=1e-10)


def tank_treading(axes: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Omega of Eqs. (20), (21) for x = D r, v = D (rate x r), by a rule of its own."""
    nodes, weights = np.polynomial.legendre.leggauss(120)
    phi = np.arange(240) * np.pi / 120
    cosine, longitude = (each.ravel() for each in np.meshgrid(nodes, phi, indexing="ij"))
    sine = np.sqrt(1 - cosine**2)
    r = np.stack([sine * np.cos(longitude), sine * np.sin(longitude), cosine], axis=-1)
    area = np.linalg.norm(r / axes, axis=-1) * np.repeat(weights, 240)
    position, velocity = r * axes, np.cross(rate, r) * axes
    moment = (np.cross(position, velocity) * area[:, None]).sum(axis=0)
    square = (position**2 * area[:, None]).sum(axis=0)
    return moment / (square.sum() - square)


def test_tank_treading_does_not_turn_the_axes(cell: Membrane) -> None:
    rate = np.array([0.3, -0.2, 0.5])
    shape = affine(TURN @ np.diag(AXES), PLACE)
    rates = affine(TURN @ np.diag(AXES) @ cross(rate), np.zeros(3))
    found = motion(cell, jnp.asarray(shape), jnp.asarray(rates))
    expected = tank_treading(AXES, rate)
    assert_allclose(found.centroid_velocity, 0.0, atol=1e-12)
    assert_allclose(TURN.T @ found.membrane_rotation_rate, expected, rtol=1e-8)
    assert_allclose(found.rotation_rate, 0.0, atol=1e-8)
    assert_allclose(found.tank_treading, np.linalg.norm(expected), rtol=1e-7)
    # Tumbling on top of it adds to both.
    both = rates + cross(rate) @ affine(TURN @ np.diag(AXES), np.zeros(3))
    found = motion(cell, jnp.asarray(shape), jnp.asarray(both))
    assert_allclose(found.rotation_rate, rate, atol=1e-8)
    assert_allclose(found.tank_treading, np.linalg.norm(expected), rtol=1e-7)


@pytest.mark.parametrize("law", [SKALAK, NEO_HOOKEAN], ids=["skalak", "neo_hookean"])
def test_energies_are_none_at_rest_and_add_up(law: ConstitutiveLaw, deformed: np.ndarray) -> None:
    cell = membrane(law)
    none, _ = parts(cell, cell.reference_shape)
    assert_allclose(none, 0.0, atol=1e-12)
    some, whole = parts(cell, jnp.asarray(deformed))
    assert whole > 0.01
    assert_allclose(some.sum(), whole, rtol=1e-12)
    assert some[0] > 0.01
    assert some[2] > 0.01
    assert (some[1] > 0.01) == (law is SKALAK)


def test_each_energy_belongs_to_its_modulus(cell: Membrane, deformed: np.ndarray) -> None:
    before, _ = parts(cell, jnp.asarray(deformed))
    factors = {"shear": 2.0, "dilatation": 3.0, "bending": 5.0}
    changed = eqx.tree_at(
        lambda each: (each.law, each.bending.bending_modulus),
        cell,
        (Skalak(jnp.asarray(2 * SHEAR), jnp.asarray(3 * DILATATION)), jnp.asarray(5 * BENDING)),
    )
    after, _ = parts(changed, jnp.asarray(deformed))
    assert_allclose(after, before * np.array([factors[name] for name in ENERGY_PARTS]), rtol=1e-12)


def test_energies_and_tension_of_an_inflated_sphere() -> None:
    cell = membrane(shape="sphere")
    size = 1.1
    shape = size * cell.reference_shape
    first, second = 2 * size**2 - 2, size**4 - 1
    shear = SHEAR / 8 * (first**2 + 2 * first - 2 * second)
    dilatation, bending = DILATATION / 8 * second**2, BENDING * (1 / size - 1) ** 2
    found, _ = parts(cell, shape)
    assert_allclose(found, 4 * np.pi * np.array([shear, dilatation, bending]), rtol=1e-10)

    # Work of the tension on the growing area: 4 pi dW = tension d(4 pi size^2).
    def density(size: jax.Array) -> jax.Array:
        return SKALAK.energy_density(2 * size**2 - 2, size**4 - 1)

    expected = jax.grad(density)(jnp.asarray(size)) / (2 * size)
    assert_allclose(isotropic_tension(cell, shape), expected, rtol=1e-9)


@pytest.mark.parametrize("law", [SKALAK, NEO_HOOKEAN], ids=["skalak", "neo_hookean"])
def test_tension_does_the_work_of_inflation(law: ConstitutiveLaw, deformed: np.ndarray) -> None:
    cell = eqx.tree_at(lambda each: each.bending.bending_modulus, membrane(law), jnp.zeros(()))
    shape = jnp.asarray(deformed)

    @eqx.filter_jit
    def both(cell: Membrane, shape: jax.Array) -> tuple[jax.Array, jax.Array]:
        power = jax.grad(lambda size: cell.energy(size * shape))(1.0)
        elements = jnp.cross(cell.tables.d_theta @ shape.T, cell.tables.d_phi @ shape.T)
        area = jnp.linalg.norm(elements, axis=1) * cell.inverse_sine * cell.weights
        return power, 2 * jnp.sum(isotropic_tension(cell, shape) * area)

    power, work = both(cell, shape)
    assert abs(power) > 0.1
    assert_allclose(work, power, rtol=1e-12)


def test_spectrum_adds_up_to_the_norm() -> None:
    random = np.random.default_rng(1).normal(size=(3, 3, DEGREE**2))
    spectrum = deformation_spectrum(random)
    assert spectrum.shape == (DEGREE,)
    assert_allclose(3 * spectrum.sum(), disturbance_amplitude(random) ** 2, rtol=1e-12)
    # A displacement by d is d sqrt(2) in the paper's coefficients: P_00^2 = 1/2.
    moved = np.stack([affine(np.zeros((3, 3)), np.array([0.0, 0.0, 0.3]))] * 3)
    assert_allclose(deformation_spectrum(moved), [0.18] + [0] * (DEGREE - 1), atol=1e-12)
    assert_allclose(disturbance_amplitude(moved), 0.3 * np.sqrt(6), rtol=1e-12)


@pytest.mark.parametrize("m", [0, 1, 4])
def test_amplitude_is_the_norm_of_the_numerical_abscissa(m: int) -> None:
    basis = azimuthal_basis(DEGREE, m)
    vector = np.random.default_rng(2).normal(size=len(basis))
    gram = PaperNorm().grams(np.zeros((3, DEGREE**2)), [m])[m]
    found = disturbance_amplitude(np.tensordot(vector, basis, axes=1)[None])
    assert_allclose(found**2, vector @ gram @ vector, rtol=1e-12)


def spheres(centres: list[list[float]], radius: float = 1.0) -> np.ndarray:
    return np.stack([affine(radius * np.eye(3), np.array(centre)) for centre in centres])


def test_distances_of_spheres() -> None:
    # Along no line of the grid; the third is nearest to the image of the first.
    shapes = spheres([[0.3, 0.1, 0.0], [-0.4, 0.7, 2.9], [0.2, -0.5, 6.1]])
    length = 8.4
    found = cell_distance(shapes, length)
    first = np.linalg.norm([0.7, -0.6, -2.9]) - 2
    last = np.linalg.norm([0.1, 0.6, 8.4 - 6.1]) - 2
    assert_allclose(found, [last, first, last], atol=1e-8)
    walls = 3.0 - 1.0 - np.array([np.hypot(0.3, 0.1), np.hypot(0.4, 0.7), np.hypot(0.2, 0.5)])
    assert_allclose(wall_distance(shapes, RoundWall(3.0)), walls, atol=1e-8)
    # Whatever whole lengths of the train a cell has gained.
    shapes[1] += affine(np.zeros((3, 3)), np.array([0.0, 0.0, 5 * length]))
    assert_allclose(cell_distance(shapes, length), found, atol=1e-8)


def test_distance_of_one_cell_from_its_image_and_of_cells_that_cross() -> None:
    assert_allclose(cell_distance(spheres([[0.1, 0.2, 0.0]]), 2.5), [0.5], atol=1e-8)
    crossing = spheres([[0.1, 0.2, 0.0], [0.3, -0.4, 1.2]])
    assert (cell_distance(crossing, 20.0) < 1e-4).all()
    assert wall_distance(crossing, RoundWall(1.3))[1] == pytest.approx(1.3 - 1.5, abs=1e-8)


def test_distance_of_nested_cells_is_that_of_dense_points(cell: Membrane) -> None:
    """Against all points of a fine grid, which can only be farther apart."""
    rest = reference_coefficients(DEGREE, "biconcave")
    tilted = Rotation.from_rotvec([0.4, 0.3, 0.0]).as_matrix() @ rest
    shapes = np.stack([rest, tilted + affine(np.zeros((3, 3)), np.array([0.2, 0.1, 1.6]))])
    found = cell_distance(shapes, 10.0)
    values = np.asarray(cell.tables.value)
    here, there = values @ shapes[0].T, values @ shapes[1].T
    dense = min(float(np.linalg.norm(there - point, axis=1).min()) for point in here)
    assert found[0] == pytest.approx(found[1], abs=1e-9)
    assert dense - 0.05 < found[0] <= dense


@pytest.fixture(scope="module")
def train() -> Train:
    return Train(diameter=6, packing=0.3, cells=4, degree=6)


def test_a_frame_holds_what_is_registered(train: Train) -> None:
    rest = reference_coefficients(6, "biconcave")
    shapes = place_cells(rest, train, 4)
    shapes[1] += 0.05 * np.random.default_rng(3).normal(size=rest.shape) / (1 + np.arange(36))
    rates = np.zeros_like(shapes)
    rates[:, 2, 0] = 1.7 * UNIT_DISPLACEMENT
    found = frame(train, shapes, rates)
    assert list(found) == list(FRAME_QUANTITIES)
    sizes = {"cell": 4, "axis": 3, "principal": 3, "harmonic": 6}
    for name, quantity in FRAME_QUANTITIES.items():
        assert found[name].shape == tuple(sizes[each] for each in quantity.dims), name
        assert np.isfinite(found[name]).all(), name
    assert_allclose(found["centroid_velocity"], [[0, 0, 1.7]] * 4, atol=1e-12)
    assert_allclose(found["tank_treading"], 0.0, atol=1e-12)
    assert_allclose(found["energy_shear"][[0, 2, 3]], 0.0, atol=1e-12)
    assert found["energy_shear"][1] > 0.001
    assert_allclose(found["cell_volume"][0], 4 / 3 * np.pi, rtol=1e-4)
    assert found["shape_spectrum"][0] == 0.0
    assert_allclose(found["centroid"][2], [0, 0, 2 / 0.3], atol=1e-12)
    # Wider by the digits of the radius, which the resting cell has at its rim.
    assert_allclose(found["wall_distance"][0], 3 - 1.38581894, atol=1e-7)


def test_a_frame_that_cannot_be_measured_is_refused(train: Train) -> None:
    shapes = np.zeros((4, 3, 49))
    with pytest.raises(CaseError, match="degree 6"):
        frame(train, shapes, shapes)
    with pytest.raises(CaseError, match="finite"):
        frame(train, np.full((4, 3, 36), np.nan), np.zeros((4, 3, 36)))
