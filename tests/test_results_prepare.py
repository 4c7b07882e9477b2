"""What the first file takes is loaded beforehand, and nothing is heard of it."""

import threading
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from celltrain import Train
from celltrain.evolution import RandomDisplacement, evolve, simulate
from celltrain.results import netcdf, prepare

TRAIN = Train(diameter=6, packing=0.2, cells=2, degree=8)


def test_a_file_is_written_by_another_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    content, done = netcdf.content_of, threading.Event()
    seen: list[tuple[bytes, threading.Thread]] = []

    def noted(data: xr.Dataset) -> memoryview:
        found = content(data)
        seen.append((bytes(found), threading.current_thread()))
        done.set()
        return found

    monkeypatch.setattr(netcdf, "content_of", noted)
    prepare()
    assert done.wait(30.0)
    ((found, thread),) = seen
    assert found[1:4] == b"HDF"
    assert thread is not threading.current_thread()
    assert thread.daemon


def test_whatever_is_wrong_is_left_to_who_writes_a_file(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    begun = threading.Event()

    def fail(data: xr.Dataset) -> memoryview:
        begun.set()
        raise OSError("no space left")

    monkeypatch.setattr(netcdf, "content_of", fail)
    before = set(threading.enumerate())
    prepare()
    assert begun.wait(30.0)
    for each in set(threading.enumerate()) - before:
        each.join(30.0)
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("file", ["run.nc", None])
def test_a_simulation_with_a_file_begins_with_it(
    file: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class NowError(Exception):
        """When shapes are settled."""

    def settle(_: np.ndarray) -> None:
        raise NowError

    asked: list[str] = []
    monkeypatch.setattr(simulate, "prepare", lambda: asked.append("prepare"))
    monkeypatch.setattr(simulate, "_check_steady", lambda *_: None)
    made = SimpleNamespace(settle=settle)
    monkeypatch.setattr(simulate, "train_dynamics", lambda *_, **__: made)
    path = None if file is None else tmp_path / file
    with pytest.raises(NowError):
        evolve(TRAIN, RandomDisplacement(amplitude=0.1), until=1.0, path=path)
    assert asked == ([] if file is None else ["prepare"])
