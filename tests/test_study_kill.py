"""A study whose client and whose workers are killed: nothing that is finished is lost."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from celltrain.results import load, save
from celltrain.study import Record

pytest.importorskip("distributed")

# Cases that take a while and leave a line when they start; one may end its own process.
SLOW = """
import os
import signal
import time
from dataclasses import dataclass, replace
from pathlib import Path

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
        time.sleep(0.7)
        return Outcome(replace(self.base, train=train), {"gap": train.tube.diameter})
"""
CLIENT = """
import sys
from pathlib import Path

if __name__ == "__main__":
    from celltrain.results import load
    from celltrain.study import local_workers, make_study, run_study
    from slow import Slow

    folder = Path(sys.argv[1])
    diameters = [6, 7, 8, 9, 10, 11, 12, 13]
    study = make_study({"case": {"packing": 0.2}, "axes": {"diameter": diameters}})
    slow = Slow(load(folder / "base.nc"), folder, float(sys.argv[2]))
    with local_workers(2) as workers:
        run_study(study, folder / "cases", slow, workers.executor, workers.slots)
"""


def started(folder: Path) -> list[tuple[str, int]]:
    """Diameter and process of every case that was ever started."""
    log = folder / "log"
    lines = log.read_text().splitlines() if log.exists() else []
    return [(line.split()[0], int(line.split()[1])) for line in lines]


def records(folder: Path) -> dict[float, Record]:
    """All records of the folder by diameter; each must be whole, with its steady train."""
    found = {}
    for path in (folder / "cases").glob("*.json"):
        record = Record.model_validate_json(path.read_text())
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
    return "\nState:\tZ" in Path(f"/proc/{process}/status").read_text()


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc").exists(), reason="asks the system for its processes")
def test_killed_clients_and_workers_lose_only_what_runs(tmp_path: Path, make_base) -> None:
    (tmp_path / "slow.py").write_text(SLOW)
    (tmp_path / "client.py").write_text(CLIENT)
    (tmp_path / "cases").mkdir()
    save(make_base(), tmp_path / "base.nc")

    def client(fatal: float) -> "subprocess.Popen[bytes]":
        return subprocess.Popen(
            [sys.executable, str(tmp_path / "client.py"), str(tmp_path), str(fatal)],
            env={**os.environ, "PYTHONPATH": str(tmp_path)},
        )

    first = client(fatal=0)
    try:
        wait_for(lambda: len(records(tmp_path)) >= 2, first)
    finally:
        first.kill()
        first.wait()
    workers = {process for _, process in started(tmp_path)}
    end = time.monotonic() + 30
    while not all(gone(process) for process in workers):
        assert time.monotonic() < end, "workers outlive their client"
        time.sleep(0.05)
    kept = records(tmp_path)
    assert 2 <= len(kept) < 8
    assert {record.status for record in kept.values()} == {"finished"}

    # Another client goes on. One case ends every worker that takes it; one worker is killed.
    left = sorted({6.0, 7, 8, 9, 10, 11, 12, 13} - set(kept))
    fatal = left[-1]
    before = started(tmp_path)
    second = client(fatal)
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
