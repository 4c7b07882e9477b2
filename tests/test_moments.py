"""Bending by moments without an energy: both membranes, balances, and trains known to digits."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from celltrain import CaseError, Train, stability, steady
from celltrain.diagnostics import perturbation_energy
from celltrain.diagnostics.energy import energy_parts
from celltrain.harmonics import azimuthal_basis, coefficients_of, profile_of
from celltrain.laws import BalancedMomentBending, ElasticBending, MomentBending, Skalak
from celltrain.membrane import axisymmetric_membrane, reference_coefficients
from celltrain.membrane.density import (
    Forms,
    area_density,
    curvature,
    moment_work,
    rest_geometry,
)
from celltrain.membrane.energy import Membrane, make_membrane
from celltrain.membrane.forms import fundamental_forms
from celltrain.membrane.geometry import surface_forms
from celltrain.membrane.jets import variables
from celltrain.stability import second_variation

DEGREE, MODULUS = 8, 0.05
ORDER = 3 * DEGREE
KINDS = (MomentBending, BalancedMomentBending)
ANY = reference_coefficients(DEGREE, "biconcave")
REST = profile_of(ANY)


def membrane(kind: type[ElasticBending | MomentBending], shear: float = 0.0) -> Membrane:
    law = Skalak(shear, 15.0 * shear)
    return make_membrane(law, kind(MODULUS), ANY, energy_order=ORDER)


def deformed(seed: int = 0) -> np.ndarray:
    """A shape without any symmetry."""
    random = np.random.default_rng(seed).normal(size=ANY.shape)
    degrees = np.sqrt(np.arange(DEGREE**2)).astype(int)
    return np.asarray(ANY + 0.1 * random / (1 + degrees) ** 2)


@eqx.filter_jit
def force_of(cell: Membrane, shape: jax.Array) -> jax.Array:
    return cell.force(shape)


@eqx.filter_jit
def changes_of(cell: Membrane, shape: jax.Array, directions: jax.Array) -> jax.Array:
    return jax.lax.map(lambda d: jax.jvp(cell.force, (shape,), (d,))[1], directions)


def work_of_the_definition(cell: Membrane, shape: np.ndarray, change: np.ndarray) -> float:
    """The integral of M^ab (db_ab - b_a^c x_,c . dx_,b) dA, with matrices at each point."""
    tables, weights = cell.tables, np.asarray(cell.weights * cell.inverse_sine)
    first = [np.asarray(table) for table in (tables.d_theta, tables.d_phi)]

    def geometry(moved: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        a11, a12, a22, c11, c12, c22 = map(np.asarray, surface_forms(tables, jnp.asarray(moved)))
        metric = np.moveaxis(np.array([[a11, a12], [a12, a22]]), -1, 0)
        form = np.moveaxis(np.array([[c11, c12], [c12, c22]]), -1, 0)
        return metric, form / np.sqrt(np.linalg.det(metric))[:, None, None]

    (metric, form), (rest_metric, rest_form) = geometry(shape), geometry(ANY)
    inverse = np.linalg.inv(metric)
    moment = -MODULUS * (inverse @ form - np.linalg.inv(rest_metric) @ rest_form) @ inverse
    step = 1e-4
    form_change = (geometry(shape + step * change)[1] - geometry(shape - step * change)[1]) / (
        2 * step
    )
    x = np.stack([table @ shape.T for table in first], axis=1)
    dx = np.stack([table @ change.T for table in first], axis=1)
    stretching = np.einsum("pac,pci,pbi->pab", form @ inverse, x, dx)
    density = np.einsum("pab,pab->p", moment, form_change - stretching)
    return float(np.sum(density * np.sqrt(np.linalg.det(metric)) * weights))


def test_its_force_does_the_work_of_the_definition() -> None:
    cell, shape = membrane(MomentBending), deformed()
    pull = np.asarray(force_of(cell, jnp.asarray(shape)))
    for seed in (1, 2):
        change = deformed(seed) - ANY
        expected = work_of_the_definition(cell, shape, change)
        assert np.sum(pull * change) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_a_resting_cell_moved_and_turned_is_free_of_force(kind: type[MomentBending]) -> None:
    cell = membrane(kind, shear=1.3)
    turned = Rotation.from_rotvec([0.9, -1.1, 0.6]).as_matrix() @ np.asarray(ANY)
    turned[:, 0] += [1.0, -2.0, 0.5]
    assert_allclose(force_of(cell, jnp.asarray(turned)), 0.0, atol=1e-11)


@pytest.mark.parametrize("kind", KINDS)
def test_the_force_turns_with_the_shape_and_adds_up_to_nothing(kind: type[MomentBending]) -> None:
    cell, shape = membrane(kind), deformed()
    pull = np.asarray(force_of(cell, jnp.asarray(shape)))
    size = np.abs(pull).max()
    turn = Rotation.from_rotvec([0.9, -1.1, 0.6]).as_matrix()
    assert_allclose(force_of(cell, jnp.asarray(turn @ shape)), turn @ pull, atol=1e-11 * size)
    assert_allclose(pull[:, 0], 0.0, atol=1e-12 * size)
    torque = np.abs(np.cross(shape, pull, axis=0).sum(axis=1)).max()
    if kind.BALANCED:
        assert torque < 1e-11 * size
    else:
        # What the balance about the normal would take: the published law does turn the fluid.
        assert torque > 1e-4 * size


@pytest.mark.parametrize("kind", KINDS)
def test_both_membranes_agree(kind: type[MomentBending]) -> None:
    profile = profile_of(coefficients_of(profile_of(deformed())))
    law, bending = Skalak(1.3, 19.0), kind(MODULUS)
    cell = axisymmetric_membrane(law, bending, REST, energy_order=ORDER)
    any_shape = make_membrane(law, bending, coefficients_of(REST), energy_order=ORDER)
    shape = jnp.asarray(coefficients_of(profile))
    pointwise = cell.second_order(profile)
    assert_allclose(
        coefficients_of(cell.force(pointwise)), force_of(any_shape, shape), rtol=0, atol=1e-11
    )
    for m in (0, 1, 2, DEGREE - 1):
        basis = azimuthal_basis(DEGREE, m)
        # The columns of H_m are the changes of the force.
        change = np.asarray(changes_of(any_shape, shape, jnp.asarray(basis)))
        expected = -np.einsum("uik,vik->uv", basis, change)
        assert_allclose(cell.hessian(pointwise, m), expected, rtol=0, atol=1e-11)


def test_the_linear_force_is_that_of_differences() -> None:
    cell = axisymmetric_membrane(
        Skalak(1.3, 19.0), MomentBending(MODULUS), REST, energy_order=ORDER
    )
    profile = profile_of(deformed())
    amounts = 1e-5 * np.random.default_rng(1).normal(size=(2, DEGREE))
    amounts[1, 0] = 0.0
    change = cell.force(cell.second_order(profile + amounts)) - cell.force(
        cell.second_order(profile - amounts)
    )
    size = 2 * DEGREE - 1
    stiffness = cell.hessian(cell.second_order(profile), 0)[:size, :size]
    expected = -2 * stiffness @ np.append(amounts[0], amounts[1, 1:])
    assert_allclose(
        np.append(change[0], change[1, 1:]), expected, atol=1e-6 * np.abs(expected).max()
    )
    # There is no energy: of the balanced law, too, the linear force is not symmetric.
    for kind in KINDS:
        cell = axisymmetric_membrane(Skalak(0.0, 0.0), kind(MODULUS), REST, energy_order=ORDER)
        matrix = cell.hessian(cell.second_order(profile), 1)
        assert np.abs(matrix - matrix.T).max() > 1e-3 * np.abs(matrix).max()


def test_with_all_of_the_metric_it_would_be_the_elastic_law() -> None:
    # Where areas are those at rest: da counts in full in the derivative of the energy, half here.
    components = np.random.default_rng(3).normal(size=(5, 3, 6))
    forms = fundamental_forms(components)
    rest = rest_geometry(fundamental_forms(components + 0.2 * np.roll(components, 1, axis=1)))
    rest = rest._replace(area=area_density(forms))
    jets = Forms(*variables(np.array(forms)))
    energy = ElasticBending(MODULUS).energy_density(curvature(jets), rest.curvature, 1.0)
    work = np.stack(moment_work(BalancedMomentBending(MODULUS), forms, rest).forms, axis=-1)
    assert_allclose(work[:, 3:], energy.gradient[:, 3:], rtol=1e-9)
    # dc at fixed da changes b alone; what a change of a does at fixed b is counted half.
    a11, a12, a22, c11, c12, c22 = forms
    trace = np.stack([a22, -2.0 * a12, a11], axis=-1) / (a11 * a22 - a12**2)[:, None]
    fixed = 0.5 * (work[:, 3:] * np.stack([c11, c12, c22], axis=-1)).sum(1)[:, None] * trace
    assert_allclose(2.0 * (work[:, :3] + fixed), energy.gradient[:, :3] + fixed, rtol=1e-8)


def test_compiled_programs_tell_the_laws_apart() -> None:
    kinds = (ElasticBending, *KINDS)
    structures = [jax.tree.structure(kind(MODULUS)) for kind in kinds]
    assert len(set(structures)) == len(kinds)
    shape = jnp.asarray(deformed())
    forces = [force_of(membrane(kind), shape) for kind in kinds]
    assert float(jnp.abs(forces[1] - forces[2]).max()) > 1e-4
    assert float(jnp.abs(forces[0] - forces[2]).max()) > 1e-2


@pytest.mark.parametrize(
    ("bending", "degree", "velocity", "alpha"),
    [
        # By a code of its own with the solver's law: 1.86100 at degree 16; 0.01597 and 0.01687.
        ("moments", 12, None, 0.01597),
        ("moments", 16, 1.86100, 0.01687),
        ("balanced_moments", 12, None, 0.01641),
    ],
)
def test_a_train_by_moments(
    bending: str, degree: int, velocity: float | None, alpha: float
) -> None:
    train = Train(diameter=8, packing=0.2, cells=1, degree=degree, bending=bending)
    base = steady(train, estimate_error=False)
    result = stability(base, azimuthal_numbers=[1], estimate_error=False)
    if velocity is not None:
        assert base.cell_velocity == pytest.approx(velocity, abs=5e-6)
    assert result.leading.growth_rate == pytest.approx(alpha, abs=5e-6)


def test_what_needs_an_energy_says_that_there_is_none() -> None:
    cell = membrane(MomentBending, shear=1.0)
    with pytest.raises(CaseError, match="moments has no energy"):
        cell.energy(jnp.asarray(ANY))
    shear, dilatation, bending = energy_parts(cell, jnp.asarray(deformed()))
    assert float(shear) > 0.0
    assert float(dilatation) > 0.0
    assert np.isnan(float(bending))
    axisymmetric = axisymmetric_membrane(
        Skalak(1.0, 1.0), MomentBending(MODULUS), REST, energy_order=ORDER
    )
    with pytest.raises(CaseError, match="moments has no energy"):
        axisymmetric.energy(REST)
    with pytest.raises(CaseError, match="moments has no energy"):
        second_variation(axisymmetric, ANY, [1])
    train = Train(diameter=8, packing=0.2, cells=1, degree=6, bending="moments")
    base = steady(train, estimate_error=False)
    with pytest.raises(CaseError, match="'moments' has no energy"):
        perturbation_energy(base, np.ones((1, 3, 36)))
