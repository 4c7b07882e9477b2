"""The paper's curves: their studies, and statements about numbers that are known."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from celltrain.paper import FIGURES, paper_study
from celltrain.paper.cell_volume import family
from celltrain.paper.flow_strength import in_paper_axes
from celltrain.parameters import paper_units
from celltrain.study import collect

STUDIES = ("fig13", "fig14", "fig16", "fig19")


def as_printed(name: str) -> xr.Dataset:
    """A study whose numbers are as the paper describes them."""
    data = collect(paper_study(FIGURES[name], quick=False), {}).data
    everywhere = xr.zeros_like(data["spectral_abscissa"]).fillna(0.0)
    dense = data.packing > 0.5
    rates: dict[str, xr.DataArray] = {}
    lengths: dict[str, xr.DataArray] = {}
    if name == "fig13":
        five = data.viscosity_ratio == 5
        rates["spectral_abscissa"] = xr.where(five & (data.packing > 0.31), 0.4, 0.1)
        rates["numerical_abscissa"] = xr.where(five, 20.0, 40.0)
    elif name == "fig14":
        power = np.log10(data.viscosity_ratio)
        stiff, soft = power.clip(0.0, np.log10(20.0)), (-power).clip(0.0)
        slope = xr.where(dense, 1.0, 0.08)
        rates["spectral_abscissa"] = 0.1 * (1.0 + slope * stiff + 0.5 * slope * soft)
        rates |= {"tumbling": 1.0 + stiff, "tank_treading": 1.0 + soft}
    elif name == "fig16":
        places = np.log10(in_paper_axes(data).Ca.values)
        power = data.mean_velocity.copy(data=places)
        rates["spectral_abscissa"] = xr.where(dense, 0.05 * 2.0**power, 0.1 * 2.0**-power)
        lengths["gap"] = 0.5 * 2.0**-power
        lengths["largest_radius"] = 1.3 + 0.11 * (power - places[0]) / np.ptp(places)
    else:
        v = data.reduced_volume
        peak = xr.where(data.diameter > 10, 0.52, 0.55)
        alpha = xr.where(dense, v - 0.01 * data.diameter, 0.1 - (v - peak) ** 2)
        rates["spectral_abscissa"] = alpha.where(~dense | (v < 0.87))
    for each, values in (rates | lengths).items():
        values = (values + everywhere).transpose(*everywhere.dims)
        data[each] = paper_units.rate_from_paper(values) if each in rates else values
    return data


def verdicts(name: str, data: xr.Dataset) -> list[bool | None]:
    return [each.holds for each in FIGURES[name].findings(data)]


@pytest.mark.parametrize("name", STUDIES)
def test_the_studies_have_what_the_statements_need(name: str) -> None:
    full, quick = (paper_study(FIGURES[name], quick=each) for each in (False, True))
    longest = max(len(axis.values) for axis in full.axes)
    assert longest >= 6
    assert full.computed.estimate_error
    # As high as the accuracy asks for.
    assert {case.train.resolution.degree for case in full.cases} == {None}
    assert {case.train.degree for case in quick.cases} == {16}
    assert len(quick.cases) <= 28
    for study in (full, quick):
        assert {case.train.cells for case in study.cases} == {8}
        assert {0.2, 0.7} <= {case.train.packing for case in study.cases}


def test_the_strength_of_the_flow_is_the_papers() -> None:
    data = in_paper_axes(collect(paper_study(FIGURES["fig16"], quick=False), {}).data)
    assert data.Ca.values == pytest.approx([0.4, 0.66, 1, 2, 4, 6, 10, 20.5])
    assert data.diameter.values == pytest.approx([8, 10])
    cases = paper_study(FIGURES["fig16"], quick=False).cases
    soft, stiff = cases[-1].train.cell, cases[0].train.cell
    # A stronger flow makes all three moduli smaller alike.
    for modulus in ("shear_modulus", "dilatation_modulus", "bending_modulus"):
        assert getattr(stiff, modulus) / getattr(soft, modulus) == pytest.approx(20.5 / 0.4)


@pytest.mark.parametrize("name", STUDIES)
def test_curves_as_the_paper_describes_them(name: str, tmp_path: Path) -> None:
    data = as_printed(name)
    found = verdicts(name, data)
    assert found
    assert all(found)
    path = tmp_path / f"{name}.png"
    FIGURES[name].draw({"converged": data, "paper": data}).savefig(path)
    assert path.stat().st_size > 10_000
    # With nothing computed nothing is known, and the picture is empty.
    nothing = collect(paper_study(FIGURES[name], quick=True), {}).data
    assert set(verdicts(name, nothing)) == {None}
    FIGURES[name].draw({"paper": nothing}).savefig(tmp_path / "empty.png")


@pytest.mark.parametrize(
    ("name", "quantity", "where", "factor", "fails"),
    [
        ("fig13", "numerical_abscissa", {"viscosity_ratio": 5}, 1.5, {0}),
        ("fig13", "spectral_abscissa", {"viscosity_ratio": 5, "packing": 0.2}, 2.0, {1}),
        ("fig13", "spectral_abscissa", {"viscosity_ratio": 5, "packing": 0.5}, 0.2, {2}),
        ("fig13", "spectral_abscissa", {"viscosity_ratio": 5, "packing": 0.7}, 3.0, {3}),
        ("fig14", "spectral_abscissa", {"viscosity_ratio": 100, "packing": 0.2}, 1.2, {1, 11}),
        ("fig14", "spectral_abscissa", {"viscosity_ratio": 0.1, "packing": 0.2}, 0.8, {2, 12}),
        ("fig14", "spectral_abscissa", {"viscosity_ratio": 100, "packing": 0.7}, 1.3, {5, 15}),
        ("fig14", "tumbling", {"viscosity_ratio": 20, "packing": 0.7}, 0.3, {7, 17}),
        ("fig19", "spectral_abscissa", {"reduced_volume": 0.8, "packing": 0.2}, 6.0, {0, 2}),
        ("fig19", "spectral_abscissa", {"reduced_volume": 0.8, "packing": 0.7}, 0.1, {1, 3}),
    ],
)
def test_each_statement_can_fail(name, quantity, where, factor, fails) -> None:
    data = as_printed(name)
    data[quantity].loc[where] = factor * data[quantity].loc[where]
    found = verdicts(name, data)
    assert {index for index, holds in enumerate(found) if not holds} == fails


def test_the_family_of_shapes(tmp_path: Path) -> None:
    data = family(8)
    names = [each.name for each in FIGURES["fig17"].findings(data)]
    assert names == ["P26"] * 3
    assert verdicts("fig17", data)[0]
    # Thicker with the volume; the sphere is as thick as it is wide.
    assert (np.diff(data["thickness"].values[2:]) > 0.0).all()
    height = np.ptp(data["profile"].sel(reduced_volume=1.0, axis="height").values)
    assert float(data["thickness"][-1]) == pytest.approx(float(height), rel=1e-5)
    # Without repulsion faces meet at a volume at which ours act.
    assert 0.4 < data["contact"] < 0.6
    path = tmp_path / "family.png"
    FIGURES["fig17"].draw({"paper": data}).savefig(path)
    assert path.stat().st_size > 10_000
