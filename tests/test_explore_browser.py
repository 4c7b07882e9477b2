"""The explorer and pages of one file in a real browser, where there is one.

Times from a change to the picture are printed: run with `-s` to see them.
"""

import json
import re
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("dash", reason="the explorer needs the extra `explore`")
pytest.importorskip("selenium", reason="selenium is not there")

from browser import complaints, converged, hosts, open_browser, there_is_one, wait_for
from samples import CELLS, made_up
from selenium.webdriver import Chrome
from selenium.webdriver.common.keys import Keys

from celltrain.explore.address import View
from celltrain.explore.app import make_app
from celltrain.explore.engine import Engine
from celltrain.explore.film import film_of
from celltrain.explore.opened import Opened
from celltrain.explore.overview import overview_of
from celltrain.explore.page import assembled, page_of, train_content
from celltrain.explore.report import row
from celltrain.explore.server import serve
from celltrain.harmonics import (
    azimuthal_basis,
    coefficients_of,
    degrees_and_orders,
    real_harmonics,
)
from celltrain.parameters import Train
from celltrain.stability import Stability, stability
from celltrain.steady import Base
from celltrain.study import collect_sample, make_sampled_study

# `.ci/run` installs one; for who has none, all else must pass.
pytestmark = pytest.mark.skipif(
    not there_is_one(), reason="there is no browser: chromium and chromium-driver"
)
#: Small, so that also the converged answer is quick.
CASE = Train(diameter=6, packing=0.3, cells=3, degree=10)

#: The largest growth rate among the points of the drawn spectrum.
_LARGEST = (
    "Math.max(...(document.querySelector('#spectrum-close .js-plotly-plot')?.data || [])"
    ".filter((trace) => trace.customdata).flatMap((trace) => Array.from(trace.x)))"
)


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Chrome]:
    # Small: without a graphics card, drawing is most of the time.
    driver = open_browser(tmp_path_factory.mktemp("profile"), width=700, height=500)
    yield driver
    driver.quit()


@contextmanager
def served(what: Opened) -> Iterator[str]:
    """The explorer, served by this process: its address."""
    engine = Engine()
    engine.warm_up(what.view)
    server = serve(make_app(what, engine), port=0, query=what.view.address)
    thread = threading.Thread(target=server.server.serve_forever, daemon=True)
    thread.start()
    yield server.address
    server.server.shutdown()
    thread.join()


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    with served(Opened(View(CASE))) as address:
        yield address


def open_page(browser: Chrome, address: str) -> None:
    browser.get(address)
    converged(browser)


def shown_alpha(browser: Chrome) -> str:
    text: str = browser.execute_script("return document.querySelector('#cards .value').textContent")
    return text.replace("−", "-")


def move(browser: Chrome, name: str, key: str = Keys.ARROW_RIGHT) -> float:
    """Move a slider by a key; milliseconds until the train was drawn."""
    before = browser.execute_script("return document.body.dataset.answered")
    browser.find_element("id", f"slider-{name}").send_keys(key)
    wait_for(browser, f"document.body.dataset.answered !== '{before}'", "a picture")
    return float(browser.execute_script("return document.body.dataset.milliseconds"))


def test_a_page_loads_quietly_and_from_here_alone(browser: Chrome, address: str) -> None:
    open_page(browser, address)
    assert complaints(browser) == []
    assert hosts(browser) <= {"127.0.0.1"}


@pytest.mark.slow
def test_a_slider_moves_alpha_to_what_the_command_line_gives(browser: Chrome, address: str) -> None:
    open_page(browser, address)
    before = shown_alpha(browser)
    waits = [move(browser, "diameter") for _ in range(5)]
    print(f"\nslider to picture, degree {CASE.degree}: {sorted(waits)} ms")
    converged(browser)
    case = browser.execute_script("return celltrain.explorer.case")
    diameter = float(re.search(r"diameter=([\d.]+)", case)[1])
    assert diameter != CASE.tube.diameter
    wanted = stability(CASE.changed(diameter=diameter))
    shown = row("", wanted.spectral_abscissa, wanted.error_estimate, "")
    assert shown_alpha(browser) == shown["value"]
    assert shown_alpha(browser) != before


def test_the_train_is_drawn_first_and_its_spectrum_follows(browser: Chrome, address: str) -> None:
    open_page(browser, address)
    before = wait_for(browser, _LARGEST, "the spectrum")
    browser.execute_script(
        """
        window.order = [];
        const props = dash_clientside.set_props;
        dash_clientside.set_props = (name, given) => {
          if (given.figure) window.order.push(name);
          props(name, given);
        };
        celltrain.explorer.player.canvas.addEventListener("drawn", () => order.push("train"));
        """
    )
    move(browser, "diameter")
    wait_for(browser, "window.order.length >= 3", "the spectra")
    assert browser.execute_script("return order.slice(0, 3)") == [
        "train",
        "spectrum-all",
        "spectrum-close",
    ]
    converged(browser)
    wait_for(browser, f"{_LARGEST} !== {before}", "the new spectrum")


def test_a_field_takes_what_a_case_allows_and_tells_the_rest(browser: Chrome, address: str) -> None:
    open_page(browser, address)
    field = browser.find_element("id", "field-diameter")
    field.send_keys(Keys.CONTROL, "a")
    field.send_keys("-3", Keys.ENTER)
    message = "document.getElementById('message')"
    wait_for(browser, f"!{message}.hidden", "a message")
    assert "diameter = -3" in browser.execute_script(f"return {message}.textContent")
    assert field.get_attribute("aria-invalid") == "true"
    # A train that is sought for minutes, and in vain, is given up for the next one.
    dense = browser.find_element("id", "field-packing")
    dense.send_keys(Keys.CONTROL, "a")
    dense.send_keys("1.9", Keys.ENTER)
    wait_for(browser, "celltrain.explorer.busy", "that it is sought")
    dense.send_keys(Keys.CONTROL, "a")
    dense.send_keys("0.3", Keys.ENTER)
    field.send_keys(Keys.CONTROL, "a")
    field.send_keys("6.4", Keys.ENTER)
    wait_for(browser, f"{message}.hidden", "a picture again")
    assert "diameter=6.4" in wait_for(browser, "celltrain.explorer.case", "a case")


@pytest.mark.slow
def test_a_click_on_an_eigenvalue_plays_its_mode(browser: Chrome, address: str) -> None:
    open_page(browser, address)
    _click_leading(browser)
    wait_for(browser, "celltrain.explorer.player.state.show === 'mode'", "a mode")
    wait_for(browser, "celltrain.explorer.player.state.playing", "that it plays")
    first = browser.execute_script("return celltrain.explorer.player.stage.draws")
    wait_for(browser, f"celltrain.explorer.player.stage.draws > {first + 2}", "pictures of it")
    caption = browser.execute_script("return document.querySelector('.caption').textContent")
    assert "growth rate" in caption
    browser.find_element("css selector", ".player button.play").click()
    wait_for(browser, "location.search.includes('mode=')", "the mode in the address")
    assert complaints(browser) == []


@pytest.mark.slow
def test_arrow_keys_go_from_mode_to_mode(browser: Chrome, address: str) -> None:
    open_page(browser, address)
    wait_for(browser, _LARGEST, "the spectrum")
    spectrum = browser.find_element("css selector", '.graph[aria-label^="Near"]')
    spectrum.send_keys(Keys.ARROW_LEFT)
    key = "celltrain.explorer.player.mode?.key"
    first = wait_for(browser, key, "a mode")
    growth = "celltrain.explorer.player.mode.place[0]"
    assert browser.execute_script(f"return {growth}") == pytest.approx(
        browser.execute_script(f"return {_LARGEST}"), rel=1e-4
    )
    spectrum.send_keys(Keys.ARROW_LEFT)
    wait_for(browser, f"{key} !== '{first}'", "the next mode")
    assert browser.execute_script(f"return {growth}") < browser.execute_script(f"return {_LARGEST}")
    assert complaints(browser) == []


def test_the_address_reproduces_the_state(browser: Chrome, address: str) -> None:
    changed = address.replace("diameter=6.0", "diameter=6.25")
    open_page(browser, f"{changed}&units=SI&mode=1,0,0&amplitude=0.21&phase=90")
    wait_for(browser, "celltrain.explorer.player.state.show === 'mode'", "a mode")
    wait_for(browser, "location.search.includes('amplitude=0.21')", "the address")
    state = browser.execute_script("return celltrain.explorer.player.state")
    assert (state["amplitude"], state["phase"]) == (0.21, 90)
    assert not state["playing"]
    field = browser.find_element("id", "field-diameter")
    assert float(field.get_attribute("value")) == pytest.approx(6.25 * 2.8, abs=0.01)
    search = browser.execute_script("return location.search")
    alpha = shown_alpha(browser)
    open_page(browser, address.split("?")[0] + search)
    wait_for(browser, "celltrain.explorer.player.state.show === 'mode'", "a mode")
    assert shown_alpha(browser) == alpha
    wait_for(browser, f"location.search === {json.dumps(search)}", "the same address")


@pytest.mark.slow
def test_the_ring_is_around_the_train_that_is_shown(
    browser: Chrome, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("celltrain.study.sampling.statistics.RESAMPLES", 20)
    study = make_sampled_study(CELLS)
    shown = overview_of(collect_sample(study, made_up(study)))
    plot = "document.querySelector('#map .js-plotly-plot')"
    ring = f"({plot}?.data?.at(-1).marker?.size === 17 ? {plot}.data.at(-1).x[0] : undefined)"
    values = study.points[3][1].values

    def choose(name: str) -> None:
        number = list(shown.names).index(f"over {name}")
        browser.find_elements("css selector", ".choice input")[number].click()

    with served(Opened(View(shown.first), study=shown)) as address:
        open_page(browser, address)
        choose("shear_modulus")
        wait_for(browser, f"{plot}?.data?.length === 2", "dots")
        browser.execute_script("celltrain.explorer.clickedMap({points: [{customdata: '1,3'}]})")
        wait_for(browser, f"{ring} === {values['shear_modulus']!r}", "a ring")
        choose("viscosity_ratio")
        wait_for(browser, f"{ring} === {values['viscosity_ratio']!r}", "a ring in another figure")
        converged(browser)
        browser.refresh()
        converged(browser)
        choose("viscosity_ratio")
        wait_for(browser, f"{ring} === {values['viscosity_ratio']!r}", "a ring again")
        browser.find_element("css selector", ".graph.map").send_keys(Keys.ARROW_RIGHT)
        wait_for(browser, f"{ring} > {values['viscosity_ratio']!r}", "a ring around the next dot")
        move(browser, "diameter")
        wait_for(browser, f"{plot}.data.at(-1).x.length === 0", "no ring around another train")
        assert complaints(browser) == []


@pytest.mark.slow
def test_twenty_changes_leave_memory_where_it_was(browser: Chrome, address: str) -> None:
    open_page(browser, address)

    def heap() -> float:
        browser.execute_cdp_cmd("HeapProfiler.collectGarbage", {})
        return float(browser.execute_cdp_cmd("Runtime.getHeapUsage", {})["usedSize"]) / 2**20

    keys = [Keys.ARROW_RIGHT, Keys.ARROW_LEFT]
    for number in range(4):
        move(browser, "packing", keys[number % 2])
    before = heap()
    for number in range(20):
        move(browser, "packing", keys[number % 2])
    after = heap()
    print(f"\nmemory of the page: {before:.1f} MiB, after 20 changes {after:.1f} MiB")
    assert after < before + 5.0


def test_the_browser_evaluates_the_same_shapes(browser: Chrome, address: str) -> None:
    """Harmonics in the browser's script against those of the package."""
    browser.get(address)
    wait_for(browser, "Boolean(window.celltrain?.Grid)", "the scripts")
    random, degree = np.random.default_rng(3), 7
    coefficients = random.normal(size=degree**2)
    vectors = [random.normal(size=len(azimuthal_basis(degree, m))) for m in range(4)]
    profile = random.normal(size=(2, degree))
    profile[1, 0] = 0.0
    result = browser.execute_script(
        """
        const [degree, coefficients, vectors, profile] = arguments;
        const grid = new celltrain.Grid(degree, 6, 8);
        const surface = new Float64Array(grid.size);
        grid.surface(coefficients, surface, 0);
        const points = [];
        grid.eachVertex((v, k, l) => points.push([grid.theta[k], grid.phi[l]]));
        const list = (points) => points.map((each) => Array.from(each));
        return {
          points,
          surface: Array.from(surface),
          moved: vectors.map((vector, m) => list(grid.displacement(vector, m))),
          rest: list(grid.axisymmetric(profile)),
        };
        """,
        degree,
        coefficients.tolist(),
        [each.tolist() for each in vectors],
        profile.tolist(),
    )
    theta, phi = np.array(result["points"]).T
    harmonics = real_harmonics(degree, theta, phi)
    np.testing.assert_allclose(result["surface"], harmonics @ coefficients, atol=1e-12)
    np.testing.assert_allclose(result["rest"], coefficients_of(profile) @ harmonics.T, atol=1e-12)
    for m, moved in enumerate(result["moved"]):
        shape = np.tensordot(vectors[m], azimuthal_basis(degree, m), axes=1)
        np.testing.assert_allclose(moved, shape @ harmonics.T, atol=1e-12)


@pytest.mark.slow
def test_one_file_plays_without_python_or_network(
    browser: Chrome, tmp_path: Path, coarse_stability: Stability
) -> None:
    file = tmp_path / "page.html"
    file.write_text(page_of(coarse_stability), encoding="utf-8")
    # The page before may still have been asking for something.
    browser.get("about:blank")
    hosts(browser)
    browser.get(file.as_uri())
    wait_for(browser, "document.getElementById('status').dataset.kind === 'ready'", "the page")
    player = "celltrain.page.player"
    wait_for(browser, f"{player}.state.playing && {player}.stage.draws > 3", "the leading mode")
    key = browser.execute_script("return Object.keys(celltrain.page.content.modes)[5]")
    browser.execute_script("celltrain.page.choose(arguments[0])", key)
    assert browser.execute_script(f"return {player}.mode.key") == key
    assert complaints(browser) == []
    assert hosts(browser) == set()


def test_a_film_of_eight_cells_and_500_frames_plays_and_is_small(
    browser: Chrome, tmp_path: Path, coarse_base: Base
) -> None:
    """As smooth as simulations are: every coefficient of degree 16 swings at a pace of its own."""
    train = coarse_base.train.changed(cells=8, degree=16)
    random, frames = np.random.default_rng(5), 500
    number, _ = degrees_and_orders(train.degree)
    profile = np.zeros((2, train.degree))
    profile[:, : train.resolution.degree] = np.pad(coarse_base.profile, ((0, 0), (0, 10)))
    rest = coefficients_of(profile)
    swing = 0.2 * np.exp(-0.5 * number) * random.normal(size=(8, 3, number.size))
    pace, phase = random.uniform(0.2, 2.0, swing.shape), random.uniform(0.0, 6.0, swing.shape)
    times = np.linspace(0.0, 100.0, frames)
    shapes = rest + swing * np.sin(pace * times[:, None, None, None] + phase)
    shapes[:, :, 2, 0] += np.sqrt(4.0 * np.pi) * train.period * np.arange(8)
    film = film_of(train, times, shapes, "complete")
    content = train_content(replace(coarse_base, train=train, coefficients=rest))
    file = tmp_path / "film.html"
    file.write_text(assembled({**content, "film": film}, "film"), encoding="utf-8")
    size = file.stat().st_size
    print(f"\npage of a film of 8 cells, degree 16, 500 frames: {size / 1e6:.2f} MB")
    assert size <= 10e6
    browser.get(file.as_uri())
    wait_for(browser, "Boolean(window.celltrain?.page?.player?.film)", "the film")
    found = browser.execute_script(
        "return Array.from(celltrain.page.player.film.coefficients(321, 5, 1))"
    )
    np.testing.assert_allclose(found, shapes[321, 5, 1], atol=0.51 * film["step"])
    browser.find_element("css selector", ".player button.play").click()
    wait_for(browser, "celltrain.page.player.state.frame > 20", "that it plays")
    assert complaints(browser) == []


def _click_leading(browser: Chrome) -> None:
    """Click on the eigenvalue that leads, with the mouse."""
    place = browser.execute_script(
        """
        const plot = document.querySelector('#spectrum-close .js-plotly-plot');
        plot.scrollIntoView({block: 'center'});
        let best = null;
        for (const trace of plot.data) {
          (trace.customdata || []).forEach((key, index) => {
            if (trace.name.includes('neutral')) return;
            if (!best || trace.x[index] > best.x) best = {x: trace.x[index], y: trace.y[index]};
          });
        }
        const {xaxis, yaxis} = plot._fullLayout;
        const box = plot.getBoundingClientRect();
        return [box.left + xaxis._offset + xaxis.d2p(best.x),
                box.top + yaxis._offset + yaxis.d2p(best.y)];
        """
    )
    x, y = place
    for kind in ("mouseMoved", "mousePressed", "mouseReleased"):
        browser.execute_cdp_cmd(
            "Input.dispatchMouseEvent",
            {"type": kind, "x": x, "y": y, "button": "left", "clickCount": 1},
        )
        time.sleep(0.1)
