"""The explorer without a browser: addresses, controls, figures, films, guards, messages."""

import json
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Event

import numpy as np
import pytest

pytest.importorskip("dash", reason="the explorer needs the extra `explore`")

from celltrain.cli import main
from celltrain.explore.address import USUAL, View, view_of
from celltrain.explore.app import make_app
from celltrain.explore.changes import control_panel, view_after
from celltrain.explore.controls import changed, controls
from celltrain.explore.curves import growth_curves
from celltrain.explore.drawing import LEADING, mode_drawing, mode_key, train_drawing
from celltrain.explore.engine import Engine, Picture, Superseded
from celltrain.explore.figures import dispersion_figure, growth_figure, spectrum_figures
from celltrain.explore.film import packed, rounding_error, unpacked
from celltrain.explore.opened import Opened, opened
from celltrain.explore.page import page_of
from celltrain.explore.reading import Reading
from celltrain.explore.report import report, row
from celltrain.explore.server import guarded, is_loopback
from celltrain.parameters import CaseError, Train
from celltrain.results import save
from celltrain.stability import InfiniteTrain, Stability, infinite_train, transient_growth
from celltrain.steady import Base

PLAIN = Reading("dimensionless", USUAL.scales)


@pytest.mark.parametrize(
    "view",
    [
        View(USUAL),
        View(USUAL, "SI", infinite=True),
        View(Train(diameter=5.123456789012345, packing=0.3, cells=3, degree=16)),
        View(Train(diameter=6, packing=0.2, capillary_number=1 / 3, viscosity_ratio=5.0)),
        View(Train(diameter=6, packing=0.2, reference="spheroid", aspect_ratio=0.7)),
        View(Train.from_si(diameter=17e-6, packing=0.2, radius=3e-6, mean_velocity=1e-3), "SI"),
    ],
)
def test_an_address_is_the_state(view: View) -> None:
    again = view_of(view.address + "&mode=1,0,0&amplitude=0.2&token=abc")
    assert again == view


def test_the_profile_of_the_opened_case_stays() -> None:
    angles = np.linspace(0.0, np.pi, 30)
    points = [(np.sin(a), np.cos(a)) for a in angles]
    points[0], points[-1] = (0.0, 1.0), (0.0, -1.0)
    train = Train(diameter=6, packing=0.2, reference="profile", profile=points)
    view = View(train)
    assert "profile=" not in view.address
    assert view_of(view.address, train) == view


@pytest.mark.parametrize(
    ("address", "words"),
    [
        ("diameter=wide&packing=0.2", "diameter = 'wide' is not allowed; allowed: a number"),
        ("diameter=6&packing=0.2&cels=8", "unknown name 'cels'"),
        ("diameter=6&packing=0.2&cells=0", "cells = 0 is not allowed; allowed: a whole number"),
        ("diameter=6&packing=0.2&units=cm", "units = 'cm' is not allowed"),
    ],
)
def test_what_an_address_may_not_say(address: str, words: str) -> None:
    with pytest.raises(CaseError, match=words.replace(".", r"\.")):
        view_of(address)


@pytest.mark.parametrize("units", ["dimensionless", "SI"])
def test_sliders_and_fields_read_each_other(units: str) -> None:
    view = View(Train(diameter=5.5, packing=0.31, cells=5, viscosity_ratio=3.0), units)
    for control in controls(view.units):
        low, high = control.range(view.units)
        assert control.place(low, view.units) == 0.0
        assert control.place(high, view.units) == 1.0
        place = 0.37
        moved = view_after(view, {"places": {control.name: place}}, Opened(view))
        shown = {each["name"]: each for each in control_panel(moved)["sliders"]}[control.name]
        assert shown["place"] == pytest.approx(place, abs=0.01)
        typed = view_after(view, {"values": {control.name: shown["text"]}}, Opened(view))
        value, wanted = (control.value(each.train, units) for each in (typed, moved))
        assert value == pytest.approx(wanted, rel=1e-3)


def test_a_capillary_number_moves_the_moduli_and_a_velocity_their_unit() -> None:
    strong = changed(USUAL, {"capillary_number": 2.0}, "dimensionless")
    assert strong == USUAL.changed(capillary_number=2.0)
    fast = changed(USUAL, {"mean_velocity": strong.scales.mean_velocity}, "SI")
    assert fast.cell.shear_modulus == pytest.approx(0.5)
    assert fast.leaves("SI")["shear_modulus"] == pytest.approx(4.2e-6)
    assert fast.tube.diameter == USUAL.tube.diameter


def test_bad_values_get_the_messages_of_the_command_line(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["stability", "--diameter", "-1", "--packing", "0.2"]) == 2
    message = capsys.readouterr().err.strip().removeprefix("celltrain: ")
    app = make_app(Opened(View(USUAL)), Engine())
    shown = _asked(app, {"values": {"diameter": "-1"}, "address": ""})
    assert shown["message"] == message
    assert shown["wrong"] == ["diameter"]


def _asked(app: object, change: dict[str, object]) -> dict[str, object]:
    """What the server answers to a change, as the page asks it."""
    body = {
        "output": "shown.data",
        "outputs": {"id": "shown", "property": "data"},
        "inputs": [{"id": "change", "property": "data", "value": change}],
        "state": [
            {"id": "shown", "property": "data", "value": None},
            {"id": "asked-mode", "property": "data", "value": LEADING},
            {"id": "page", "property": "data", "value": "test"},
        ],
        "changedPropIds": ["change.data"],
    }
    client = app.server.test_client()  # type: ignore[attr-defined]
    answer = client.post("/_dash-update-component", json=body)
    assert answer.status_code == 200, answer.data
    return answer.get_json()["response"]["shown"]["data"]


def test_a_coarse_answer_is_that_of_its_degree_and_follows_neighbours() -> None:
    case = Train(diameter=6, packing=0.3, cells=3, degree=8)
    engine = Engine()
    first = engine.coarse(View(case))
    assert engine.coarse(View(case, "SI")).result is first.result
    near = engine.coarse(View(case.changed(diameter=6.1)))
    assert not near.converged
    assert "from rest" not in near.base.origin
    shown = report(near, PLAIN)
    assert shown["degree"] == 8
    words = {each["name"]: each["value"] for each in shown["rows"]}
    assert words["form"] == near.base.form
    [alpha] = [each for each in shown["rows"] if each["name"] == "growth rate α"]
    assert float(alpha["value"]) == pytest.approx(near.result.spectral_abscissa, rel=1e-5)


def test_a_computation_nobody_waits_for_is_given_up() -> None:
    engine = Engine()
    number = engine.ask("page")
    check = engine.check("page", number)
    check()
    engine.ask("another page")
    check()
    engine.ask("page")
    with pytest.raises(Superseded):
        engine.converged(View(Train(diameter=6, packing=0.3, cells=3)), check)
    with pytest.raises(Superseded):
        engine.rest("page", number)
    with pytest.raises(Superseded):
        engine.coarse(View(Train(diameter=6, packing=0.3, cells=3)), check)


def test_pages_that_ask_for_the_same_wait_for_one_computation(
    coarse_stability: Stability, monkeypatch: pytest.MonkeyPatch
) -> None:
    picture = Picture(View(coarse_stability.base.train), True, coarse_stability)
    engine, begun, go_on = Engine(), Event(), Event()
    computations: list[int] = []
    found = object.__new__(InfiniteTrain)

    def waves(*_: object, **__: object) -> InfiniteTrain:
        computations.append(1)
        begun.set()
        go_on.wait()
        if len(computations) == 1:
            raise Superseded
        return found

    monkeypatch.setattr("celltrain.explore.engine.infinite_train", waves)
    monkeypatch.setattr("celltrain.explore.engine.growth_curves", lambda *_, **__: None)
    with ThreadPoolExecutor(3) as pages:
        first = pages.submit(engine.curves, picture, lambda: None)
        begun.wait()
        others = [pages.submit(engine.curves, picture, lambda: None) for _ in range(2)]
        go_on.set()
        with pytest.raises(Superseded):
            first.result()
        assert all(each.result().waves is found for each in others)
    assert engine.curves(picture, lambda: None).waves is found
    assert len(computations) == 2


def test_what_is_given_up_takes_no_result_away() -> None:
    engine = Engine()
    case = Train(diameter=6, packing=0.3, cells=3, degree=8)
    first = engine.coarse(View(case))

    def check() -> None:
        raise Superseded

    for diameter in (6.1, 6.2, 6.3, 6.4):
        with pytest.raises(Superseded):
            engine.coarse(View(case.changed(diameter=diameter)), check)
    assert engine.coarse(View(case)).result is first.result


def test_growth_by_squares_is_growth_by_exponentials(coarse_stability: Stability) -> None:
    found = growth_curves(coarse_stability, until=8.0, check=lambda: None)
    wanted = transient_growth(coarse_stability, until=8.0, samples=40)
    inside = found.times > 0.0
    there = np.exp(
        np.interp(np.log(found.times[inside]), np.log(wanted.times[1:]), np.log(wanted.growth[1:]))
    )
    np.testing.assert_allclose(found.largest[inside], there, rtol=2e-3)
    assert found.largest[-1] == pytest.approx(wanted.growth[-1], rel=1e-9)
    rough = growth_curves(coarse_stability, until=8.0, check=lambda: None, fine=False)
    np.testing.assert_array_equal(found.times[1::2], rough.times[1:])
    np.testing.assert_allclose(found.largest[1::2], rough.largest[1:], rtol=1e-12)
    assert found.numerical_abscissa == pytest.approx(wanted.numerical_abscissa)


def test_figures_hold_the_numbers(coarse_stability: Stability) -> None:
    result = coarse_stability
    mode = mode_drawing(result, LEADING, PLAIN)
    assert mode is not None
    whole, close = spectrum_figures(result, PLAIN, mode)
    x = np.concatenate([trace["x"] for trace in whole["data"][1:]])
    assert len(x) == 2 * len(result.modes)
    assert x.max() == pytest.approx(max(m.growth_rate for m in result.modes), rel=1e-4)
    keys = {key for trace in close["data"][1:] for key in trace["customdata"]}
    assert mode_key(result.leading) in keys
    assert whole["data"][0]["x"] == [mode["place"][0]] * 2
    si = Reading("SI", result.base.train.scales)
    faster = spectrum_figures(result, si)[0]
    ratio = np.max(faster["data"][1]["x"]) / np.max(whole["data"][1]["x"])
    assert ratio == pytest.approx(1.0 / result.base.train.scales.time, rel=1e-4)
    waves = infinite_train(
        result.base,
        phases=[0.0, 1.0, 2.0],
        azimuthal_numbers=(0, 1),
        estimate_error=False,
        search=False,
    )
    drawn = dispersion_figure(waves, PLAIN)
    assert len(drawn["data"]) == 3
    growth = growth_figure(
        growth_curves(result, until=5.0, check=lambda: None), result.spectral_abscissa, PLAIN
    )
    json.dumps([whole, close, drawn, growth], allow_nan=False)


@pytest.mark.parametrize(
    ("value", "error", "shown"),
    [(0.0138203, 9e-5, "0.013820"), (1.7754927, 2e-5, "1.775493"), (3.8826, np.nan, "3.8826")],
)
def test_numbers_have_the_digits_that_their_error_leaves(
    value: float, error: float, shown: str
) -> None:
    assert row("", value, error, "")["value"] == shown


def test_a_film_is_what_was_computed() -> None:
    random = np.random.default_rng(1)
    steps = 0.01 * random.normal(size=(40, 3, 3, 36))
    shapes = np.cumsum(steps, axis=0)
    shapes[..., 2, 0] += 40.0 * np.arange(40)[:, None]
    step, text = packed(shapes, 10**6)
    again = unpacked(text, step, shapes.shape)
    assert np.abs(again - shapes).max() <= 0.51 * step
    coarser, shorter = packed(shapes, len(text) // 2)
    assert len(shorter) <= len(text) // 2
    assert coarser > step
    assert rounding_error(shapes, coarser) > rounding_error(shapes, step) > 0.0


def test_what_can_be_opened(tmp_path: Path, coarse_base: Base) -> None:
    case = tmp_path / "case.toml"
    case.write_text('units = "SI"\n[tube]\ndiameter = 17e-6\n[train]\npacking = 0.2\n')
    assert opened(case).view.units == "SI"
    assert opened(None).view.train == USUAL
    file = tmp_path / "base.nc"
    save(coarse_base, file)
    found = opened(file)
    assert found.start == coarse_base
    assert found.view.train == coarse_base.train
    for bad, words in (
        (tmp_path, "there is no study.nc in it"),
        (tmp_path / "no.nc", "there is no such file"),
        (tmp_path / "no.toml", "cannot be read"),
    ):
        with pytest.raises(CaseError, match=words):
            opened(bad)
    case.write_text("[axes]\ndiameter = [6, 7]\n")
    with pytest.raises(CaseError, match="celltrain sweep"):
        opened(case)


@pytest.mark.parametrize(
    ("host", "alone"),
    [
        ("127.0.0.1", True),
        ("localhost", True),
        ("::1", True),
        ("0.0.0.0", False),
        ("example", False),
    ],
)
def test_who_is_this_machine(host: str, alone: bool) -> None:
    assert is_loopback(host) == alone


def test_others_need_the_token() -> None:
    app = make_app(Opened(View(USUAL)), Engine())
    token = guarded(app, "0.0.0.0", None)
    assert token is not None
    client = app.server.test_client()
    assert client.get("/").status_code == 403
    assert client.get("/?token=wrong").status_code == 403
    assert client.get(f"/?token={token}").status_code == 200
    # From here on the browser has it in a cookie.
    assert client.get("/_dash-layout").status_code == 200


def test_no_other_site_may_ask_in_the_users_name() -> None:
    app = make_app(Opened(View(USUAL)), Engine())
    assert guarded(app, "127.0.0.1", None) is None
    client = app.server.test_client()
    assert client.get("/", headers={"Host": "127.0.0.1:8157"}).status_code == 200
    assert client.get("/", headers={"Host": "elsewhere.example:8157"}).status_code == 403


def test_what_is_saved_is_what_the_command_line_reads(tmp_path: Path, coarse_base: Base) -> None:
    app = make_app(Opened(View(USUAL)), Engine())
    client = app.server.test_client()
    answer = client.get("/save/celltrain.toml?diameter=5.5&packing=0.3&cells=4")
    file = tmp_path / "case.toml"
    file.write_bytes(answer.data)
    assert opened(file).view.train == Train(diameter=5.5, packing=0.3, cells=4)
    assert client.get("/save/celltrain.toml?diameter=0").status_code == 400


def test_a_missing_extra_is_named(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("celltrain.extras.find_spec", lambda name: None)
    assert main(["explore", "--no-browser"]) == 2
    [line] = capsys.readouterr().err.strip().splitlines()
    assert line.endswith("pip install 'celltrain[explore]'")


@pytest.mark.parametrize(
    ("option", "words"), [(["--port", "70000"], "65535"), (["--port", "x"], "a whole number")]
)
def test_bad_options_of_the_explorer(
    option: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["explore", "--no-browser", *option]) == 2
    assert words in capsys.readouterr().err


def test_a_page_holds_everything(make_stability: Callable[..., Stability]) -> None:
    text = page_of(make_stability())
    assert len(text) < 3_000_000
    assert "@@" not in text.split("<script", maxsplit=1)[0]
    for tag in ("src=", '<link rel="stylesheet', "@import", "url("):
        assert tag not in text.split('id="plotly-data"', maxsplit=1)[0]


def test_pictures_know_their_train(coarse_stability: Stability) -> None:
    picture = Picture(View(coarse_stability.base.train), True, coarse_stability)
    drawn = train_drawing(picture.base)
    assert drawn["cells"] == 3
    np.testing.assert_array_equal(drawn["profile"], picture.base.profile)
