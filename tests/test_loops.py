"""Loops have one machine code, whoever compiles them; what XLA calls has a file for each."""

import os
import subprocess
import sys
from pathlib import Path

from celltrain.compiled.loops import LOOPS

PROGRAM = """
import numpy as np
from celltrain.harmonics import unit_vectors
from celltrain.membrane import reference_coefficients
from celltrain.proximity.nearest import nearest_points

shapes = reference_coefficients(6, "biconcave")[None]
random = np.random.default_rng(1)
guesses = np.arccos(random.uniform(-1, 1, 50)), random.uniform(0, 6, 50)
found = nearest_points(1.5 * unit_vectors(*guesses), np.zeros(50), shapes, np.stack(guesses, -1))

from celltrain.compiled.nearest_loop import _nearest
print(_nearest.cache_hits, *(each.tobytes().hex() for each in found))
"""


def test_one_process_compiles_and_all_have_the_same_code(tmp_path: Path) -> None:
    """To the last bit: also that which compiled it, and that which wanted it at the same time."""
    folders = {"NUMBA_CACHE_DIR": str(tmp_path / "numba"), "XDG_CACHE_HOME": str(tmp_path)}

    def begin() -> subprocess.Popen[str]:
        command = [sys.executable, "-c", PROGRAM]
        return subprocess.Popen(
            command, env=os.environ | folders, stdout=subprocess.PIPE, text=True
        )

    def end(process: subprocess.Popen[str]) -> tuple[int, list[str]]:
        said, _ = process.communicate()
        assert process.returncode == 0
        hits, *found = said.split()
        return int(hits), found

    both = [begin(), begin()]
    (one, found), (other, of_other) = (end(each) for each in both)
    later, of_later = end(begin())
    assert sorted([one, other]) == [0, 1]
    assert later == 1
    assert len(found) == 2
    assert found == of_other == of_later


def test_what_xla_calls_is_kept_in_a_file_for_each_loop(tmp_path: Path) -> None:
    """Numba numbers what is in one file: processes that write at once would mix them up."""
    program = (
        "from celltrain.compiled.loops import LOOPS; [each.declare() for each in LOOPS.values()]"
    )
    folders = {"NUMBA_CACHE_DIR": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path)}
    subprocess.run([sys.executable, "-c", program], env=os.environ | folders, check=True)
    kept = {each.name.split("-")[0] for each in tmp_path.glob("*/shared_work.answer_*.nbi")}
    assert kept == {f"shared_work.answer_{name}" for name in LOOPS}
