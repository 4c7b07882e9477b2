"""A study whose client and whose workers are killed: nothing that is finished is lost."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest

from celltrain.contract import load
from celltrain.results import save
from celltrain.steady import Base
from celltrain.study import CaseRecord

pytest.importorskip("distributed")
psutil = pytest.importorskip("psutil")

# Cases that take a while and leave a line when they start. One may end its own process, or, the
# other sign given, take memory without end.
SLOW = """
import os
import signal
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from celltrain.steady import Base
from celltrain.study import Outcome


@dataclass(frozen=True)
class Slow:
    base: Base
    folder: Path
    fatal: float

    @property
    def settings(self):
        return {"kind": "slow"}

    def __call__(self, train, start):
        with open(self.folder / "log", "a") as log:
            log.write(f"{train.tube.diameter:g} {os.getpid()}\\n")
        if train.tube.diameter == self.fatal:
            os.kill(os.getpid(), signal.SIGKILL)
        taken = []
        while train.tube.diameter == -self.fatal:
            taken.append(np.ones(2**24))
            time.sleep(0.1)
        time.sleep(0.7)
        return Outcome(replace(self.base, train=train), {"gap": train.tube.diameter})
"""
CLIENT = """
import sys
from pathlib import Path

if __name__ == "__main__":
    from celltrain.contract import load
    from celltrain.study import local_workers, make_study, run_study, scheduled_workers
    from slow import Slow

    folder = Path(sys.argv[1])
    diameters = [6, 7, 8, 9, 10, 11, 12, 13]
    study = make_study({"case": {"packing": 0.2}, "axes": {"diameter": diameters}})
    slow = Slow(load(folder / "base.nc"), folder, float(sys.argv[2]))
    with scheduled_workers(sys.argv[3]) if sys.argv[3:] else local_workers(2) as workers:
        run_study(study, folder / "cases", slow, workers.executor, workers.slots)
"""


def started(folder: Path) -> list[tuple[str, int]]:
    """Diameter and process of every case that was ever started."""
    log = folder / "log"
    lines = log.read_text().splitlines() if log.exists() else []
    return [(line.split()[0], int(line.split()[1])) for line in lines]


def records(folder: Path) -> dict[float, CaseRecord]:
    """All records of the folder by diameter; each must be whole, with its steady train."""
    found = {}
    for path in (folder / "cases").glob("[!.]*.json"):  # hidden ones are being written
        record = CaseRecord.model_validate_json(path.read_text())
        if record.status == "finished":
            load(path.with_suffix(".nc"))
        found[record.case["tube"]["diameter"]] = record
    return found


def wait_for(condition, process: "subprocess.Popen[bytes]", seconds: float = 300.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert process.poll() is None, "the client ended before its time"
        assert time.monotonic() < end
        time.sleep(0.02)


def gone(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    # One that has ended is still there until its parent asks for it.
    with suppress(psutil.NoSuchProcess):
        return psutil.Process(process).status() == psutil.STATUS_ZOMBIE
    return True


def wait_until_gone(folder: Path, seconds: float = 60.0) -> None:
    """Wait for all processes that ever started a case."""
    workers = {process for _, process in started(folder)}
    end = time.monotonic() + seconds
    while not all(gone(process) for process in workers):
        assert time.monotonic() < end, "workers outlive their client or scheduler"
        time.sleep(0.05)


def prepare(folder: Path, base: Base) -> None:
    (folder / "slow.py").write_text(SLOW)
    (folder / "client.py").write_text(CLIENT)
    (folder / "cases").mkdir()
    save(base, folder / "base.nc")


def python(folder: Path, *words: str, **settings: Any) -> "subprocess.Popen[bytes]":
    # Where the package is found here, it is in other processes.
    paths = os.pathsep.join([str(folder), *filter(None, sys.path)])
    environment = {
        **os.environ,
        "PYTHONPATH": paths,
        "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0",
    }
    return subprocess.Popen([sys.executable, *words], env=environment, **settings)


def client(folder: Path, fatal: float, *address: str, **settings: Any) -> "subprocess.Popen[bytes]":
    return python(folder, str(folder / "client.py"), str(folder), str(fatal), *address, **settings)


@pytest.mark.slow
def test_killed_clients_and_workers_lose_only_what_runs(tmp_path: Path, make_base) -> None:
    prepare(tmp_path, make_base())
    first = client(tmp_path, fatal=0)
    try:
        wait_for(lambda: len(records(tmp_path)) >= 2, first)
    finally:
        first.kill()
        first.wait()
    wait_until_gone(tmp_path)
    kept = records(tmp_path)
    assert 2 <= len(kept) < 8
    assert {record.status for record in kept.values()} == {"finished"}

    # Another client goes on. One case ends every worker that takes it; one worker is killed.
    left = sorted({6.0, 7, 8, 9, 10, 11, 12, 13} - set(kept))
    fatal = left[-1]
    before = started(tmp_path)
    second = client(tmp_path, fatal)
    try:
        wait_for(
            lambda: any(float(d) != fatal for d, _ in started(tmp_path)[len(before) :]), second
        )
        diameter, process = next(
            each for each in started(tmp_path)[len(before) :] if float(each[0]) != fatal
        )
        os.kill(process, signal.SIGKILL)
        assert second.wait(timeout=300) == 0
    finally:
        second.kill()
        second.wait()
    ended = records(tmp_path)
    assert len(ended) == 8
    assert ended[fatal].status == "failed"
    assert "its worker died" in ended[fatal].reason
    assert "KilledWorker" in ended[fatal].reason
    assert {record.status for d, record in ended.items() if d != fatal} == {"finished"}
    # What was finished is as it was, and was not computed again; the killed one was.
    again = [float(each) for each, _ in started(tmp_path)[len(before) :]]
    assert not set(again) & set(kept)
    assert again.count(float(diameter)) == 2
    assert again.count(fatal) == 2
    assert all(again.count(d) == 1 for d in left if d not in (fatal, float(diameter)))


@contextmanager
def cluster(folder: Path) -> Iterator[tuple[str, "subprocess.Popen[bytes]"]]:
    """Address and process of a scheduler with two workers of 1 GiB, all processes of their own."""
    place = folder / "scheduler.json"
    place.unlink(missing_ok=True)
    quiet: dict[str, Any] = {
        "stdout": subprocess.DEVNULL,
        "stderr": subprocess.DEVNULL,
        "cwd": folder,
        "start_new_session": True,
    }
    file = ["--scheduler-file", str(place)]
    scheduler = ["scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard"]
    worker = ["worker", "--nworkers", "2", "--nthreads", "1", "--memory-limit", "1GiB"]
    dask = ["-c", "from dask.cli import run_cli; run_cli()"]
    processes = [
        python(folder, *dask, *words, *file, **quiet)
        for words in (scheduler, [*worker, "--no-dashboard"])
    ]
    try:
        wait_for(lambda: place.exists() and "address" in place.read_text(), processes[0])
        yield json.loads(place.read_text())["address"], processes[0]
    finally:
        for process in reversed(processes):
            process.terminate()
        for process in processes:
            end(process)


def end(process: "subprocess.Popen[bytes]") -> None:
    """Wait for a process that was asked to end; workers without a scheduler may look for it long.

    Those that do are killed with all that they started.
    """
    try:
        process.wait(timeout=20)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


@pytest.mark.slow
def test_a_killed_scheduler_and_memory_running_out_lose_only_what_runs(
    tmp_path: Path, make_base
) -> None:
    prepare(tmp_path, make_base())
    with cluster(tmp_path) as (address, scheduler):
        first = client(tmp_path, 0, address, stderr=subprocess.PIPE)
        try:
            wait_for(lambda: len(records(tmp_path)) >= 2, first)
            scheduler.kill()
            _, complaint = first.communicate(timeout=120)
        finally:
            first.kill()
            first.wait()
    # Or one of them might start a case that it had been given already.
    wait_until_gone(tmp_path)
    assert first.returncode != 0
    assert b"WorkersLost: the scheduler of the workers was lost" in complaint
    kept = records(tmp_path)
    assert 2 <= len(kept) < 8
    assert {record.status for record in kept.values()} == {"finished"}

    # Resumed with other workers, where one case takes more memory than there is.
    left = sorted({6.0, 7, 8, 9, 10, 11, 12, 13} - set(kept))
    before = started(tmp_path)
    with cluster(tmp_path) as (address, _):
        second = client(tmp_path, -left[0], address)
        try:
            assert second.wait(timeout=300) == 0
        finally:
            second.kill()
            second.wait()
    ended = records(tmp_path)
    assert len(ended) == 8
    assert ended[left[0]].status == "failed"
    assert "its worker died" in ended[left[0]].reason
    assert {record.status for d, record in ended.items() if d != left[0]} == {"finished"}
    again = [float(each) for each, _ in started(tmp_path)[len(before) :]]
    assert not set(again) & set(kept)
    assert again.count(left[0]) == 2
    assert all(again.count(d) == 1 for d in left[1:]), str((len(before), started(tmp_path)))
