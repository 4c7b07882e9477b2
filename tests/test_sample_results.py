"""Results of studies of distributions: their failures, their scales, their pages."""

import base64
import gzip
import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
from samples import CELLS, SI, made_up

from celltrain.contract import draw_all, load, show
from celltrain.explore.opened import opened
from celltrain.explore.overview import overview_of
from celltrain.parameters import CaseError
from celltrain.results import save
from celltrain.study import (
    collect_sample,
    make_sampled_study,
)


@pytest.fixture
def few_resamples(monkeypatch: pytest.MonkeyPatch) -> None:
    """Errors that are rough, and quick."""
    monkeypatch.setattr("celltrain.study.sampling.statistics.RESAMPLES", 20)


@pytest.mark.usefixtures("few_resamples")
def test_failed_trains_are_counted_named_and_left_out(tmp_path: Path, capsys) -> None:
    study = make_sampled_study({**CELLS, "sample": {"points": 64}})
    result = collect_sample(study, made_up(study, ((0, 3), (2, 3), (1, 9))))
    data = result.data
    assert result.failed == 3
    assert data.attrs["complete_points"] == 62
    assert int((data["status"] == "finished").sum()) == 253
    table = result.table()
    assert "64 points, 256 trains, 253 finished, 3 failed" in table
    assert "2 points with a failed train are left out of the indices" in table
    values = {str(name): float(data[name][1, 9]) for name in study.names}
    words = ", ".join(f"{name} = {value:g}" for name, value in values.items())
    assert f"- {words}: NotConverged: not today" in table
    # The moments are those of the trains that were found.
    moduli = data["shear_modulus"].where(data["status"] == "finished")
    assert float(data["mean"].sel(output="spectral_abscissa")) == pytest.approx(
        float(moduli.mean()) - 1.0
    )
    assert float(data["positive"].sel(output="spectral_abscissa")) == pytest.approx(
        float((moduli > 1).sum()) / 253
    )
    alpha = data["first_order"].sel(output="spectral_abscissa")
    assert float(alpha.sel(parameter="shear_modulus")) == pytest.approx(1.0, abs=0.15)
    assert float(alpha.sel(parameter="viscosity_ratio")) == pytest.approx(0.0, abs=1e-12)
    assert "does not vary" in table  # as the gap
    assert load(save(result, tmp_path / "study.nc")) == result
    show(result)
    assert capsys.readouterr().out == table
    drawn = [path.name for path in draw_all(result, tmp_path)]
    assert drawn == ["distributions.png", "growth.png", "indices.png"]


@pytest.mark.usefixtures("few_resamples")
def test_many_failures_are_named_up_to_a_number_and_counted() -> None:
    study = make_sampled_study(CELLS)
    every = tuple((matrix, point) for matrix in range(4) for point in range(16))
    result = collect_sample(study, made_up(study, every[:25]))
    assert "- and 5 more; `reason` in the file names all" in result.table()
    assert len(result.failures()) == 25
    # Also where nothing is left, or nothing was computed.
    nothing = collect_sample(study, made_up(study, every))
    assert nothing.failed == 64
    assert "64 trains, 0 finished, 64 failed" in nothing.table()
    begun = collect_sample(study, replace(made_up(study), records={}))
    assert "64 not computed" in begun.table()


@pytest.mark.usefixtures("few_resamples")
def test_outputs_in_si_have_the_scales_of_each_train() -> None:
    study = make_sampled_study(SI)
    data = collect_sample(study, made_up(study)).data
    assert data["spectral_abscissa"].attrs["units"] == "1/s"
    assert data["radius"].attrs["units"] == "m"
    draw = study.points[7][1]
    alpha = draw.train.cell.shear_modulus - 1.0
    found = float(data["spectral_abscissa"][1, 7])
    assert found == pytest.approx(alpha * 2.875e-3 / draw.values["radius"])
    assert float(data["gap"][1, 7]) == pytest.approx(2.0 * draw.values["radius"])
    assert float(data["effective_viscosity"][1, 7]) == pytest.approx(2.0 * 1.2e-3)
    assert float(data["central"].sel(output="cell_velocity")) == pytest.approx(2.875e-3)


@pytest.mark.parametrize("content", [CELLS, SI], ids=["dimensionless", "SI"])
@pytest.mark.usefixtures("few_resamples")
def test_a_dot_in_the_browser_is_its_train(content: dict) -> None:
    study = make_sampled_study(content)
    result = collect_sample(study, made_up(study, ((1, 2),)))
    shown = overview_of(result)
    assert shown.first.leaves("SI") == pytest.approx(study.central.leaves("SI"))
    [name] = [each for each in shown.names if each.endswith(f"over {study.names[0]}")]
    dots, ring = shown.figure(name)["data"]
    assert ring["x"] == []
    # The failed train has no growth rate, and no dot.
    assert len(dots["x"]) == 2 * study.sample.points - 1
    for draw in study.draws:
        place = ",".join(map(str, draw.index))
        assert shown.train(place).leaves("SI") == pytest.approx(draw.train.leaves("SI"))
        if place in dots["customdata"]:
            number = dots["customdata"].index(place)
            around = shown.ring(place, name)
            assert around == {"x": [dots["x"][number]], "y": [dots["y"][number]]}
            assert around["x"] == [draw.values[study.names[0]]]
    for place in ("0", "0,16", "9,0", "-1,0", "a,b"):
        with pytest.raises(CaseError, match="a point of the figure"):
            shown.train(place)


@pytest.mark.usefixtures("few_resamples")
def test_a_sample_has_a_page(tmp_path: Path) -> None:
    pytest.importorskip("plotly")
    from celltrain.explore.page import page_of

    study = make_sampled_study(CELLS)
    result = collect_sample(study, made_up(study))
    shown = overview_of(result)
    for name in shown.names:
        json.dumps(shown.figure(name), allow_nan=False)
    histogram = shown.figure("distribution of spectral_abscissa")["data"][0]
    assert sum(histogram["y"]) == 64
    bars = shown.figure("indices of spectral_abscissa")["data"]
    wanted = result.data["total_order"].sel(output="spectral_abscissa").values
    assert bars[1]["y"] == pytest.approx(wanted.tolist())
    assert shown.ring("0,1", "indices of spectral_abscissa") is None
    save(result, tmp_path / "study.nc")
    assert opened(tmp_path).study is not None
    text = page_of(result)
    content = gzip.decompress(base64.b64decode(re.search(r'page-data">([^<]+)', text)[1]))
    found = json.loads(content)
    assert "64 trains of 64; unstable" in found["headline"]
    [mean] = [each for each in found["rows"] if each["name"] == "growth rate α, mean"]
    rates = result.data["spectral_abscissa"].values
    assert float(mean["value"]) == pytest.approx(rates.mean(), abs=float(mean["error"]))
    nothing = collect_sample(study, replace(made_up(study), records={}))
    with pytest.raises(CaseError, match="none of its cases has a steady train"):
        page_of(nothing)
