"""Runs of studies of distributions: what is kept, what goes on, what fails."""

import json
import os
import shutil
import signal
import sqlite3
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from celltrain.cli import in_folder, main
from celltrain.parameters import CaseError
from celltrain.stability import stability
from celltrain.steady import base_sensitivities, steady
from celltrain.study import (
    NoCentralTrain,
    NotKept,
    Sampled,
    SampledStudy,
    Workers,
    make_sampled_study,
    run_sample,
)
from celltrain.study.sampling import engine
from celltrain.study.sampling.draws import COLUMNS, DrawJob, DrawRecord
from celltrain.study.sampling.store import FILE, draw_store

CONTENT = {
    "case": {"diameter": 6, "cells": 1, "degree": 6},
    "distributions": {
        "shear_modulus": {"lognormal": {"relative_deviation": 0.02}},
        "viscosity_ratio": {"uniform": {"from": 0.8, "to": 1.2}},
        "packing": {"normal": {"mean": 0.2, "relative_deviation": 0.02}},
    },
    "sample": {"points": 16, "indices": False},
    "compute": {"azimuthal_numbers": [0, 1]},
}


def sample(points: int = 16, *, indices: bool = False) -> SampledStudy:
    return make_sampled_study({**CONTENT, "sample": {"points": points, "indices": indices}})


def run(study: SampledStudy, folder: Path, executor: Executor | None = None, **options) -> Sampled:
    if executor is not None:
        return run_sample(study, folder, executor, lambda: 1, **options)
    with ThreadPoolExecutor(1) as one:
        return run_sample(study, folder, one, lambda: 1, **options)


def numbers(sampled: Sampled) -> dict:
    """All numbers that do not say how long they took, so that NaN equals NaN."""
    return {
        index: {name: repr(each) for name, each in record.values.items() if "seconds" not in name}
        for index, record in sampled.records.items()
    }


@pytest.fixture(scope="module")
def complete(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Sampled]:
    """A sample that was never interrupted."""
    folder = tmp_path_factory.mktemp("complete")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("celltrain.study.sampling.definition.CHECKED", 1)
        return folder, run(sample(), folder)


@pytest.fixture(autouse=True)
def few_checks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("celltrain.study.sampling.definition.CHECKED", 1)


@pytest.fixture
def begun(complete: tuple[Path, Sampled], tmp_path: Path) -> Path:
    """A folder that has the central train, and no other."""
    for path in complete[0].glob("*.*"):
        if path.name != FILE:
            shutil.copy(path, tmp_path)
    return tmp_path


@pytest.mark.slow
def test_numbers_are_those_of_a_train_from_rest(complete: tuple[Path, Sampled]) -> None:
    study, sampled = sample(), complete[1]
    assert {record.status for record in sampled.records.values()} == {"finished"}
    assert all(set(record.values) == set(COLUMNS) for record in sampled.records.values())
    for point in (3, 11):
        [draw] = study.points[point]
        values = sampled.records[draw.index].values
        known = stability(draw.train, azimuthal_numbers=(0, 1), estimate_error=False)
        assert values["spectral_abscissa"] == pytest.approx(known.spectral_abscissa, abs=1e-7)
        assert values["leading_azimuthal_number"] == known.leading.azimuthal_number
        for name in ("cell_velocity", "gap", "effective_viscosity", "largest_radius"):
            assert values[name] == pytest.approx(getattr(known.base, name), abs=1e-8), name
        assert values["residual"] < 1e-9
    # The error is estimated of some only.
    errors = [sampled.records[0, point].values["error_estimate"] for point in range(16)]
    assert errors[0] > 0.0
    assert all(error != error for error in errors[1:])


def test_outputs_follow_the_derivatives_at_the_means(complete: tuple[Path, Sampled]) -> None:
    """Deviations are small here: what is linear leaves little, and is known otherwise."""
    study, records = sample(), complete[1].records
    base = steady(study.central)
    known = base_sensitivities(base, ["packing", "shear_modulus"])
    changes = np.array(
        [[draw.values[name] - study.central.leaf(name) for name in known] for draw in study.draws]
    )
    second = np.column_stack([changes**2, changes.prod(axis=1)])
    basis = np.column_stack([np.ones(len(changes)), changes, second])
    for name in ("cell_velocity", "effective_viscosity"):
        values = [records[draw.index].values[name] for draw in study.draws]
        _, *slopes = np.linalg.lstsq(basis, values, rcond=None)[0][:3]
        expected = [getattr(each, name) for each in known.values()]
        assert slopes == pytest.approx(expected, rel=2e-3), name


def test_an_interrupted_sample_goes_on_to_the_same_numbers(
    complete: tuple[Path, Sampled], begun: Path
) -> None:
    def stop(progress) -> None:
        if progress.finished == 5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(sample(), begun, progress=stop)
    told = []
    sampled = run(sample(), begun, progress=told.append)
    assert (told[0].finished, told[0].total, len(told)) == (5, 16, 12)
    assert numbers(sampled) == numbers(complete[1])


class Cheap(DrawJob):
    """Takes no time; what it says of a train is its shear modulus."""

    failing: tuple[float, ...] = ()

    def __call__(self, guess: object) -> list[DrawRecord]:
        found = []
        for train in self.trains:
            modulus = train.cell.shear_modulus
            values = {**dict.fromkeys(COLUMNS, 1.0), "spectral_abscissa": modulus}
            record = DrawRecord("finished", "", values)
            if modulus in self.failing:
                record = DrawRecord("failed", "NotConverged: not today", {})
            found.append(record)
        return found


@pytest.fixture
def cheap(monkeypatch: pytest.MonkeyPatch) -> type[Cheap]:
    monkeypatch.setattr(engine, "DrawJob", Cheap)
    monkeypatch.setattr(engine, "_guess", lambda *_: object())
    monkeypatch.setattr(Cheap, "failing", ())
    return Cheap


@pytest.mark.usefixtures("cheap")
def test_a_larger_sample_keeps_what_is_there(begun: Path) -> None:
    few = run(sample(16), begun)
    told: list = []
    many = run(sample(64), begun, progress=told.append)
    assert told[0].finished == 16
    assert {index: many.records[index] for index in few.records} == few.records
    # With indices the first matrix is there already.
    told.clear()
    run(sample(64, indices=True), begun, progress=told.append)
    assert (told[0].finished, told[0].total, told[-1].finished) == (64, 320, 320)
    # Another seed is another sample.
    other = {**CONTENT, "sample": {"points": 16, "indices": False, "seed": 1}}
    told.clear()
    run(make_sampled_study(other), begun, progress=told.append)
    assert told[0].finished == 0


def test_failed_trains_are_kept_and_retried_when_asked(
    cheap: type[Cheap], begun: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    study = sample()
    bad = study.points[4][0].train.cell.shear_modulus
    monkeypatch.setattr(cheap, "failing", (bad,))
    records = run(study, begun).records
    assert [index for index, each in records.items() if each.status == "failed"] == [(0, 4)]
    assert records[0, 4].reason == "NotConverged: not today"
    monkeypatch.setattr(cheap, "failing", ())
    assert run(study, begun).records[0, 4].status == "failed"
    assert run(study, begun, retry=True).records[0, 4].status == "finished"


class Deadly(Executor):
    """A worker that dies of one train."""

    def __init__(self, modulus: float) -> None:
        self.modulus = modulus
        self.sizes: list[int] = []

    def submit(self, job, guess, /):  # type: ignore[no-untyped-def, override]
        future: Future[object] = Future()
        self.sizes.append(len(job.trains))
        if any(train.cell.shear_modulus == self.modulus for train in job.trains):
            future.set_exception(MemoryError("killed"))
        else:
            future.set_result(job(guess))
        return future


@pytest.mark.usefixtures("cheap")
def test_a_train_that_ends_its_worker_takes_no_other_with_it(begun: Path) -> None:
    study = sample(indices=True)
    # That of B, which is in the train of A with the column of B, too.
    bad = study.points[2][1].train.cell.shear_modulus
    deadly = Deadly(bad)
    records = run(study, begun, deadly).records
    failed = {index: each.reason for index, each in records.items() if each.status == "failed"}
    place = 2 + study.names.index("shear_modulus")
    assert set(failed) == {(1, 2), (place, 2)}
    assert set(failed.values()) == {"its worker died in 2 tries (MemoryError): killed"}
    assert len(records) == 80
    assert deadly.sizes == [5] * 16 + [1] * 5


def test_without_the_central_train_there_is_no_sample(tmp_path: Path, capsys, monkeypatch) -> None:
    narrow = {**CONTENT, "case": {**CONTENT["case"], "diameter": 1.0}}
    with pytest.raises(NoCentralTrain, match=r"the train of the means.*allowed: > 1\.07"):
        run(make_sampled_study(narrow), tmp_path)
    file = tmp_path / "narrow.toml"
    file.write_text(
        "[case]\ndiameter = 1\npacking = 0.2\ndegree = 6\n"
        "[distributions]\nshear_modulus = {uniform = {from = 1, to = 2}}\n"
    )
    monkeypatch.setattr(in_folder, "local_workers", one_thread)
    assert main(["sweep", str(file), "-o", str(tmp_path / "out")]) == 3
    assert "celltrain: the train of the means" in capsys.readouterr().err


@contextmanager
def one_thread(count: int | None = None) -> Iterator[Workers]:
    with ThreadPoolExecutor(1) as executor:
        yield Workers(executor, lambda: 1, "one thread")


def test_the_command_prints_keeps_and_shows(
    complete: tuple[Path, Sampled], tmp_path: Path, capsys, monkeypatch
) -> None:
    monkeypatch.setattr(in_folder, "local_workers", one_thread)
    monkeypatch.setattr("celltrain.study.sampling.statistics.RESAMPLES", 20)
    folder = tmp_path / "cells"
    shutil.copytree(complete[0], folder)
    file = tmp_path / "cells.toml"
    file.write_text(
        """
        [case]
        diameter = 6
        cells = 1
        degree = 6
        [distributions]
        shear_modulus = {lognormal = {relative_deviation = 0.02}}
        viscosity_ratio = {uniform = {from = 0.8, to = 1.2}}
        packing = {normal = {mean = 0.2, relative_deviation = 0.02}}
        [sample]
        points = 16
        indices = false
        [compute]
        azimuthal_numbers = [0, 1]
        """
    )
    monkeypatch.chdir(tmp_path)
    assert main(["sweep", str(file)]) == 0
    printed = capsys.readouterr()
    assert "16 of 16 cases were there already" in printed.err
    assert "cells: 16 points, 16 trains, 16 finished, 0 failed" in printed.out
    assert (folder / "table.md").read_text() == printed.out
    assert {"study.nc", "distributions.png", "growth.png"} <= {p.name for p in folder.iterdir()}
    assert main(["show", str(folder / "study.nc")]) == 0
    assert capsys.readouterr().out == printed.out
    assert main(["show", str(folder / "study.nc"), "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    assert shown["kind"] == "sample"
    assert shown["trains"] == {"finished": 16, "failed": 0, "not computed": 0}
    assert main(["sweep", str(file), "--json", "--quiet"]) == 0
    assert json.loads(capsys.readouterr().out) == shown
    assert main(["stability", str(folder / "study.nc")]) == 2
    assert "holds numbers only" in capsys.readouterr().err


KILLED = """
import os, signal, sys
from pathlib import Path
from celltrain.study.sampling.draws import DrawRecord
from celltrain.study.sampling.store import draw_store

records = {f"{i:024x}": DrawRecord("finished", "", {"gap": float(i)}) for i in range(50)}
with draw_store(Path(sys.argv[1]), {}) as store:
    store.add(records)
    store._connection.execute("BEGIN IMMEDIATE")
    store._connection.execute("DELETE FROM trains")
    store._connection.execute("PRAGMA cache_spill = 1")
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_store_whose_writer_is_killed_has_what_was_there(tmp_path: Path) -> None:
    process = subprocess.run([sys.executable, "-c", KILLED, str(tmp_path)], check=False)
    assert process.returncode == -signal.SIGKILL
    with draw_store(tmp_path, {}) as store:
        found = store.records()
    assert [record.values["gap"] for record in found.values()] == list(range(50))


def test_records_come_back_as_they_were(tmp_path: Path, monkeypatch) -> None:
    values = {"gap": 0.1 + 0.2, "error_estimate": float("nan"), "residual": 1e-300}
    record = DrawRecord("finished", "", values)
    study = sample()
    with draw_store(tmp_path, {"kind": "sample"}) as store:
        store.add({"a": record, "b": DrawRecord("failed", "why", {})})
    with draw_store(tmp_path, {"kind": "sample"}) as store:
        found = store.records()
        train = study.central
        addresses = {store.address(train, checked=checked) for checked in (True, False)}
        addresses.add(store.address(train.changed(cells=2), checked=False))
        assert len(addresses) == 3
        assert store.address(train.changed(scales={"radius": 3e-6}), checked=True) in addresses
    assert found["b"] == DrawRecord("failed", "why", {})
    assert repr(found["a"]) == repr(replace(record))
    # Another version computes anew.
    monkeypatch.setattr("celltrain.study.sampling.store.__version__", "9.9")
    with draw_store(tmp_path, {"kind": "sample"}) as store:
        assert store.records() == {}


def test_a_file_that_is_no_store_is_refused_and_left(tmp_path: Path) -> None:
    file = tmp_path / FILE
    file.write_bytes(b"something else" * 100)
    refused = pytest.raises(CaseError, match=r"trains\.sqlite in it is no file of a sample")
    with refused, draw_store(tmp_path, {}):
        pass
    assert file.read_bytes() == b"something else" * 100
    file.unlink()
    with sqlite3.connect(file) as connection:
        connection.execute("CREATE TABLE trains (address TEXT)")
    with pytest.raises(CaseError, match="no file of a sample"), draw_store(tmp_path, {}):
        pass


@pytest.mark.usefixtures("cheap")
def test_a_full_disk_ends_the_run_and_keeps_what_is_there(begun: Path, monkeypatch) -> None:
    class Full(sqlite3.Connection):
        def executemany(self, *arguments):  # type: ignore[no-untyped-def, override]
            if self.execute("SELECT count(*) FROM trains").fetchone()[0] == 3:
                raise sqlite3.OperationalError("database or disk is full")
            return super().executemany(*arguments)

    connect = sqlite3.connect
    monkeypatch.setattr(sqlite3, "connect", lambda path: connect(path, factory=Full))
    with pytest.raises(NotKept, match="database or disk is full"):
        run(sample(), begun)
    monkeypatch.undo()
    with draw_store(begun, {}) as store:
        assert len(store.records()) == 3


def test_a_store_that_cannot_be_written_is_an_error_of_the_system(tmp_path: Path) -> None:
    if os.geteuid() == 0:
        (tmp_path / FILE).mkdir()
    else:
        tmp_path.chmod(0o500)
    with pytest.raises(OSError, match="unable to open"), draw_store(tmp_path, {}):
        pass
