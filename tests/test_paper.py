"""The paper's maps: their studies, and what is said about a map that is known."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from drawn import labels, saved

from celltrain.paper import (
    FIGURES,
    Finding,
    findings_table,
    growth_findings,
    paper_study,
    transient_findings,
)
from celltrain.paper.resolutions import CONVERGED
from celltrain.parameters import Train, paper_units
from celltrain.study import collect


@pytest.fixture
def as_printed() -> xr.Dataset:
    """A map in which everything is as the paper says."""
    data = collect(paper_study(FIGURES["fig6"], quick=True), {}).data
    diameter, packing = data.diameter, data.packing
    ends = (packing < 0.35) | (packing > 0.55)
    growth = xr.where(ends, 0.1, 1e-4) * (1 - 0.02 * diameter)
    data["spectral_abscissa"].values = paper_units.rate_from_paper(growth.T.values)
    eta = 20 + 4 * (diameter - 6) + 75 * (packing - 0.2)
    data["numerical_abscissa"].values = paper_units.rate_from_paper(eta.values)
    dense = data["packing"] > 0.45
    for name, m, j in (
        ("leading", xr.full_like(packing, 1), xr.where(dense, 4, 0)),
        ("transient", xr.where(dense & (diameter > 8), 0, 2), xr.where(dense, 2, 4)),
    ):
        for part, values in (("azimuthal_number", m), ("wave_number", j)):
            place = data[f"{name}_{part}"]
            place.values = (values + 0 * place.fillna(0)).transpose(*place.dims).values
    return data


@pytest.mark.parametrize("name", ["fig6", "fig8"])
def test_a_quick_map_names_its_degree(name: str, as_printed: xr.Dataset) -> None:
    figure = FIGURES[name].draw({CONVERGED: as_printed})
    assert "M = 16" in labels(figure)
    assert "converged" not in labels(figure)
    full = as_printed.assign_attrs(case=Train(diameter=6, packing=0.2).to_toml())
    figure = FIGURES[name].draw({CONVERGED: full})
    assert "converged" in labels(figure)
    assert "M = 16" not in labels(figure)


def verdicts(findings: list[Finding]) -> list[bool | None]:
    return [finding.holds for finding in findings]


def test_the_grids_cover_the_paper() -> None:
    full, quick = (paper_study(FIGURES["fig6"], quick=each) for each in (False, True))
    assert [len(axis.values) for axis in full.axes] == [7, 11]
    for study in (full, quick):
        diameters, packings = (axis.values for axis in study.axes)
        assert (diameters[0], diameters[-1]) == (6, 12)
        assert {6, 10} <= set(diameters)
        assert {0.2, 0.4, 0.5, 0.7} <= set(packings)
        assert {case.train.cells for case in study.cases} == {8}
        assert {case.train.flow.viscosity_ratio for case in study.cases} == {1.0}
    # As high as the accuracy asks for.
    assert {case.train.resolution.degree for case in full.cases} == {None}
    assert {case.train.degree for case in quick.cases} == {16}
    as_in_the_paper = paper_study(FIGURES["fig6"], quick=False, degree=12)
    assert {case.train.degree for case in as_in_the_paper.cases} == {12}
    assert full.computed.estimate_error
    # Both figures are drawn from one study.
    assert FIGURES["fig6"].study == FIGURES["fig8"].study


def test_a_map_as_the_paper_describes_it(as_printed: xr.Dataset) -> None:
    assert verdicts(growth_findings(as_printed)) == [True] * 6
    assert verdicts(transient_findings(as_printed)) == [True] * 7


@pytest.mark.parametrize(
    ("name", "where", "value", "fails"),
    [
        ("spectral_abscissa", {"diameter": 6, "packing": 0.2}, 0.021, {0}),
        ("spectral_abscissa", {"diameter": 12, "packing": 0.2}, 0.01, {1}),
        ("spectral_abscissa", {"diameter": 10, "packing": 0.7}, 0.002, {2}),
        ("spectral_abscissa", {"diameter": 10, "packing": 0.5}, 1.1e-4, {3}),
        ("spectral_abscissa", {"diameter": 12, "packing": 0.5}, 1.0, set()),
        ("leading_azimuthal_number", {"diameter": 6, "packing": 0.2}, 0.0, {4}),
        ("leading_wave_number", {"diameter": 6, "packing": 0.7}, 3.0, {5}),
        ("spectral_abscissa", {"diameter": 6, "packing": 0.7}, np.nan, {2}),
    ],
)
def test_each_statement_on_growth_can_fail(as_printed, name, where, value, fails) -> None:
    as_printed[name].loc[where] = value
    found = verdicts(growth_findings(as_printed))
    assert {index for index, holds in enumerate(found) if holds is not True} == fails
    assert (None in found) == np.isnan(value)


@pytest.mark.parametrize(
    ("name", "where", "value", "fails"),
    [
        ("numerical_abscissa", {"diameter": 6, "packing": 0.2}, 1.0, {0}),
        ("numerical_abscissa", {"diameter": 10, "packing": 0.5}, 9.0, {1}),
        ("numerical_abscissa", {}, 2.0, {0, 1, 2, 3}),
        ("transient_azimuthal_number", {"diameter": 12, "packing": 0.2}, 0.0, {4}),
        ("transient_wave_number", {"diameter": 6, "packing": 0.7}, 4.0, {5}),
        ("transient_azimuthal_number", {"diameter": 10, "packing": 0.7}, 1.0, {6}),
    ],
)
def test_each_statement_on_transients_can_fail(as_printed, name, where, value, fails) -> None:
    as_printed[name].loc[where] = value
    found = verdicts(transient_findings(as_printed))
    assert {index for index, holds in enumerate(found) if holds is not True} == fails


def test_figures_and_the_table(as_printed: xr.Dataset, tmp_path: Path) -> None:
    as_printed["spectral_abscissa"].loc[{"diameter": 6, "packing": 0.7}] = np.nan
    for name in ("fig6", "fig8"):
        figure = FIGURES[name]
        path = saved(figure.draw({"converged": as_printed}), tmp_path / f"{name}.png")
        assert path.stat().st_size > 10_000
    text = findings_table(growth_findings(as_printed))
    assert "| P8 | alpha is below 0.001" in text
    assert "cases are missing | not known |" in text
    assert text.count("\n| P") == 6
