"""What axisymmetric trains and studies of them need is loaded without JAX."""

import subprocess
import sys

import pytest


@pytest.mark.parametrize(
    "name",
    [
        "celltrain",
        "celltrain.membrane",
        "celltrain.steady.parameters",
        "celltrain.stability",
        "celltrain.continuation",
        "celltrain.diagnostics",
        "celltrain.results",
        "celltrain.study",
        "celltrain.pictures",
        "celltrain.explore.page",
        "celltrain.evolution",
        "celltrain.explore.app",
        "celltrain.explore.engine",
    ],
)
def test_no_jax_is_imported(name: str) -> None:
    program = f"import sys, {name}; assert not {{'jax', 'equinox'}} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", program], check=True)


@pytest.mark.parametrize("name", ["base", "stability"])
def test_commands_do_not_wait_for_what_they_may_not_need(name: str) -> None:
    """Files, pictures and optimisation each take a good part of a second to load."""
    later = {"xarray", "matplotlib", "scipy.optimize", "scipy.interpolate"}
    program = f"import sys; from celltrain.cli.computations import {name}"
    program += f"; assert not {later!r} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", program], check=True)
