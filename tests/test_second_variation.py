"""The energy's second variation beside differences of the energy of any shape."""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import scipy.linalg
from numpy.testing import assert_allclose

from celltrain import Base
from celltrain.harmonics import azimuthal_basis, coefficients_of
from celltrain.membrane import meridian_membrane
from celltrain.stability import second_variation
from celltrain.stability.strain_norm import rigid_motions
from celltrain.train import train_membrane


def test_second_variation_is_that_of_the_energy(coarse_base: Base) -> None:
    membrane = meridian_membrane(coarse_base.train)
    random = np.random.default_rng(3)
    rest = coefficients_of(membrane.rest_profile)
    energy = eqx.filter_jit(train_membrane(coarse_base.train).energy)
    for m in (0, 1, 3):
        basis = azimuthal_basis(6, m)
        amounts = random.normal(size=len(basis)) / np.arange(1, len(basis) + 1) ** 2
        direction = np.einsum("u,uik->ik", amounts, basis)
        for shape in (rest, coarse_base.coefficients):
            gram = second_variation(membrane, shape, [0, 1, 3])[m]
            step = 1e-3
            energies = [
                float(energy(jnp.asarray(shape + e * step * direction))) for e in (-1, 0, 1)
            ]
            expected = (energies[0] - 2.0 * energies[1] + energies[2]) / step**2
            assert_allclose(amounts @ gram @ amounts, expected, rtol=2e-4)
        at_rest = second_variation(membrane, rest, [m])[m]
        lowest = scipy.linalg.eigvalsh(at_rest)
        assert lowest[0] > -1e-10 * lowest[-1]
        assert_allclose(at_rest @ rigid_motions(rest, m), 0.0, atol=1e-9)
