"""The fields of the free-space kernels, against plain formulas."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain.meridian.kernels import (
    EVEN,
    ODD,
    STRESS_EVEN,
    STRESS_ODD,
    force_fields,
    stress_fields,
)

RANDOM = np.random.default_rng(3)
TARGETS, SOURCES = 3, 5
RHO, Z = np.abs(RANDOM.normal(size=TARGETS)), RANDOM.normal(size=TARGETS)
POINTS = RANDOM.normal(size=(3, TARGETS, SOURCES)) + 2.0
CONTENT = RANDOM.normal(size=(3, TARGETS, SOURCES))
WEIGHTS = RANDOM.uniform(0.5, 1.5, SOURCES)
AXES = {"x": 0, "y": 1, "z": 2}

Fields = dict[str, np.ndarray]


def fields(
    kernel: Callable[..., None],
    names: tuple[tuple[str, ...], tuple[str, ...]],
    points: np.ndarray,
    content: np.ndarray,
) -> Fields:
    even, odd = (np.empty((len(each), TARGETS, SOURCES)) for each in names)
    kernel(RHO, Z, points, content, WEIGHTS, even, odd)
    return dict(zip((*names[0], *names[1]), (*even, *odd), strict=True))


def stokeslet(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    d = x - y
    r = np.sqrt(d @ d)
    return np.eye(3) / r + np.outer(d, d) / r**3


def expected(t: int, s: int) -> Fields:
    """By the definitions; derivatives by complex steps."""
    x, y, content = np.array([RHO[t], 0.0, Z[t]]), POINTS[:, t, s], CONTENT[:, t, s]
    h = 1e-30
    slopes = np.stack(
        [(stokeslet(x + 1j * h * axis, y) @ content).imag / h for axis in np.eye(3)], axis=1
    )
    r = y - x
    stress = -6 * np.outer(r, r) * (r @ content) / np.linalg.norm(r) ** 5
    return {"G": stokeslet(x, y), "T": slopes, "K": stress}


@pytest.mark.parametrize(
    ("kernel", "names"),
    [(force_fields, (EVEN, ODD)), (stress_fields, (STRESS_EVEN, STRESS_ODD))],
)
def test_fields_by_their_definition(
    kernel: Callable[..., None], names: tuple[tuple[str, ...], tuple[str, ...]]
) -> None:
    found = fields(kernel, names, POINTS, CONTENT)
    for t in range(TARGETS):
        for s in range(SOURCES):
            tensors = expected(t, s)
            for name, values in found.items():
                value = tensors[name[0]][AXES[name[1]], AXES[name[2]]]
                assert_allclose(values[t, s], WEIGHTS[s] * value, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize(
    ("kernel", "names"),
    [(force_fields, (EVEN, ODD)), (stress_fields, (STRESS_EVEN, STRESS_ODD))],
)
def test_parity_in_the_longitude(
    kernel: Callable[..., None], names: tuple[tuple[str, ...], tuple[str, ...]]
) -> None:
    mirror = np.array([1.0, -1.0, 1.0])[:, None, None]
    here = fields(kernel, names, POINTS, CONTENT)
    there = fields(kernel, names, mirror * POINTS, mirror * CONTENT)
    for sign, group in zip((1.0, -1.0), names, strict=True):
        for name in group:
            assert_allclose(there[name], sign * here[name], rtol=1e-13)
    # These are all components there are.
    letters = {name[0] for name in here}
    assert len(here) == {1: 6, 2: 15}[len(letters)]
