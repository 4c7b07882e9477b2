"""The membrane of an axisymmetric cell beside that of any cell, and the jets below it."""

import subprocess
import sys

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain.harmonics import (
    Profile,
    azimuthal_basis,
    coefficients_of,
    profile_of,
)
from celltrain.laws import (
    BendingLaw,
    ConstitutiveLaw,
    ElasticBending,
    HelfrichBending,
    NeoHookean,
    Skalak,
)
from celltrain.membrane import AxisymmetricMembrane, axisymmetric_membrane, reference_coefficients
from celltrain.membrane.energy import Membrane, make_membrane
from celltrain.membrane.jets import Jet, variables

DEGREE = 8
ORDER = 3 * DEGREE
NUMBERS = (0, 1, 2, 3, DEGREE - 1)
REST = profile_of(reference_coefficients(DEGREE, "biconcave"))
MATERIALS = [
    (Skalak(1.3, 19.0), ElasticBending(0.05)),
    (NeoHookean(1.3), ElasticBending(0.05)),
    (Skalak(1.3, 19.0), HelfrichBending(0.05, 0.4)),
]


def deformed() -> Profile:
    """A profile without a mirror plane, deformed by about a tenth."""
    random = np.random.default_rng(0).normal(size=(2, DEGREE))
    profile = REST + 0.1 * random / (1 + np.arange(DEGREE)) ** 2
    profile[1, 0] = 0.0
    return profile


def along(profile: Profile, amounts: np.ndarray) -> Profile:
    """The profile moved by amounts of the members of m = 0 without swirl."""
    return profile + np.stack([amounts[:DEGREE], np.append(0.0, amounts[DEGREE:])])


@pytest.fixture(scope="module")
def cell() -> AxisymmetricMembrane:
    return axisymmetric_membrane(*MATERIALS[0], REST, energy_order=ORDER)


@eqx.filter_jit
def derivatives(membrane: Membrane, shape: jax.Array, directions: jax.Array) -> tuple:
    def change(direction: jax.Array) -> jax.Array:
        return jax.jvp(jax.grad(membrane.energy), (shape,), (direction,))[1]

    return membrane.energy(shape), membrane.force(shape), jax.lax.map(change, directions)


@pytest.mark.parametrize(("law", "bending"), MATERIALS)
def test_agrees_with_the_membrane_of_any_shape(law: ConstitutiveLaw, bending: BendingLaw) -> None:
    profile = deformed()
    cell = axisymmetric_membrane(law, bending, REST, energy_order=ORDER)
    any_shape = make_membrane(law, bending, coefficients_of(REST), energy_order=ORDER)
    shape = jnp.asarray(coefficients_of(profile))
    bases = [azimuthal_basis(DEGREE, m) for m in NUMBERS]
    energy, force, changes = derivatives(any_shape, shape, jnp.concatenate(bases))
    assert cell.energy(profile) == pytest.approx(float(energy), rel=1e-12)
    pointwise = cell.second_order(profile)
    assert_allclose(coefficients_of(cell.force(pointwise)), force, rtol=0, atol=1e-11)
    start = 0
    for m, basis in zip(NUMBERS, bases, strict=True):
        part = np.asarray(changes[start : start + len(basis)])
        expected = np.einsum("uik,vik->uv", basis, part)
        assert_allclose(cell.hessian(pointwise, m), expected, rtol=0, atol=1e-11)
        start += len(basis)


def test_volume_agrees_with_that_of_any_shape(cell: AxisymmetricMembrane) -> None:
    profile = deformed()
    any_shape = make_membrane(*MATERIALS[0], coefficients_of(REST), energy_order=ORDER)
    shape = jnp.asarray(coefficients_of(profile))
    assert cell.volume(profile) == pytest.approx(float(any_shape.volume(shape)), rel=1e-13)
    gradient = np.asarray(any_shape.volume_gradient(shape))
    expected = np.einsum("uik,ik->u", azimuthal_basis(DEGREE, 0), gradient)
    assert_allclose(cell.volume_gradient(profile), expected, rtol=0, atol=1e-12)

    @jax.jit
    def changes(directions: jax.Array) -> jax.Array:
        return jax.vmap(lambda d: jax.jvp(any_shape.volume_gradient, (shape,), (d,))[1])(directions)

    for m in NUMBERS:
        basis = azimuthal_basis(DEGREE, m)
        expected = np.einsum("uik,vik->uv", basis, changes(jnp.asarray(basis)))
        assert_allclose(cell.volume_hessian(profile, m), expected, rtol=0, atol=1e-11)


def test_force_and_hessian_are_derivatives(cell: AxisymmetricMembrane) -> None:
    profile = deformed()
    amounts = 1e-5 * np.random.default_rng(1).normal(size=2 * DEGREE - 1)
    pointwise = cell.second_order(profile)
    ahead, behind = along(profile, amounts), along(profile, -amounts)
    force = cell.force(pointwise)
    work = force[0] @ amounts[:DEGREE] + force[1, 1:] @ amounts[DEGREE:]
    assert cell.energy(ahead) - cell.energy(behind) == pytest.approx(-2 * work, rel=1e-6)
    change = cell.force(cell.second_order(ahead)) - cell.force(cell.second_order(behind))
    stiffness = cell.hessian(pointwise, 0)[: 2 * DEGREE - 1, : 2 * DEGREE - 1]
    expected = -2 * stiffness @ amounts
    found = np.concatenate([change[0], change[1, 1:]])
    assert_allclose(found, expected, rtol=0, atol=1e-6 * np.abs(expected).max())


def test_derivatives_of_the_area(cell: AxisymmetricMembrane) -> None:
    ball = profile_of(reference_coefficients(DEGREE, "sphere"))
    assert cell.area(1.2 * ball) == pytest.approx(4 * np.pi * 1.44, rel=1e-13)
    profile, swirl = deformed(), np.zeros(DEGREE - 1)
    amounts = 1e-5 * np.random.default_rng(2).normal(size=2 * DEGREE - 1)
    gradient, hessian = cell.area_derivatives(profile)
    ahead, behind = along(profile, amounts), along(profile, -amounts)
    moved = np.concatenate([amounts, swirl])
    assert cell.area(ahead) - cell.area(behind) == pytest.approx(2 * gradient @ moved, rel=1e-6)
    change = cell.area_derivatives(ahead)[0] - cell.area_derivatives(behind)[0]
    assert_allclose(change, 2 * hessian @ moved, rtol=0, atol=1e-9)


def test_rigid_motions_of_a_cell_at_rest_cost_nothing(cell: AxisymmetricMembrane) -> None:
    pointwise = cell.second_order(REST)
    assert_allclose(cell.force(pointwise), 0.0, atol=1e-11)
    shape = coefficients_of(REST)
    x, y, z = shape
    none = np.zeros_like(x)
    shift = np.zeros((2, *shape.shape))
    shift[0, 2, 0] = shift[1, 0, 0] = 1.0
    motions = {
        0: [shift[0], np.stack([-y, x, none])],
        1: [shift[1], np.stack([z, none, -x])],
    }
    for m, fields in motions.items():
        basis = azimuthal_basis(DEGREE, m)
        stiffness = cell.hessian(pointwise, m)
        for field in fields:
            amounts = np.einsum("uik,ik->u", basis, field)
            assert np.linalg.norm(amounts) == pytest.approx(np.linalg.norm(field), rel=1e-12)
            assert_allclose(stiffness @ amounts, 0.0, atol=1e-10)


def test_jets_follow_the_rules_of_differentiation() -> None:
    points = np.random.default_rng(3).uniform(0.5, 1.5, size=(3, 5))
    factor = np.linspace(1.0, 2.0, 5)

    def formula(x: object, y: object, z: object) -> object:
        ratio = (2.0 - x) / y + 1.0 / (x + z) - y * factor
        return factor * (ratio**2 - 3.0) * (x * y) ** 0.5 / 4.0 - (-z) ** 3 / factor + z**1

    jet = formula(*variables(points))
    assert isinstance(jet, Jet)
    assert_allclose(jet.value, formula(*points), rtol=1e-14)
    for point in range(5):

        def at(place: jax.Array, point: int = point) -> jax.Array:
            values = [jnp.full(5, each) for each in place]
            return formula(*values)[point]

        place = jnp.asarray(points[:, point])
        assert_allclose(jet.gradient[point], jax.grad(at)(place), rtol=1e-12)
        assert_allclose(jet.hessian[point], jax.hessian(at)(place), rtol=1e-12, atol=1e-13)


def test_other_moduli_compile_nothing_anew() -> None:
    traced = []

    @eqx.filter_jit
    def energy(membrane: Membrane, shape: jax.Array) -> jax.Array:
        traced.append(shape)
        return membrane.energy(shape)

    shape = jnp.asarray(coefficients_of(deformed()))
    stored = []
    for factor in (1.0, 2.0):
        law, bending = Skalak(1.3 * factor, 19.0 * factor), ElasticBending(0.05 * factor)
        membrane = make_membrane(law, bending, coefficients_of(REST), energy_order=ORDER)
        stored.append(float(energy(membrane, shape)))
    assert stored[1] == pytest.approx(2 * stored[0], rel=1e-13)
    assert len(traced) == 1


def test_names_of_the_package_are_loaded_when_asked_for() -> None:
    program = (
        "import celltrain.steady, celltrain.stability, celltrain\n"
        "from celltrain import steady, stability, Run\n"
        "assert callable(steady) and callable(stability) and celltrain.steady is steady\n"
        "assert set(celltrain.__all__) <= set(dir(celltrain))\n"
        "assert all(hasattr(celltrain, name) for name in celltrain.__all__)\n"
        "assert not hasattr(celltrain, 'nothing')"
    )
    subprocess.run([sys.executable, "-c", program], check=True)
