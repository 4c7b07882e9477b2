"""Random commands that compute nothing, in this process; `validation/fuzz.py` runs all kinds."""

import importlib.util
import random
import sys
from pathlib import Path

import pytest

from celltrain.cli import main

PLACE = Path(__file__).parents[1] / "validation" / "fuzz.py"


@pytest.mark.parametrize("seed", range(60))
def test_no_command_ends_in_a_traceback(
    seed: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    found = importlib.util.spec_from_file_location("fuzz", PLACE)
    assert found is not None
    assert found.loader is not None
    fuzz = importlib.util.module_from_spec(found)
    monkeypatch.setitem(sys.modules, "fuzz", fuzz)
    found.loader.exec_module(fuzz)
    tried = fuzz.attempt(random.Random(seed), commands=("case", "case", "show", "plot"))
    for name, content in tried.files.items():
        (tmp_path / name).write_bytes(content)
    monkeypatch.chdir(tmp_path)
    status = main(tried.words)
    printed = capsys.readouterr()
    assert fuzz.fault(status, printed.out, printed.err) == "", tried
    assert (status == 0) == bool(printed.out), tried
