"""Studies of distributions: what they draw, what they refuse, and what they estimate."""

import math
from pathlib import Path

import numpy as np
import pytest
import scipy
import scipy.stats
from samples import CELLS, SI

from celltrain.membrane import healthy_reduced_volume
from celltrain.parameters import CaseError, Train
from celltrain.parameters.resolution import LARGEST_DEGREE
from celltrain.study import (
    SampledStudy,
    make_sampled_study,
    read_study,
)
from celltrain.study.sampling.definition import design, sobol_points
from celltrain.study.sampling.statistics import estimated, sobol_indices, summarise


def one(given: dict, name: str = "shear_modulus", points: int = 16, **case: object) -> SampledStudy:
    """A study of a single distribution."""
    content = {"case": {"diameter": 6, "packing": 0.2, **case}, "sample": {"points": points}}
    return make_sampled_study({**content, "distributions": {name: given}})


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        (
            {"normal": {"mean": 2.0, "standard_deviation": 0.3}},
            scipy.stats.truncnorm(-2.0 / 0.3, np.inf, 2.0, 0.3),
        ),
        (
            {"lognormal": {"mean": 2.0, "relative_deviation": 0.3}},
            scipy.stats.lognorm(math.sqrt(math.log(1.09)), scale=2.0 / math.sqrt(1.09)),
        ),
        ({"uniform": {"from": 1, "to": 5}}, scipy.stats.uniform(1, 4)),
        (
            {"normal": {"mean": 2.0, "standard_deviation": 1.0, "least": 1.0, "most": 2.5}},
            scipy.stats.truncnorm(-1.0, 0.5, 2.0, 1.0),
        ),
    ],
)
def test_values_have_their_distribution(given: dict, expected) -> None:
    [distribution] = one(given).distributions
    even = (np.arange(4096) + 0.5) / 4096
    values = distribution.values(even)
    assert values == pytest.approx(expected.ppf(even), rel=1e-9)
    assert distribution.scores(values) == pytest.approx(scipy.stats.norm.ppf(even), abs=1e-8)
    drawn = [draw.train.cell.shear_modulus for draw in one(given, points=4096).draws]
    assert np.mean(drawn) == pytest.approx(expected.mean(), rel=2e-4)
    assert np.std(drawn) == pytest.approx(expected.std(), rel=2e-3)
    assert scipy.stats.kstest(drawn, expected.cdf).statistic < 2e-3


def test_moments_of_a_lognormal_distribution_are_the_parameters_own() -> None:
    [distribution] = one({"lognormal": {"mean": 2.0, "relative_deviation": 0.3}}).distributions
    values = distribution.values((np.arange(2**16) + 0.5) / 2**16)
    assert values.mean() == pytest.approx(2.0, rel=1e-4)
    assert values.std() == pytest.approx(0.6, rel=1e-3)


def test_means_are_the_cases_own_unless_given() -> None:
    study = make_sampled_study(
        {
            "case": {"diameter": 6, "packing": 0.2, "shear_modulus": 2.0},
            "distributions": {
                name: {"normal": {"relative_deviation": 0.1}}
                for name in ("shear_modulus", "dilatation_modulus", "reduced_volume")
            },
            "sample": {"points": 16},
        }
    )
    means = {each.name: each.mean for each in study.distributions}
    assert means["shear_modulus"] == 2.0
    assert means["dilatation_modulus"] == Train(diameter=6, packing=0.2).cell.dilatation_modulus
    assert means["reduced_volume"] == healthy_reduced_volume(LARGEST_DEGREE)
    assert {study.central.leaf(name) for name in means} == set(means.values())
    # In SI the mean is in SI, too.
    shear = make_sampled_study(SI).distributions[1]
    assert shear.mean == pytest.approx(4.2e-6)


def test_what_a_parameter_does_not_allow_is_cut_off_and_told() -> None:
    [volume] = one({"normal": {"relative_deviation": 0.12}}, "reduced_volume").distributions
    part = scipy.stats.norm.cdf(0.4, volume.mean, volume.standard_deviation)
    assert f"{part:.2g} of it cut off below 0.4" in str(volume)
    values = volume.values(np.array([1e-9, 0.5, 1 - 1e-9]))
    assert values[0] == pytest.approx(0.4, abs=1e-4)
    assert values[2] < 1.0
    with pytest.raises(CaseError, match=r"22% of it lie beyond what is allowed, 0.4 to 1"):
        one({"normal": {"mean": 0.6, "standard_deviation": 0.22}}, "reduced_volume")
    # Who says where to cut means it.
    ends = {"least": 0.5, "most": 0.8}
    study = one({"normal": {"mean": 0.6, "standard_deviation": 0.22, **ends}}, "reduced_volume")
    drawn = [draw.values["reduced_volume"] for draw in study.draws]
    assert 0.5 < min(drawn) < max(drawn) < 0.8


def test_points_extend_and_do_not_hang_on_the_files_order() -> None:
    def trains(points: int, seed: int = 0, content: dict = CELLS) -> dict:
        study = make_sampled_study({**content, "sample": {"points": points, "seed": seed}})
        return {draw.index: draw.train for draw in study.draws}

    few, many = trains(16), trains(64)
    assert len(few) == 64
    assert len(many) == 256
    assert all(many[index] == train for index, train in few.items())
    turned = {**CELLS, "distributions": dict(reversed(CELLS["distributions"].items()))}
    assert trains(16, content=turned) == few
    assert trains(16, seed=1) != few
    # The third matrix has the shear modulus of B and the rest of A, the fourth the other way round.
    first, second, shear, ratio = (few[matrix, 5] for matrix in range(4))
    assert shear == first.changed(shear_modulus=second.cell.shear_modulus)
    assert ratio == first.changed(viscosity_ratio=second.flow.viscosity_ratio)


def test_without_indices_a_point_is_a_train() -> None:
    sample = {"points": 32, "indices": False}
    study = make_sampled_study({**CELLS, "sample": sample})
    assert study.total == 32
    assert study.matrices == ("A",)
    # All variance comes from a single parameter.
    assert one({"uniform": {"from": 1, "to": 2}}).total == 16


@pytest.mark.parametrize(
    ("change", "parts"),
    [
        ({"axes": {"cells": [1, 2]}}, ["axes and distributions", "not allowed together"]),
        ({"sample": {"points": 1000}}, ["points = 1000", "a power of two, such as 512 or 1024"]),
        ({"sample": {"points": 8}}, ["points = 8", "16 to 65536"]),
        ({"sample": {"points": 65536}}, ["65536 points with 4 trains", "at most 100000 trains"]),
        ({"sample": {"seed": -1}}, ["seed = -1", ">= 0"]),
        ({"samples": {}}, ["'samples'", "distributions, sample, compute"]),
        (
            {"distributions": {}},
            ["[distributions] has no parameter; allowed: at least one"],
        ),
        ({"distributions": []}, ["[distributions] is a section"]),
        ({"compute": {"analyses": []}}, ["'analyses'", "azimuthal_numbers"]),
        ({"compute": {"azimuthal_numbers": [7]}}, ["azimuthal_numbers = 7", "0 to the degree, 6"]),
        ({"units": "CGS"}, ["units = 'CGS'"]),
        ({"case": {"diameter": 6}}, ["packing is missing"]),
    ],
)
def test_studies_that_are_not_allowed(change: dict, parts: list[str]) -> None:
    with pytest.raises(CaseError) as caught:
        make_sampled_study({**CELLS, **change})
    assert all(part in str(caught.value) for part in parts), caught.value


@pytest.mark.parametrize(
    ("name", "given", "parts"),
    [
        ("cells", {"uniform": {"from": 1, "to": 3}}, ["distribution cells", "allowed: diameter"]),
        ("law", {"uniform": {"from": 1, "to": 3}}, ["distribution law is not allowed"]),
        ("tolerance", {"uniform": {"from": 1, "to": 3}}, ["distribution tolerance"]),
        ("radius", {"uniform": {"from": 1, "to": 3}}, ["distribution radius is not allowed"]),
        ("shear_modulus", 3, ["shear_modulus = 3", "{normal = {mean"]),
        ("shear_modulus", {"gamma": {}}, ["'gamma'", "{uniform = {from"]),
        ("shear_modulus", {"normal": 3}, ["normal = 3 is not allowed: it is a table"]),
        ("shear_modulus", {"normal": {"mean": 1}}, ["neither is given", "relative_deviation"]),
        (
            "shear_modulus",
            {"normal": {"standard_deviation": 1, "relative_deviation": 1}},
            ["both are given"],
        ),
        (
            "shear_modulus",
            {"normal": {"standard_deviation": -0.1}},
            ["distribution shear_modulus: standard_deviation = -0.1", "> 0"],
        ),
        ("shear_modulus", {"normal": {"relative_deviation": 0}}, ["relative_deviation = 0", "> 0"]),
        ("shear_modulus", {"normal": {"mean": "a"}}, ["mean = 'a'", "a number"]),
        (
            "shear_modulus",
            {"lognormal": {"mean": -1, "standard_deviation": 1}},
            ["shear_modulus = -1"],
        ),
        ("shear_modulus", {"uniform": {"from": 2, "to": 1}}, ["from = 2 and to = 1", "from < to"]),
        ("shear_modulus", {"uniform": {"from": -1, "to": 1}}, ["-1 is not allowed", "above 0"]),
        ("reduced_volume", {"uniform": {"from": 0.3, "to": 1}}, ["0.3 is not allowed", "0.4 to 1"]),
        (
            "shear_modulus",
            {"normal": {"standard_deviation": 1, "least": 2, "most": 1}},
            ["least = 2 and most = 1"],
        ),
        (
            "shear_modulus",
            {"normal": {"mean": 1, "standard_deviation": 1, "least": 2}},
            ["mean = 1 is not allowed", "above 2"],
        ),
        (
            "spontaneous_curvature",
            {"normal": {"relative_deviation": 0.1}},
            ["with a mean of 0", "standard_deviation"],
        ),
        ("aspect_ratio", {"normal": {"relative_deviation": 0.1}}, ["mean is missing"]),
        ("diameter", {"uniform": {"from": 5, "to": 7}}, ["diameter is given twice"]),
    ],
)
def test_distributions_that_are_not_allowed(name: str, given: object, parts: list[str]) -> None:
    with pytest.raises(CaseError) as caught:
        one(given, name)  # type: ignore[arg-type]
    assert all(part in str(caught.value) for part in parts), caught.value


def test_a_file_with_distributions_is_a_sample(tmp_path: Path) -> None:
    path = tmp_path / "cells.toml"
    path.write_text(
        """
        [case]
        diameter = 6
        packing = 0.2
        [distributions]
        shear_modulus = {lognormal = {relative_deviation = 0.3}}
        [sample]
        points = 32
        """
    )
    study = read_study(path)
    assert isinstance(study, SampledStudy)
    assert (study.title, study.total) == ("cells", 32)
    path.write_text("[case]\npacking = 0.2\n[axes]\ndiameter = [6]\n[sample]\npoints = 32\n")
    with pytest.raises(CaseError, match=r"\[sample\] is not allowed without \[distributions\]"):
        read_study(path)


def ishigami(x: np.ndarray) -> np.ndarray:
    """The function of Ishigami & Homma (1990) on a cube (0, 1)^3."""
    a, b, c = np.moveaxis(2.0 * np.pi * x - np.pi, -1, 0)
    return np.sin(a) + 7.0 * np.sin(b) ** 2 + 0.1 * c**4 * np.sin(a)


def test_indices_of_a_known_function() -> None:
    values = ishigami(design(sobol_points(4096, 6, 3)))[None]
    found = sobol_indices(values)
    # From its variance, 7^2/8 + 0.1 pi^4/5 + 0.1^2 pi^8/18 + 1/2, and partial variances.
    variance = 49 / 8 + 0.1 * np.pi**4 / 5 + 0.01 * np.pi**8 / 18 + 0.5
    alone = np.array([0.5 * (1 + 0.1 * np.pi**4 / 5) ** 2, 49 / 8, 0.0]) / variance
    shared = 0.01 * np.pi**8 * (1 / 18 - 1 / 50) / variance
    assert found.first_order[0] == pytest.approx(alone, abs=0.01)
    assert found.total_order[0] == pytest.approx(alone + np.array([shared, 0.0, shared]), abs=0.01)


def test_indices_are_those_of_scipy() -> None:
    values = ishigami(design(sobol_points(256, 6, 0)))
    values = np.stack([values, values**2 + 100.0])
    found = sobol_indices(values)
    known = scipy.stats.sobol_indices(
        func={
            "f_A": values[:, 0],
            "f_B": values[:, 1],
            "f_AB": np.moveaxis(values[:, 2:], 1, 0),
        },
        n=256,
    )
    assert found.first_order == pytest.approx(known.first_order, abs=1e-12)
    assert found.total_order == pytest.approx(known.total_order, abs=1e-12)


def test_intervals_of_indices_hold_the_true_ones_as_often_as_they_say() -> None:
    """A linear function of independent numbers, drawn anew many times, without Sobol's evenness."""
    weights = np.array([1.0, 2.0, 0.5])
    true = weights**2 / (weights**2).sum()
    inside = []
    for seed in range(16):
        even = np.random.default_rng(seed).random((128, 6))
        found = estimated((design(even) @ weights)[None], indices=True, seed=seed)
        assert found.low is not None
        assert found.high is not None
        inside.append((found.low.first_order[0] <= true) & (true <= found.high.first_order[0]))
    assert 0.85 <= np.mean(inside) <= 1.0


def test_errors_of_moments_are_those_of_independent_points() -> None:
    values = np.random.default_rng(5).normal(size=(1, 1, 400))
    found = estimated(values, indices=False)
    assert found.summary.mean[0] == pytest.approx(values.mean())
    assert found.summary.standard_deviation[0] == pytest.approx(values.std(ddof=1))
    assert found.error.mean[0] == pytest.approx(0.05, rel=0.15)
    assert found.error.standard_deviation[0] == pytest.approx(1 / math.sqrt(800), rel=0.2)
    assert found.summary.quantile[0, 2] == np.median(values)
    # Of a median 1.2533 times that of the mean.
    assert found.error.quantile[0, 2] == pytest.approx(1.2533 * 0.05, rel=0.3)
    assert found.error.positive[0] == pytest.approx(0.5 * 0.05, rel=0.15)
    assert found.indices is None


def test_an_output_that_does_not_vary_has_no_indices() -> None:
    values = np.full((1, 4, 16), 0.1) * (1.0 + 1e-16 * np.arange(16))
    assert np.isnan(sobol_indices(values).first_order).all()
    none = summarise(np.full((1, 1, 3), np.nan), np.zeros((1, 3), dtype=bool))
    assert np.isnan(none.mean).all()
