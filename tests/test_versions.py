"""What is asked of the numerical libraries, since some of their versions do not do it."""

import re
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

import celltrain
import celltrain.runtime

#: JAX 0.10.2 loses terms of sums over more rows than 16384 on CPUs.
ROWS = (16384, 16385, 20000, 40000)


def test_floats_have_64_bits() -> None:
    assert celltrain.__version__
    assert jax.config.jax_enable_x64
    assert jnp.asarray(1.0).dtype == np.float64
    assert jnp.arange(2).dtype == np.int64


def test_that_version_is_not_installed() -> None:
    assert jax.__version__ != "0.10.2"


@pytest.mark.parametrize("lock", ["requirements.lock", "docs/requirements.lock"])
def test_locked_are_versions_and_no_places(lock: str) -> None:
    lines = (Path(__file__).parents[1] / lock).read_text().splitlines()
    wanted = [
        line for line in lines if line and not line.lstrip().startswith(("#", "--only-binary"))
    ]
    assert len(wanted) > 20
    for line in wanted:
        assert re.fullmatch(r"[a-z0-9._-]+==[0-9][0-9a-z.+-]*( ; .*)?", line), line


@pytest.mark.parametrize("rows", ROWS)
def test_long_sums_are_right(rows: int) -> None:
    random = np.random.default_rng(rows)
    matrix, vector = random.normal(size=(rows, 3)), random.normal(size=rows)
    wide = random.normal(size=(4, rows))
    sums = {
        "sum": (lambda a, v, w: jnp.sum(a, axis=0), matrix.sum(axis=0)),
        "sum of products": (lambda a, v, w: jnp.sum(a * v[:, None], axis=0), vector @ matrix),
        "sum of all": (lambda a, v, w: jnp.sum(a * a), np.sum(matrix * matrix)),
        "matrix times matrix": (lambda a, v, w: w @ a, wide @ matrix),
        "transposed": (lambda a, v, w: a.T @ v, matrix.T @ vector),
        "outer sum": (
            lambda a, v, w: jnp.einsum("pi,p,pj->ij", a, v, a),
            (matrix.T * vector) @ matrix,
        ),
        "complex": (lambda a, v, w: jnp.exp(1j * v) @ a, np.exp(1j * vector) @ matrix),
        "maximum": (lambda a, v, w: jnp.max(a, axis=0), matrix.max(axis=0)),
    }
    arrays = jnp.asarray(matrix), jnp.asarray(vector), jnp.asarray(wide)
    for name, (function, expected) in sums.items():
        found = jax.jit(function)(*arrays)
        assert_allclose(found, expected, rtol=0, atol=1e-9, err_msg=name)
    # And in a loop over batches, as derivatives are taken.
    batches = jax.jit(jax.vmap(lambda v, a: v @ a, in_axes=(0, None)))
    assert_allclose(batches(arrays[2], arrays[0]), wide @ matrix, rtol=0, atol=1e-9)
