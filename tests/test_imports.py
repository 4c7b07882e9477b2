"""What axisymmetric trains and studies of them need is loaded without JAX."""

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from celltrain.contract import load
from celltrain.results import save

PACKAGES = (
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
)
# A name is loaded after another, and the first after which there is too much is told.
PROGRAM = """
import sys
from importlib import import_module

later = set(sys.argv[1].split())
for name in sys.argv[2:]:
    package, _, attribute = name.partition(":")
    module = import_module(package)
    if attribute:
        getattr(module, attribute)
    loaded = later & set(sys.modules)
    if loaded:
        sys.exit(f"{name} loads {', '.join(sorted(loaded))}")
"""


def complaint(names: Sequence[str], *, later: str) -> str:
    """Which of the names is the first that loads one of the modules `later`; empty if none does."""
    command = [sys.executable, "-c", PROGRAM, later, *names]
    done = subprocess.run(command, capture_output=True, text=True)
    return done.stderr.strip() or f"ended with {done.returncode}" if done.returncode else ""


def test_no_jax_is_imported() -> None:
    assert not complaint(PACKAGES, later="jax equinox")


def test_commands_do_not_wait_for_what_they_may_not_need() -> None:
    """Files, pictures and optimisation each take a good part of a second to load."""
    commands = [f"celltrain.cli.computations:{name}" for name in ("base", "stability")]
    assert not complaint(commands, later="xarray matplotlib scipy.optimize scipy.interpolate")


def test_files_do_not_wait_for_xarray(make_stability, tmp_path: Path) -> None:
    """It takes most of a second until it has written the first file."""
    result = make_stability()
    old, new = save(result, tmp_path / "old.nc"), tmp_path / "new.nc"
    program = "import sys; sys.modules['xarray'] = sys.modules['pandas'] = None;"
    program += "from celltrain import load, save; save(load(sys.argv[1]), sys.argv[2])"
    subprocess.run([sys.executable, "-c", program, old, new], check=True)
    assert load(new) == result


def test_what_loads_too_much_is_told() -> None:
    said = complaint(("celltrain.membrane", "celltrain.pictures"), later="jax matplotlib")
    assert said == "celltrain.pictures loads matplotlib"


def test_a_process_that_dies_is_no_good_answer(tmp_path: Path, monkeypatch) -> None:
    (tmp_path / "deadly.py").write_text("import os; os.kill(os.getpid(), 9)")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    assert complaint(("deadly",), later="jax") == "ended with -9"
