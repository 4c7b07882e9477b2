"""Programs as users compile them give what the quickly compiled ones of all other tests give."""

import os
import subprocess
import sys
from pathlib import Path

import jax.numpy as jnp
import numpy as np
from numpy.testing import assert_allclose

from celltrain import Train
from celltrain.train import resting_shapes, train_operator

QUICK = "--xla_backend_optimization_level=0"
TRAIN = Train(diameter=6, packing=0.3, cells=2, degree=6)


def rates() -> np.ndarray:
    """Of two cells, disturbed."""
    shapes = resting_shapes(TRAIN, TRAIN.cells)
    shapes[:, :, 1:16] += 0.02 * np.random.default_rng(0).normal(size=(2, 3, 15))
    return np.asarray(train_operator(TRAIN, cells=TRAIN.cells).rates(jnp.asarray(shapes)))


def test_optimised_programs_give_the_same(tmp_path: Path) -> None:
    program = f"""
import os
from tests.test_optimised import np, rates
assert {QUICK!r} not in os.environ["XLA_FLAGS"]
np.save({str(tmp_path / "rates.npy")!r}, rates())
"""
    done = subprocess.run(
        [sys.executable, "-c", program],
        cwd=Path(__file__).parents[1],
        env=os.environ | {"XLA_FLAGS": ""},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert QUICK in os.environ["XLA_FLAGS"]
    expected = np.load(tmp_path / "rates.npy")
    assert np.abs(expected).max() > 0.1
    assert_allclose(rates(), expected, rtol=0, atol=1e-11)
