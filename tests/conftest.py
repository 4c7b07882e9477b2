"""What several tests share. Annotations of arrays are checked while the tests run."""

# ruff: noqa: E402
import gc
import os
import sys
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from hypothesis import settings
from jaxtyping import install_import_hook

# Before anything of the package is imported, and JAX with it. Cases check themselves.
TYPED = (
    "harmonics",
    "membrane",
    "flow",
    "train",
    "meridian",
    "proximity",
    "steady",
    "stability",
    "results",
    "analyses",
    "contract",
    "continuation",
    "diagnostics",
    "evolution",
    "pictures",
    "explore",
)
# Half of the time of the programs is their compilation, and half of that LLVM's search for
# faster ones; that those that users run give the same is a test of its own (`test_train`).
os.environ.setdefault("JAX_DISABLE_MOST_OPTIMIZATIONS", "1")
# Commands in processes of their own then take what tests have compiled (but see `test_programs`).
os.environ.setdefault("CELLTRAIN_KEEP_PROGRAMS", "0")
# As the command line does; what tests compile makes every look for garbage long.
gc.set_threshold(50_000, 20, 50)
# A test fails by what it finds, not by how long that takes on a busy machine.
settings.register_profile("celltrain", deadline=None)
settings.load_profile("celltrain")

install_import_hook([f"celltrain.{name}" for name in TYPED], "checked_types.checked")

from celltrain.harmonics import azimuthal_basis, real_harmonics
from celltrain.parameters import Train
from celltrain.stability import Mode, Stability, TransientMode, stability
from celltrain.steady import Base, Iteration, steady
from celltrain.steady.degree import Convergence


def bullet(degree: int) -> np.ndarray:
    """Coefficients [3, degree^2] of something like a bullet with a hollow rear."""
    cosine, weight = np.polynomial.legendre.leggauss(3 * degree)
    longitudes = 6 * degree
    theta = np.repeat(np.arccos(cosine), longitudes)
    phi = np.tile(2 * np.pi * np.arange(longitudes) / longitudes, cosine.size)
    weights = np.repeat(weight, longitudes) * 2 * np.pi / longitudes
    radius = 1.28 * np.sin(theta) * (1 - 0.12 * np.cos(theta))
    x, y = radius * np.cos(phi), radius * np.sin(phi)
    z = 0.4 * np.cos(theta) + 0.75 * np.cos(theta) ** 2 + 0.25 * np.cos(theta) ** 3 - 0.15
    return np.stack([x, y, z]) * weights @ real_harmonics(degree, theta, phi)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Files with slow tests come first: a long one at the end would keep one process alone busy."""
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: item.path not in slow)


@pytest.fixture(autouse=True, scope="module")
def release_programs() -> Iterator[None]:
    """Compiled programs go with their module: kept all together, they crash the compiler."""
    yield
    # Most modules need no JAX.
    if "jax" in sys.modules:
        sys.modules["jax"].clear_caches()


@pytest.fixture
def make_base() -> Callable[..., Base]:
    """Makes steady trains that nobody computed, of the given leaves of a case."""

    def make(**leaves: object) -> Base:
        train = Train(**{"diameter": 6, "packing": 0.2, "cells": 4, "degree": 6, **leaves})
        history = (
            Iteration("march", 0.31, 0.1 / 3, 1.5),
            Iteration("newton", 1e-3 / 3, float("inf"), 1.77),
        )
        return Base(
            train=train,
            coefficients=bullet(train.degree),
            cell_velocity=1.7720 / 3 * 3,
            gap=0.1 + 0.2,
            largest_radius=1.277,
            effective_viscosity=1.0321,
            residual=3e-8,
            truncation_error=4e-4,
            velocity_error=2e-7,
            history=history,
            origin="made up, to test what is done with it",
            seconds={"compile": 1.25, "base": 0.5},
        )

    return make


@pytest.fixture
def make_stability(make_base: Callable[..., Base]) -> Callable[..., Stability]:
    """Makes linear dynamics that nobody computed; `growth` is that of the tilt m = 1, q = 0."""

    def make(growth: float = 0.0117, error: float = 3e-5, **leaves: object) -> Stability:
        base = make_base(**leaves)
        waves = base.train.cells // 2 + 1
        random = np.random.default_rng(7)
        numbers = (0, 1, 2)
        blocks, eigenvalues, right, left = {}, {}, {}, {}
        modes = []
        for m in numbers:
            size = len(azimuthal_basis(base.train.degree, m))
            shape = (waves, size, size)
            blocks[m] = random.normal(size=shape) + 1j * random.normal(size=shape)
            right[m] = np.exp(-np.arange(size))[:, None] * blocks[m]
            left[m] = blocks[m].conj() / 3
            rates = -(10.0 ** random.uniform(-2, 1, shape[:2]))
            eigenvalues[m] = rates + 0.1j * np.abs(rates) * random.normal(size=shape[:2])
            if m == 0:
                # Signs of zeros must survive, too.
                eigenvalues[m][:, :2] = complex(-0.0, -0.0)
            if m == 1:
                eigenvalues[m][0, 0] = growth
            modes += [
                Mode(
                    growth_rate=float(value.real),
                    frequency=float(abs(value.imag)),
                    azimuthal_number=m,
                    wave_number=wave,
                    neutral=m == 0 and index < 2,
                    multiplicity=(1 + (m > 0)) * (1 + (0 < 2 * wave < base.train.cells)),
                    index=index,
                    neutral_kind=("rotation", "volume")[index] if m == 0 and index < 2 else "",
                )
                for (wave, index), value in np.ndenumerate(eigenvalues[m])
            ]
        modes.sort(key=lambda mode: -mode.growth_rate)
        return Stability(
            base=base,
            azimuthal_numbers=numbers,
            wave_numbers=np.arange(waves),
            blocks=blocks,
            eigenvalues=eigenvalues,
            right_vectors=right,
            left_vectors=left,
            modes=tuple(modes),
            spectral_abscissa=max(mode.growth_rate for mode in modes if not mode.neutral),
            numerical_abscissa=1.954,
            numerical_abscissas={"paper": 1.954, "orthonormal": 1.741, "surface": 1.6},
            error_estimate=error,
            convergence=Convergence(
                base.train.degree, (base.train.degree, 12, 16), (growth, growth + 1e-3, 0.1 + 0.2)
            ),
            transient=TransientMode(1.954, 1, waves - 1, right[1][waves - 1, :, 0]),
            seconds={
                "compile": 1.25,
                "base": 0.5,
                "linearise": 2.0,
                "spectrum": 0.125,
                "total": 3.875,
            },
        )

    return make


@pytest.fixture(scope="session")
def difference_order() -> Callable[..., float]:
    """Order at which central differences of a function approach its derivative by `jax.jvp`.

    Arguments: the function, a point, a direction, and two steps.
    """
    import jax
    import jax.numpy as jnp

    def order(
        function: Callable[..., np.ndarray],
        at: np.ndarray,
        direction: np.ndarray,
        steps: tuple[float, float],
    ) -> float:
        at, direction = jnp.asarray(at), jnp.asarray(direction)
        exact = jax.jit(lambda: jax.jvp(function, (at,), (direction,))[1])()
        errors = [
            jnp.abs(
                (function(at + h * direction) - function(at - h * direction)) / (2 * h) - exact
            ).max()
            for h in steps
        ]
        return float(np.log(errors[0] / errors[1]) / np.log(steps[0] / steps[1]))

    return order


@pytest.fixture(scope="session")
def coarse_base() -> Base:
    """A steady train of three cells, coarse: what is exact must hold for it, too."""
    train = Train(diameter=6, packing=0.3, cells=3, degree=6, tolerance=1e-7)
    return steady(train, estimate_error=False)


@pytest.fixture(scope="session")
def coarse_stability(coarse_base: Base) -> Stability:
    """Its linear dynamics."""
    return stability(coarse_base, estimate_error=False)
