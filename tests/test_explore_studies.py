"""Studies in the explorer: the train under each point, and the ring around the one shown."""

import json
from pathlib import Path

import numpy as np
import pytest
from samples import CELLS, SI, made_up

pytest.importorskip("dash", reason="the explorer needs the extra `explore`")

from celltrain.explore.address import View, view_of
from celltrain.explore.changes import view_after
from celltrain.explore.maps import place_of, ring_at, study_figure, train_at
from celltrain.explore.opened import Opened, opened
from celltrain.explore.overview import overview_of
from celltrain.explore.page import page_of
from celltrain.parameters import CaseError, Train
from celltrain.results import save
from celltrain.study import (
    Study,
    StudyResult,
    collect,
    collect_sample,
    make_sampled_study,
    make_study,
)

CASE = {"diameter": 6, "packing": 0.2, "cells": 3, "degree": 8}
CASE_SI = {**CASE, "diameter": 16.5e-6}


def without(case: dict[str, object], *names: str) -> dict[str, object]:
    """A case without what varies."""
    return {name: value for name, value in case.items() if name not in names}


def assert_same(one: Train, other: Train) -> None:
    """Equal but for rounding, in both units: also numbers in SI, which are small."""
    for units in ("dimensionless", "SI"):
        for name, value in one.leaves(units).items():
            wanted = other.leaves(units)[name]
            number = isinstance(value, float)
            assert value == (pytest.approx(wanted, rel=1e-12, abs=0.0) if number else wanted), name


@pytest.fixture
def study() -> Study:
    """A study over two axes, one of them in SI."""
    axes = {"diameter": [16e-6, 17e-6], "packing": [0.2, 0.3, 0.4]}
    return make_study({"units": "SI", "case": without(CASE_SI, *axes), "axes": axes})


def found(study: Study) -> StudyResult:
    """A result that nobody computed: every case has a train, but one."""
    result = collect(study, {})
    result.data["spectral_abscissa"][:] = 0.01
    result.data["spectral_abscissa"][0, 1] = np.nan
    return result


def test_a_point_of_a_map_is_its_train(study: Study) -> None:
    result = collect(study, {})
    for case in study.cases:
        place = ",".join(str(each) for each in case.index)
        assert train_at(result, place).leaves() == pytest.approx(case.train.leaves())
    with pytest.raises(CaseError, match="a point of the map"):
        train_at(result, "7,0")
    with pytest.raises(CaseError, match="none of its cases has a steady train"):
        page_of(result)
    result = found(study)
    drawn = study_figure(result, "spectral_abscissa")
    places = [each for trace in drawn["data"] for each in trace.get("customdata", [])]
    assert sorted(places) == ["0,0", "0,1", "0,2", "1,0", "1,1", "1,2"]
    ring = ring_at(result, "1,2", "spectral_abscissa")
    assert (ring["x"], ring["y"]) == ([0.4], [17e-6])
    assert "page-data" in page_of(result)
    json.dumps(drawn, allow_nan=False)


@pytest.mark.parametrize(
    ("units", "axes"),
    [
        ("dimensionless", {"diameter": [5.5, 6], "capillary_number": [0.3, 2]}),
        ("dimensionless", {"viscosity_ratio": [1, 5], "shear_modulus": [1.0, 2.0]}),
        ("dimensionless", {"reduced_volume": [0.6, 0.8], "cells": [1, 4]}),
        ("SI", {"capillary_number": [0.3, 2]}),
        ("SI", {"diameter": [16e-6, 17e-6], "capillary_number": [0.3, 2]}),
        ("SI", {"capillary_number": [0.3, 2], "shear_modulus": [4e-6, 8e-6]}),
        ("SI", {"plasma_viscosity": [1e-3, 1.5e-3], "capillary_number": [0.3, 2]}),
        ("SI", {"bending_modulus": [1e-19, 3e-19], "mean_velocity": [1e-3, 3e-3]}),
        ("SI", {"radius": [2.7e-6, 2.9e-6], "reduced_volume": [0.6, 0.8]}),
        ("SI", {"viscosity_ratio": [1, 5], "degree": [8, 9]}),
    ],
    ids=lambda given: given if isinstance(given, str) else " ".join(given),
)
def test_a_click_opens_the_train_that_the_study_computes(
    units: str, axes: dict[str, list[float]]
) -> None:
    """With its scales: in SI another capillary number is another velocity, at the same moduli."""
    case = without(CASE_SI if units == "SI" else CASE, *axes)
    study = make_study({"units": units, "case": case, "axes": axes})
    result = collect(study, {})
    result.data["spectral_abscissa"][:] = 0.01
    shown = overview_of(result)
    view = View(shown.first, shown.units)
    for case in study.cases:
        place = ",".join(str(each) for each in case.index)
        opened = view_after(view, {"place": place}, Opened(view, study=shown)).train
        assert_same(opened, case.train)
        assert shown.place(opened) == place
        assert shown.place(view_of(View(opened).address).train) == place
        assert shown.place(opened.changed(packing=0.21)) is None


@pytest.mark.parametrize("content", [CELLS, SI], ids=["dimensionless", "SI"])
def test_a_click_on_a_dot_opens_its_train(content: dict, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("celltrain.study.sampling.statistics.RESAMPLES", 20)
    study = make_sampled_study(content)
    shown = overview_of(collect_sample(study, made_up(study)))
    view = View(shown.first, shown.units)
    assert shown.units == content.get("units", "dimensionless")
    assert shown.place(shown.first) is None
    for draw in study.draws:
        place = ",".join(str(each) for each in draw.index)
        opened = view_after(view, {"place": place}, Opened(view, study=shown)).train
        assert_same(opened, draw.train)
        assert shown.place(opened) == place


def test_the_ring_is_in_every_figure_that_has_one(
    study: Study, monkeypatch: pytest.MonkeyPatch
) -> None:
    result = found(study)
    result.data["gap"][:] = 1.0
    shown = overview_of(result)
    for name in ("spectral_abscissa", "gap"):
        assert shown.drawn(name, "1,2")["data"][-1]["x"] == [0.4]
        assert shown.drawn(name, None)["data"][-1]["x"] == []
    curve = make_study({"case": without(CASE, "packing"), "axes": {"packing": [0.2, 0.3]}})
    result = collect(curve, {})
    result.data["spectral_abscissa"][:] = [0.01, 0.02]
    ring = overview_of(result).drawn("spectral_abscissa", "1")["data"][-1]
    assert (ring["x"], ring["y"]) == ([0.3], [0.02])

    monkeypatch.setattr("celltrain.study.sampling.statistics.RESAMPLES", 20)
    sample = make_sampled_study(CELLS)
    shown = overview_of(collect_sample(sample, made_up(sample)))
    for name in shown.names:
        last = shown.drawn(name, "1,3")["data"][-1]
        if name.startswith("over "):
            assert last["x"] == [sample.points[3][1].values[name.removeprefix("over ")]]
        else:
            assert last == shown.figure(name)["data"][-1]


def test_a_train_of_other_axes_is_nowhere_in_the_figure() -> None:
    axes = {"cells": [2, 3], "diameter": [5.5, 6.0], "packing": [0.2, 0.3]}
    result = collect(make_study({"case": {"degree": 8}, "axes": axes}), {})
    train = Train(diameter=6, packing=0.3, cells=2, degree=8)
    assert place_of(result, train) == "1,1"
    assert place_of(result, train.changed(cells=3)) is None


def test_a_study_in_si_opens_in_si(study: Study, tmp_path: Path) -> None:
    save(found(study), tmp_path / "study.nc")
    assert opened(tmp_path).view.units == "SI"
