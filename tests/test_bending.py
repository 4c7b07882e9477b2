"""The bending energy of a fluid membrane beside the elastic one."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from celltrain import CaseError, Train
from celltrain.harmonics import degrees_and_orders
from celltrain.laws import ElasticBending, HelfrichBending, Skalak
from celltrain.membrane import reference_coefficients
from celltrain.membrane.energy import Membrane, make_membrane
from celltrain.train import train_membrane

DEGREE, MODULUS = 8, 0.05
NO_TENSION = Skalak(0.0, 0.0)


def fluid(preferred: float = 0.0, shape: str = "sphere") -> Membrane:
    """A membrane that only bends."""
    bending = HelfrichBending(MODULUS, preferred)
    reference = reference_coefficients(DEGREE, shape)
    return make_membrane(NO_TENSION, bending, reference, energy_order=3 * DEGREE)


@eqx.filter_jit
def energy_and_force(membrane: Membrane, shape: jax.Array) -> tuple[jax.Array, jax.Array]:
    return membrane.energy(shape), membrane.force(shape)


@pytest.mark.parametrize("radius", [0.7, 1.0, 2.5])
def test_every_sphere_stores_the_same(radius: float) -> None:
    ball = fluid()
    stored, pull = energy_and_force(ball, radius * ball.reference_shape)
    assert_allclose(stored, 8 * np.pi * MODULUS, rtol=1e-12)
    assert_allclose(pull, 0.0, atol=1e-12)


@pytest.mark.parametrize("radius", [0.7, 1.0, 2.5])
def test_a_sphere_with_a_preferred_curvature(radius: float) -> None:
    # Eb/2 (2/R - c0)^2 4 pi R^2; the force per solid angle is -dE/dR / (4 pi), outward.
    preferred = 1.3
    ball = fluid(preferred)
    stored, pull = energy_and_force(ball, radius * ball.reference_shape)
    assert_allclose(stored, 2 * np.pi * MODULUS * (2 - preferred * radius) ** 2, rtol=1e-12)
    outward = MODULUS * preferred * (2 - preferred * radius)
    assert_allclose(pull, outward * np.asarray(ball.reference_shape), rtol=0, atol=1e-12)


def test_its_force_is_the_slope_and_moves_nothing() -> None:
    cell = fluid(0.4, "biconcave")
    random = np.random.default_rng(0).normal(size=cell.reference_shape.shape)
    degree = degrees_and_orders(DEGREE)[0]
    shape = np.asarray(cell.reference_shape) + 0.1 * random / (1 + degree) ** 2
    stored, pull = (np.asarray(each) for each in energy_and_force(cell, jnp.asarray(shape)))
    step = 1e-6 * np.random.default_rng(1).normal(size=shape.shape)
    above, _ = energy_and_force(cell, jnp.asarray(shape + step))
    below, _ = energy_and_force(cell, jnp.asarray(shape - step))
    assert_allclose(above - below, -2 * np.sum(pull * step), rtol=1e-6)
    turned = Rotation.from_rotvec([0.9, -1.1, 0.6]).as_matrix() @ shape
    assert_allclose(energy_and_force(cell, jnp.asarray(turned))[0], stored, rtol=1e-12)
    size = np.abs(pull).max()
    assert_allclose(pull[:, 0], 0.0, atol=1e-12 * size)
    assert_allclose(np.cross(shape, pull, axis=0).sum(axis=1), 0.0, atol=1e-11 * size)


def test_it_is_elastic_bending_about_a_flat_rest() -> None:
    # Eb/2 ((2H)^2 - tr(kappa^2)) = Eb K, and the integral of K is 4 pi; areas are those at rest.
    cell = fluid(0.0, "biconcave")
    flat = tuple(jnp.zeros_like(each) for each in cell.reference.curvature)
    elastic = eqx.tree_at(
        lambda each: (each.bending, each.reference.curvature),
        cell,
        (ElasticBending(jnp.asarray(MODULUS)), flat),
    )
    helfrich, _ = energy_and_force(cell, cell.reference_shape)
    about_flat, _ = energy_and_force(elastic, cell.reference_shape)
    assert_allclose(helfrich - about_flat, 4 * np.pi * MODULUS, rtol=1e-5)


def test_a_case_chooses_its_bending() -> None:
    case = {"diameter": 8, "packing": 0.2, "degree": 6, "bending": "helfrich"}
    bending = train_membrane(Train(**case, spontaneous_curvature=0.5)).bending
    assert isinstance(bending, HelfrichBending)
    assert float(bending.spontaneous_curvature) == 0.5
    usual = Train(diameter=8, packing=0.2, degree=6)
    assert isinstance(train_membrane(usual).bending, ElasticBending)
    with pytest.raises(CaseError, match=r"spontaneous_curvature = 0.5 .* bending = 'helfrich'"):
        usual.changed(spontaneous_curvature=0.5)
    si = Train.from_si(diameter=20e-6, packing=0.2, bending="helfrich", spontaneous_curvature=1e5)
    assert si.cell.spontaneous_curvature == pytest.approx(1e5 * 2.8e-6)
