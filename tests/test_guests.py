"""In a process where others use JAX, too: their settings, and ours that they change."""

import os
import subprocess
import sys
from pathlib import Path

import jax
import pytest

from celltrain.environment import UnsuitableSetting
from celltrain.runtime import check_jax
from celltrain.train import train_operator

PROGRAM = """
import os, sys
import jax
sys.stdout.flush()
import celltrain.runtime
import jax.numpy as jnp
jax.jit(lambda x: jnp.sin(x) @ x)(jnp.ones((50, 50))).block_until_ready()
print(jax.config.jax_compilation_cache_dir)
print(jax.config.jax_persistent_cache_min_compile_time_secs)
"""


def run(program: str, **changes: str) -> "subprocess.CompletedProcess[str]":
    """Run a program without what this process has set for JAX."""
    names = ("TF_CPP_MIN_LOG_LEVEL", "JAX_COMPILATION_CACHE_DIR", "XLA_FLAGS")
    clean = {name: value for name, value in os.environ.items() if name not in names}
    return subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        env=clean | changes,
        check=False,
    )


def test_nothing_is_said_when_jax_came_first(tmp_path: Path) -> None:
    for _ in range(2):  # the second time programs would come from the cache
        ended = run(PROGRAM, XDG_CACHE_HOME=str(tmp_path))
        assert ended.returncode == 0
        assert ended.stderr == ""
    assert ended.stdout.split() == ["None", "1.0"]


def test_settings_of_others_are_left_alone(tmp_path: Path) -> None:
    program = "import celltrain\n" + PROGRAM.replace(
        "sys.stdout.flush()",
        f"jax.config.update('jax_compilation_cache_dir', {str(tmp_path)!r})\n"
        "jax.config.update('jax_persistent_cache_min_compile_time_secs', 7.0)",
    )
    ended = run(program)
    assert ended.returncode == 0
    assert ended.stderr == ""
    assert ended.stdout.split() == [str(tmp_path), "7.0"]


@pytest.mark.parametrize(
    ("name", "value", "ours"),
    [("jax_enable_x64", False, True), ("jax_numpy_dtype_promotion", "strict", "standard")],
)
def test_settings_with_which_nothing_can_be_computed(
    name: str, value: object, ours: object, coarse_base
) -> None:
    jax.config.update(name, value)
    try:
        with pytest.raises(UnsuitableSetting, match=f"update\\('{name}', {ours!r}\\)"):
            train_operator(coarse_base.train)
    finally:
        jax.config.update(name, ours)
    check_jax()


def test_a_platform_that_is_not_there(tmp_path: Path) -> None:
    program = f"""
import sys
from celltrain.cli import main
sys.exit(main(["evolve", "--diameter", "6", "--packing", "0.2", "--cells", "1", "--degree", "6",
    "--until", "0.1", "--disturbance", "random", "--quiet", "-o", {str(tmp_path / "run.nc")!r}]))
"""
    ended = run(program, JAX_PLATFORMS="nowhere")
    assert ended.returncode == 2
    [line] = ended.stderr.splitlines()
    assert "JAX_PLATFORMS = 'nowhere' is not allowed here" in line
    assert "allowed: cpu" in line
