"""Studies: their files, their cases' addresses, what is computed and from where."""

import json
import math
import subprocess
import sys
from concurrent.futures import CancelledError, Executor, Future, ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest

from celltrain.analyses._study import StudyPresentation
from celltrain.contract import draw_all, load
from celltrain.parameters import CaseError, Train
from celltrain.results import save
from celltrain.steady import Base, NotConverged
from celltrain.study import (
    Computed,
    Outcome,
    StabilityOfCase,
    Store,
    Study,
    WorkersLost,
    collect,
    make_study,
    read_study,
    run_study,
)
from celltrain.study.columns import COLUMNS, WORDS
from celltrain.study.engine import compute_case

GRID = {
    "case": {"cells": 2, "degree": 6},
    "axes": {
        "diameter": {"from": 6, "to": 8, "points": 3},
        "packing": [0.2, 0.4],
    },
}


@dataclass(frozen=True)
class Cheap:
    """Takes no time; fails where it is told to. Remembers what it was given."""

    base: Base
    failing: tuple[float, ...] = ()
    calls: list[tuple[Train, Base | None]] = field(default_factory=list)
    kind: str = "cheap"

    @property
    def settings(self) -> dict[str, str]:
        return {"kind": self.kind}

    def __call__(self, train: Train, start: Base | None) -> Outcome:
        self.calls.append((train, start))
        if train.tube.diameter in self.failing:
            raise NotConverged("no steady train: not today", self.base)
        base = replace(self.base, train=train, origin="made up")
        alpha = train.tube.diameter * train.packing
        return Outcome(base, {"spectral_abscissa": alpha, "error_estimate": math.nan})


@pytest.fixture
def study() -> Study:
    return make_study(GRID)


@pytest.fixture
def cheap(make_base) -> Cheap:
    return Cheap(make_base(cells=2))


def run(study: Study, folder: Path, computation: Cheap, **options):
    with ThreadPoolExecutor(1) as executor:
        return run_study(study, folder, computation, executor, lambda: 1, **options)


def test_a_case_given_out_twice_is_computed_once(cheap: Cheap, tmp_path: Path) -> None:
    # Its first worker died after it was kept, before anybody had fetched the answer.
    train = Train(diameter=6, packing=0.2, cells=2, degree=6)
    record = compute_case(cheap, tmp_path, train, None)
    assert compute_case(cheap, tmp_path, train, None) == record
    assert len(cheap.calls) == 1
    # One that failed may be tried again.
    other = train.changed(diameter=7.0)
    broken = replace(cheap, failing=(7.0,))
    assert [compute_case(broken, tmp_path, other, None).status for _ in range(2)] == ["failed"] * 2
    assert compute_case(cheap, tmp_path, other, None).status == "finished"


def test_a_study_file_is_a_grid_of_cases(tmp_path: Path) -> None:
    path = tmp_path / "wide.toml"
    path.write_text(
        """
        [case.resolution]
        degree = 8
        [axes]
        diameter = {from = 6, to = 12, points = 4}
        cells = {from = 2, to = 4, points = 3}
        shear_modulus = {from = 0.1, to = 10, points = 3, spacing = "logarithmic"}
        law = ["skalak", "neo_hookean"]
        [case.train]
        packing = 0.3
        [compute]
        start = "neighbour"
        """
    )
    study = read_study(path)
    assert study.title == "wide"
    assert study.computed == Computed(start="neighbour")
    assert [axis.values for axis in study.axes] == [
        (6, 8, 10, 12),
        (2, 3, 4),
        (0.1, 1.0, 10.0),
        ("neo_hookean", "skalak"),
    ]
    assert len(study.cases) == 72
    last = study.cases[-1]
    assert last.index == (3, 2, 2, 1)
    assert last.train == Train(
        diameter=12, packing=0.3, cells=4, shear_modulus=10, law="skalak", degree=8
    )
    assert str(last) == "diameter = 12, cells = 4, shear_modulus = 10, law = skalak"
    # Decades are one step each on a logarithmic axis.
    assert [study.axes[2].place(i) for i in range(3)] == pytest.approx([0, 0.5, 1])


def test_axes_in_si_vary_what_follows_from_the_scales() -> None:
    study = make_study(
        {
            "units": "SI",
            "case": {"diameter": 16.8e-6, "packing": 0.2},
            "axes": {"mean_velocity": [2.875e-3, 5.75e-3]},
        }
    )
    slow, fast = (case.train for case in study.cases)
    assert collect(study, {}).data["mean_velocity"].attrs["units"] == "m/s"
    for modulus in ("shear_modulus", "dilatation_modulus", "bending_modulus"):
        assert slow.leaf(modulus) == pytest.approx(2 * fast.leaf(modulus))
    assert slow.tube.diameter == pytest.approx(6)


def test_the_degree_may_be_an_axis_or_left_open() -> None:
    case = {"diameter": 6, "packing": 0.2}
    study = make_study({"case": case, "axes": {"degree": [8, 12], "cells": [1, 2]}})
    assert [each.train.degree for each in study.cases] == [8, 8, 12, 12]
    assert [each.train.sizes.energy_order for each in study.cases] == [24, 24, 36, 36]
    left_open = make_study({"case": case, "axes": {"cells": [1, 2]}})
    assert [each.train.leaf("degree") for each in left_open.cases] == [None, None]
    addresses = {Store(Path(), {}).address(each.train) for each in left_open.cases + study.cases}
    assert len(addresses) == 6


@pytest.mark.parametrize(
    ("change", "parts"),
    [
        ({"axis": {}}, ["'axis'", "title, units, unusual, case, axes, compute"]),
        ({"axes": {}}, ["[axes] has no parameter", "at least one"]),
        ({"axes": {"diamter": [6]}}, ["diamter", "did you mean diameter"]),
        ({"axes": {"tube": [6]}}, ["axis tube is a section", "diameter"]),
        ({"axes": {"diameter": [6], "cells": [2]}}, ["cells is given twice"]),
        ({"axes": {"diameter": 6}}, ["axis diameter = 6", "a list of values or"]),
        ({"axes": {"diameter": []}}, ["axis diameter has no values"]),
        ({"axes": {"diameter": [6, True]}}, ["axis diameter: True"]),
        ({"axes": {"diameter": [6, "wide"]}}, ["mixes numbers and words"]),
        ({"axes": {"diameter": [6, 6.0]}}, ["a value twice"]),
        ({"axes": {"diameter": {"from": 6, "to": 8}}}, ["axis diameter: points is missing"]),
        (
            {"axes": {"diameter": {"from": 6, "to": 8, "points": 1}}},
            ["axis diameter: points = 1", "2 to 1000"],
        ),
        (
            {"axes": {"diameter": {"from": "six", "to": 8, "points": 2}}},
            ["axis diameter: from = 'six'", "a number"],
        ),
        (
            {"axes": {"diameter": {"from": 0, "to": 8, "points": 2, "spacing": "logarithmic"}}},
            ["axis diameter from 0 to 8", "> 0"],
        ),
        ({"axes": {"packing": [0.2, -1], "diameter": [6]}}, ["packing = -1", "> 0"]),
        ({"case": {"cells": 2.5}}, ["cells = 2.5", "a whole number"]),
        ({"case": [2]}, ["[case] is a section"]),
        ({"compute": {"start": "home"}}, ["start = 'home'", "rest or neighbour"]),
        ({"units": "CGS"}, ["units = 'CGS'"]),
        (
            {"axes": {f: {"from": 6, "to": 9, "points": 999} for f in ("diameter", "packing")}},
            ["998001 cases", "at most 100000"],
        ),
    ],
)
def test_studies_that_are_not_allowed(change: dict, parts: list[str]) -> None:
    with pytest.raises(CaseError) as caught:
        make_study({**GRID, **change})
    assert all(part in str(caught.value) for part in parts), caught.value


def test_addresses_tell_cases_apart_that_differ(tmp_path: Path, monkeypatch) -> None:
    train = Train(diameter=6, packing=0.2)
    store = Store(tmp_path, {"kind": "cheap"})
    address = store.address(train)
    assert address == Store(tmp_path, {"kind": "cheap"}).address(Train(packing=0.2, diameter=6.0))
    # What only serves to report results in SI is no part of the case.
    assert address == store.address(train.changed(scales={"radius": 3e-6}))
    others = [
        store.address(train.changed(tolerance=2e-6)),
        store.address(train.changed(cells=9)),
        Store(tmp_path, {"kind": "other"}).address(train),
    ]
    monkeypatch.setattr("celltrain.study.store.__version__", "9.9")
    others.append(store.address(train))
    assert len({address, *others}) == 5


def test_what_is_finished_is_not_computed_again(study, cheap, tmp_path: Path) -> None:
    first = run(study, tmp_path, cheap)
    assert len(first) == len(cheap.calls) == 6
    # A wider study in the same folder computes what is new.
    axes = {**GRID["axes"], "packing": [0.2, 0.3, 0.4]}
    run(make_study({**GRID, "axes": axes}), tmp_path, cheap)
    assert [train.packing for train, _ in cheap.calls[6:]] == [0.3] * 3
    again = run(study, tmp_path, cheap)
    assert again == first
    assert len(cheap.calls) == 9
    run(study, tmp_path, replace(cheap, kind="another"))
    assert len(cheap.calls) == 15


def test_cases_start_from_their_nearest_finished_neighbour(study, cheap, tmp_path: Path) -> None:
    records = run(study, tmp_path, cheap)
    assert cheap.calls[0][1] is None
    seen = [cheap.calls[0][0]]
    spans = {"diameter": 2.0, "packing": 0.2}

    def distance(one: Train, other: Train) -> float:
        return math.hypot(
            *((one.leaf(name) - other.leaf(name)) / span for name, span in spans.items())
        )

    for train, start in cheap.calls[1:]:
        assert start is not None
        nearest = min(distance(train, other) for other in seen)
        assert distance(train, start.train) == pytest.approx(nearest)
        seen.append(train)
    assert {record.origin for record in records.values()} == {"made up"}


def test_failures_are_kept_with_their_reason_and_retried_when_asked(
    study, cheap, tmp_path: Path
) -> None:
    failing = replace(cheap, failing=(7.0,))
    records = run(study, tmp_path, failing)
    failed = [index for index, record in records.items() if record.status == "failed"]
    assert failed == [(1, 0), (1, 1)]
    assert records[1, 0].reason == "NotConverged: no steady train: not today"
    # Nothing starts from a failed case.
    assert all(start is None or start.train.tube.diameter != 7 for _, start in failing.calls)
    count = len(cheap.calls)
    run(study, tmp_path, cheap)
    assert len(cheap.calls) == count
    records = run(study, tmp_path, cheap, retry=True)
    assert len(cheap.calls) == count + 2
    assert {record.status for record in records.values()} == {"finished"}


def test_records_that_cannot_be_read_count_as_none(study, cheap, tmp_path: Path) -> None:
    run(study, tmp_path, cheap)
    paths = sorted(tmp_path.glob("*.json"))
    paths[0].write_text("{")
    content = json.loads(paths[1].read_text())
    paths[1].write_text(json.dumps({**content, "status": "perhaps"}))
    run(study, tmp_path, cheap)
    assert len(cheap.calls) == 8


def test_a_neighbour_whose_file_is_gone_is_no_start(study, cheap, tmp_path: Path) -> None:
    for case in study.cases[:-1]:
        Store(tmp_path, cheap.settings).finish(case.train, cheap(case.train, None))
    for path in tmp_path.glob("*.nc"):
        path.unlink()
    cheap.calls.clear()
    run(study, tmp_path, cheap)
    assert [start for _, start in cheap.calls] == [None]


class Broken(Executor):
    """Ends every case with an error that no case has."""

    def __init__(self, error: BaseException) -> None:
        self.error = error

    def submit(self, *_: object) -> "Future[object]":  # type: ignore[override]
        future: Future[object] = Future()
        if isinstance(self.error, CancelledError):
            future.cancel()
            future.set_running_or_notify_cancel()
        else:
            future.set_exception(self.error)
        return future


def test_a_dead_worker_fails_its_case_and_a_lost_scheduler_none(
    study, cheap, tmp_path: Path
) -> None:
    with pytest.raises(WorkersLost):
        run_study(study, tmp_path, cheap, Broken(CancelledError()), lambda: 2)
    assert list(tmp_path.iterdir()) == []
    records = run_study(study, tmp_path, cheap, Broken(MemoryError("killed")), lambda: 2)
    assert {record.reason for record in records.values()} == {
        "its worker died in 2 tries (MemoryError): killed"
    }


def test_results_over_the_axes(study, cheap, tmp_path: Path) -> None:
    records = run(study, tmp_path, replace(cheap, failing=(7.0,)))
    result = collect(study, records)
    data = result.data
    alpha = data["spectral_abscissa"]
    assert alpha.dims == ("diameter", "packing")
    assert float(alpha.sel(diameter=8, packing=0.4)) == pytest.approx(3.2)
    assert np.isnan(alpha.sel(diameter=7)).all()
    assert np.isnan(data["error_estimate"]).all()
    assert "not today" in str(data["reason"].sel(diameter=7, packing=0.2).values)
    assert data["status"].values.tolist() == [
        ["finished"] * 2,
        ["failed"] * 2,
        ["finished"] * 2,
    ]
    meanings = {name: each.meaning for name, each in COLUMNS.items()} | WORDS
    for name, meaning in meanings.items():
        assert data[name].attrs["units"] == meaning.unit
    # As JSON has it there is no NaN.
    assert (
        StudyPresentation.summary(result)["data_vars"]["error_estimate"]["data"] == [[None] * 2] * 3
    )
    assert load(save(result, tmp_path / "study.nc")) == result
    lines = result.table().splitlines()
    assert lines[0].startswith("| diameter, r0 | packing | alpha, U/r0 |")
    assert "| 8 | 0.4 | 3.20e+00 |" in lines[7]
    assert lines[4].startswith("| 7 | 0.2 |  |")
    assert lines[-2] == "- diameter = 7, packing = 0.2: NotConverged: no steady train: not today"
    partial = collect(study, {(0, 0): records[0, 0]}).data
    assert (partial["status"] == "not computed").sum() == 5
    assert [path.name for path in draw_all(result, tmp_path)] == ["spectral_abscissa.png"]


def test_a_real_study(tmp_path: Path, coarse_base: Base) -> None:
    """Two trains, the second from the first; the first is known."""
    train = coarse_base.train
    modulus = train.cell.shear_modulus
    study = make_study(
        {
            "case": {
                name: value for name, value in train.leaves().items() if name != "shear_modulus"
            },
            "axes": {"shear_modulus": [modulus, 1.2 * modulus]},
            # The tilt, of m = 1, would lead.
            "compute": {"estimate_error": False, "start": "neighbour", "azimuthal_numbers": (0, 2)},
        }
    )
    with ThreadPoolExecutor(1) as executor:
        computation = StabilityOfCase(study.computed)
        records = run_study(study, tmp_path, computation, executor, lambda: 1)
    data = collect(study, records).data
    assert data["status"].values.tolist() == ["finished"] * 2
    assert float(data["cell_velocity"][0]) == pytest.approx(coarse_base.cell_velocity, abs=1e-9)
    assert str(data["origin"][1].values).startswith("continuation from shear_modulus")
    assert (data["residual"] < 1e-9).all()
    assert (data["numerical_abscissa"] > 0).all()
    assert (data["axisymmetric_growth_rate"] < 0).all()
    # Stiffer cells are wider: they bend less towards the axis.
    assert float(data["largest_radius"][1]) > float(data["largest_radius"][0])
    assert (data["taken_degree"] == 6).all()
    assert data["leading_azimuthal_number"].isin([0, 2]).all()


def test_a_case_without_a_degree_gets_one(tmp_path: Path) -> None:
    study = make_study({"case": {"packing": 0.2, "cells": 1}, "axes": {"diameter": [1.0, 6.0]}})
    with ThreadPoolExecutor(1) as executor:
        computation = StabilityOfCase(study.computed)
        records = run_study(study, tmp_path, computation, executor, lambda: 1)
    # What has no room is a case that failed, with its reason.
    assert records[0,].status == "failed"
    assert "allowed: > 1.07" in records[0,].reason
    record = records[1,]
    assert record.case["resolution"]["degree"] is None
    base = Store(tmp_path, computation.settings).base(study.cases[1].train)
    assert base.train.degree == record.values["taken_degree"] >= 16
    assert record.values["error_estimate"] <= 0.01 * record.values["spectral_abscissa"]
    assert f"| {base.train.degree} |" in collect(study, records).table()


def test_workers_need_no_jax() -> None:
    program = (
        "import sys, pickle\n"
        "from celltrain.study import Computed, StabilityOfCase\n"
        "from celltrain.study.engine import compute_case\n"
        "from celltrain import Train\n"
        "train = Train(diameter=6, packing=0.2, cells=1, degree=6)\n"
        "StabilityOfCase(Computed(estimate_error=False))(train, None)\n"
        "assert not {'jax', 'equinox'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", program], check=True)
