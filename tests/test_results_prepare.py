"""What the first file takes is loaded beforehand, and nothing is heard of it."""

import threading

import pytest
import xarray as xr

from celltrain.results import netcdf, prepare


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
