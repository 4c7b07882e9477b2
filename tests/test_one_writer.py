"""One writer for each file and folder: who that is, and what becomes of its lock."""

import json
import platform
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from celltrain.cli import main
from celltrain.parameters import CaseError
from celltrain.results import only_writer

PROGRAM = """
import sys, time
from pathlib import Path
from celltrain.results import only_writer
with only_writer(Path(sys.argv[1])):
    print("locked", flush=True)
    time.sleep(60)
"""


@contextmanager
def another(path: Path) -> Iterator[subprocess.Popen[str]]:
    """Another process that writes a file."""
    words = [sys.executable, "-c", PROGRAM, str(path)]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "locked\n"
        yield process
        process.kill()


@pytest.mark.parametrize("folder", [False, True])
def test_another_process_is_refused_until_the_first_has_ended(folder: bool, tmp_path: Path) -> None:
    path = tmp_path / "out"
    if folder:
        path.mkdir()
    link = tmp_path / "link"
    link.symlink_to(path)
    with another(path) as process:
        for each in (path, link):
            with pytest.raises(CaseError) as refused, only_writer(each):
                pass
            assert f"process {process.pid} on {platform.node()}" in str(refused.value)
        process.send_signal(signal.SIGKILL)
        process.wait()
        assert list(tmp_path.rglob("*.lock"))
        with only_writer(path), only_writer(path):
            pass
        assert not list(tmp_path.rglob("*.lock"))


def test_a_lock_of_another_machine_is_left(tmp_path: Path) -> None:
    lock = tmp_path / ".run.nc.lock"
    lock.write_text(json.dumps({"host": "elsewhere", "process": 17}))
    with (
        pytest.raises(CaseError, match="process 17 on elsewhere") as refused,
        only_writer(tmp_path / "run.nc"),
    ):
        pass
    assert f"remove {str(lock)!r}" in str(refused.value)
    assert json.loads(lock.read_text())["process"] == 17
    lock.write_text("no lock of ours")
    with only_writer(tmp_path / "run.nc"):
        assert json.loads(lock.read_text())["host"] == platform.node()


@pytest.mark.parametrize("name", ["a" * 255, "ä" * 127])
def test_names_may_be_as_long_as_the_system_allows(name: str, tmp_path: Path) -> None:
    with only_writer(tmp_path / name):
        pass


def test_commands_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path, study = tmp_path / "out", tmp_path / "wide.toml"
    path.mkdir()
    study.write_text("[case]\npacking = 0.2\n[axes]\ndiameter = [6, 7]\n")
    run = tmp_path / "run.nc"
    run.write_text("")
    with another(path), another(run):
        for words in (
            ["sweep", str(study), "-o", str(path)],
            ["paper", "fig6", "--quick", "-o", str(path)],
            ["evolve", "--resume", "-o", str(run)],
            ["evolve", "--diameter", "6", "--packing", "0.2", "--until", "1", "-o", str(run)],
        ):
            assert main(words) == 2
            printed = capsys.readouterr()
            assert printed.out == ""
            assert f"on {platform.node()} is writing it" in printed.err
            assert len(printed.err.splitlines()) == 1
