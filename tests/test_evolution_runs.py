"""Simulations that are stopped, killed, gone on with, or cannot go on; their files."""

import errno
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from itertools import chain, repeat
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose, assert_array_equal
from same_runs import assert_same, assert_same_place

from celltrain import Base, CaseError, load, save
from celltrain.cli import main
from celltrain.diagnostics import FRAME_QUANTITIES, disturbance_amplitude, frame
from celltrain.evolution import (
    Automatic,
    ForwardEuler,
    FromFile,
    RandomDisplacement,
    Run,
    RungeKuttaChebyshev,
    Status,
    evolve,
    resume,
)
from celltrain.evolution.dynamics import Dynamics
from celltrain.evolution.record.quantities import KEPT_OF_FRAMES, STEP_QUANTITIES
from celltrain.evolution.record.recompute import frame_rates, pressure_drops
from celltrain.membrane import place_cells
from celltrain.results import remove_leftovers
from celltrain.results.replace import beside

DISTURBANCE = RandomDisplacement(0.2, seed=2)


@pytest.fixture(scope="module")
def single(coarse_base: Base) -> Base:
    """A train of one cell, which costs least; its steady shape is that of any number of cells."""
    return replace(coarse_base, train=coarse_base.train.changed(cells=1))


@pytest.fixture(scope="module")
def whole_path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("whole") / "run.nc"


@pytest.fixture(scope="module")
def whole(single: Base, whole_path: Path) -> Run:
    """Ten steps without a stop."""
    run = evolve(
        single, DISTURBANCE, degree=6, until=50.0, every=0.5, path=whole_path, most_steps=10
    )
    assert run.ending.kind == "steps"
    assert run.steps == 10
    return run


def test_five_steps_and_five_more_are_ten(whole: Run, single, tmp_path: Path) -> None:
    path = tmp_path / "run.nc"
    half = evolve(single, DISTURBANCE, degree=6, until=50.0, every=0.5, path=path, most_steps=5)
    assert half.steps == 5
    assert_same(resume(path, most_steps=5), whole)
    assert [each.name for each in tmp_path.iterdir()] == ["run.nc"]


def test_an_interruption_keeps_all_until_then(whole: Run, single, tmp_path: Path) -> None:
    path = tmp_path / "run.nc"

    def interrupt(status: Status) -> None:
        if status.steps == 4:
            raise KeyboardInterrupt

    run = evolve(
        single, DISTURBANCE, degree=6, until=50.0, every=0.5, path=path, progress=interrupt
    )
    assert run.ending.kind == "interrupted"
    assert run.steps == 4
    assert_same(Run.load(path), run)
    assert_same(resume(path, most_steps=6), whole)


def test_frames_do_not_change_steps_and_an_end_may_be_put_off(
    whole: Run, single, tmp_path: Path
) -> None:
    path = tmp_path / "run.nc"
    # An end within a step: what is beyond it is not kept, and not lost.
    end = 0.5 * (whole.history["time"][6] + whole.history["time"][7])
    short = evolve(single, DISTURBANCE, degree=6, until=end, every=5.0, path=path)
    assert short.ending.kind == "complete"
    assert short.times.tolist() == [0.0, end]
    assert short.history["time"].tolist() == whole.history["time"][:7].tolist()
    assert_same(resume(path), short)
    longer = resume(path, until=50.0, most_steps=4)
    assert_same_place(whole, longer)
    assert whole.work == longer.work
    with pytest.raises(CaseError, match=r"until = 0\.01 .* already reached"):
        resume(path, until=0.01)


def test_the_command_of_a_simulation_that_is_complete_says_so_again(single, tmp_path: Path) -> None:
    """Also where its last time is not `until` to the last bit: 6 x 0.1 is more than 0.6."""
    path = tmp_path / "run.nc"
    run = evolve(single, DISTURBANCE, degree=6, until=0.6, every=0.1, path=path)
    assert run.times[-1] > 0.6
    assert_same(resume(path, until=0.6), run)


def test_a_file_holds_everything(whole: Run, whole_path: Path) -> None:
    assert_same(Run.load(whole_path), whole)
    again = Run.load(whole_path)
    assert (again.disturbance, again.until, again.every) == (str(DISTURBANCE), 50.0, 0.5)
    assert again.integrator == Automatic()
    assert again.ending == whole.ending
    assert_array_equal(again.growth_rate, whole.growth_rate)
    assert load(whole_path) == whole
    known = {f"history_{name}": each for name, each in STEP_QUANTITIES.items()}
    known |= {f"frames_{name}": each for name, each in KEPT_OF_FRAMES.items()}
    assert set(whole.history) == set(STEP_QUANTITIES)
    assert set(whole.frames) == set(KEPT_OF_FRAMES)
    with xr.open_dataset(whole_path, engine="netcdf4", decode_times=False) as data:
        for name, each in known.items():
            assert data[name].ndim == len(each.dims)
            assert data[name].attrs["units"] == each.unit
            assert data[name].attrs["long_name"] == each.description
    assert set(FRAME_QUANTITIES) < set(whole.frames)
    assert_allclose(whole.frames["cell_volume"], 4 * np.pi / 3, rtol=1e-3)
    assert_allclose(np.ptp(whole.frames["cell_volume"]), 0.0, atol=1e-7)
    # Velocities are those in the tube, positions those relative to the steady train.
    assert_allclose(whole.frames["centroid_velocity"][..., 2], whole.base.cell_velocity, rtol=0.2)
    assert_allclose(disturbance_amplitude(whole.disturbances[0]), 0.2, rtol=1e-2)
    assert_allclose(whole.frames["eps"][0], whole.history["eps"][0], rtol=1e-12)


def test_rates_of_frames_are_those_that_were_recorded(whole: Run) -> None:
    rates = frame_rates(whole)
    for number, shapes in enumerate(whole.shapes):
        measured = frame(whole.train, shapes, rates[number])
        for name in ("centroid_velocity", "rotation_rate", "tank_treading"):
            assert_allclose(measured[name], whole.frames[name][number], rtol=0, atol=1e-9)


def test_pressure_drop_of_frames(whole: Run) -> None:
    base, train = whole.base, whole.train
    drops = pressure_drops(whole)
    assert drops.shape == whole.times.shape
    # A cell off the axis costs another pressure.
    assert np.abs(drops - base.effective_viscosity).max() > 1e-5
    steady = np.stack([place_cells(base.coefficients, train, train.cells)] * len(whole.times))
    calm = replace(whole, shapes=steady)
    assert_allclose(pressure_drops(calm), base.effective_viscosity, rtol=0, atol=1e-6)


def test_a_disturbance_from_the_file_of_a_run(whole: Run, whole_path: Path) -> None:
    assert_array_equal(FromFile(whole_path).shapes(whole.start), whole.disturbances[-1])


@pytest.mark.usefixtures("whole")
@pytest.mark.parametrize(
    "missing",
    [
        "state_measures_gap",
        "memory_automaticmemory_chebyshev_radius",
        "start_kind",
        "repulsion_range",
    ],
)
def test_a_file_of_another_version_says_so(
    whole_path: Path, tmp_path: Path, missing: str, capsys: pytest.CaptureFixture[str]
) -> None:
    data = xr.load_dataset(whole_path, engine="netcdf4", decode_times=False)
    data.attrs["celltrain_version"] = "0.0.7"
    path = tmp_path / "old.nc"
    data.drop_vars(missing).to_netcdf(path, engine="netcdf4")
    before = path.read_bytes()
    with pytest.raises(OSError, match=rf"by celltrain 0\.0\.7 and lacks.*{missing}"):
        Run.load(path)
    for words in (["plot", str(path)], ["evolve", "--resume", "-o", str(path)]):
        assert main(words) == 2
        message = " ".join(capsys.readouterr().err.split())
        assert str(path) in message
        assert "it was written by celltrain 0.0.7" in message
    assert path.read_bytes() == before


def test_results_that_are_no_simulations(single, tmp_path: Path) -> None:
    path = tmp_path / "base.nc"
    save(single, path)
    with pytest.raises(ValueError, match="holds no simulation"):
        Run.load(path)
    with pytest.raises(CaseError, match="holds no simulation"):
        resume(path)
    with pytest.raises(CaseError, match="it exists"):
        evolve(single, DISTURBANCE, degree=6, until=1.0, path=path)
    with pytest.raises(CaseError, match="until = -1"):
        evolve(single, DISTURBANCE, degree=6, until=-1.0)
    with pytest.raises(CaseError, match=r"into the wall at .*; a smaller amplitude"):
        evolve(single, RandomDisplacement(9.0), degree=6, until=1.0)


def test_a_full_disk_ends_a_run_with_the_last_file_left(
    whole: Run, single, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "run.nc"
    calls = []

    def full(path_: Path) -> None:
        calls.append(path_)
        if len(calls) > 6:
            raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("celltrain.results.replace._flush", full)
    run = evolve(
        single,
        DISTURBANCE,
        degree=6,
        until=50.0,
        every=0.5,
        path=path,
        save_seconds=0.0,
        most_steps=10,
    )
    assert run.ending.kind == "not_saved"
    assert "No space left" in run.ending.message
    assert run.ending.failed
    # The first save and those after two of the steps went well; nothing half-written is left.
    assert [each.name for each in tmp_path.iterdir()] == ["run.nc"]
    kept = Run.load(path)
    assert kept.ending.kind == "running"
    assert 1 <= kept.steps <= 2 < len(run.history["time"])
    monkeypatch.undo()
    assert_same(resume(path, most_steps=10 - kept.steps), whole)


def test_reasons_to_stop(single, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    strict = RungeKuttaChebyshev(tolerance=1e-30)
    run = evolve(single, DISTURBANCE, degree=6, until=1.0, integrator=strict)
    assert run.ending.kind == "step_too_small"
    assert run.times.tolist() == [0.0]

    with monkeypatch.context() as patched:
        # Of the train, at the beginning and after two steps all is well; then even the shortest
        # step is too long.
        met = chain([()] * 4, repeat(["cell 0 and cell 1 overlap"]))
        patched.setattr(Dynamics, "overlaps", lambda self, shapes: next(met))
        run = evolve(single, DISTURBANCE, degree=6, until=1.0, path=tmp_path / "run.nc")
    assert run.ending.kind == "overlap"
    assert "cell 0 and cell 1 overlap" in run.ending.message
    assert Run.load(tmp_path / "run.nc").steps == 3
    assert run.history["size"][-1] < 1e-3

    with monkeypatch.context() as patched:
        met = chain([()] * 3, [["cell 0 and cell 1 overlap"]], repeat(()))
        patched.setattr(Dynamics, "overlaps", lambda self, shapes: next(met))
        again = evolve(single, DISTURBANCE, degree=6, until=1.0, most_steps=3)
    assert again.ending.kind == "steps"
    assert again.work.rejected == 1
    whole = evolve(single, DISTURBANCE, degree=6, until=1.0, most_steps=3)
    assert again.history["size"][2] == pytest.approx(0.25 * whole.history["size"][2])

    rates, left = Dynamics.rates, [30]

    def broken(self: Dynamics, shapes: np.ndarray) -> np.ndarray:
        left[0] -= 1
        return rates(self, shapes) if left[0] > 0 else np.full_like(shapes, np.nan)

    monkeypatch.setattr(Dynamics, "rates", broken)
    for method in (Automatic(), RungeKuttaChebyshev(), ForwardEuler(0.01)):
        left[0] = 30
        run = evolve(single, DISTURBANCE, degree=6, until=50.0, every=99.0, integrator=method)
        assert run.ending.kind == "not_finite"
        assert run.steps > 0
        assert np.isfinite(run.state.shapes).all()
        assert np.isfinite(run.shapes).all()


SCRIPT = """
import sys
import celltrain
from celltrain.evolution import ForwardEuler, RandomDisplacement, evolve, resume
start, path, first = sys.argv[1:]
if first == "first":
    evolve(
        celltrain.load(start), RandomDisplacement(0.2, seed=2), degree=6, until=0.6, every=0.05,
        integrator=ForwardEuler(0.01), path=path, save_seconds=0.0,
    )
else:
    resume(path, save_seconds=0.0)
"""


@pytest.mark.slow
def test_kill_at_any_moment_leaves_a_file_to_go_on_with(single, tmp_path: Path) -> None:
    start, path = tmp_path / "start.nc", tmp_path / "run.nc"
    save(single, start)
    random = np.random.default_rng()
    reached = []
    for attempt in ("first", "second", "third"):
        written = {path.stat().st_mtime_ns} if path.exists() else set()
        # The save at the beginning and those of two steps at least, then any moment.
        wanted = len(written) + 3
        process = subprocess.Popen([sys.executable, "-c", SCRIPT, start, path, attempt])
        deadline = time.monotonic() + 120.0
        while len(written) < wanted:
            assert process.poll() is None
            assert time.monotonic() < deadline
            time.sleep(0.01)
            if path.exists():
                written.add(path.stat().st_mtime_ns)
        time.sleep(random.uniform(0.0, 0.6))
        process.send_signal(signal.SIGKILL)
        process.wait()
        kept = Run.load(path)
        reached.append(kept.steps)
        assert len(kept.history["time"]) == kept.steps + 1
    assert 1 <= reached[0] < reached[1] < reached[2]
    # Whatever was killed, the end is that of a run without a stop.
    ended = resume(path)
    straight = evolve(
        single,
        DISTURBANCE,
        degree=6,
        until=0.6,
        every=0.05,
        integrator=ForwardEuler(0.01),
    )
    assert_same(replace(ended, start=straight.start), straight)
    assert not list(tmp_path.glob(".*"))


def test_leftovers_of_dead_processes_are_removed(tmp_path: Path) -> None:
    path = tmp_path / "run.nc"
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    dead = tmp_path / f"{beside(path)}.{process.pid}.0.part.nc"
    alive = tmp_path / f"{beside(path)}.{os.getppid()}.3.part.nc"
    for each in (dead, alive):
        each.write_text("")
    remove_leftovers(path)
    assert not dead.exists()
    assert alive.exists()
