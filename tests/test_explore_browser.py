"""The explorer and pages of one file in a real browser, where there is one.

Times from a change to the picture are printed: run with `-s` to see them.
"""

# ruff: noqa: E402
import json
import re
import shutil
import threading
import time
from collections.abc import Iterator
from typing import Any

import pytest

pytest.importorskip("dash", reason="the explorer needs the extra `explore`")
pytest.importorskip("selenium", reason="selenium is not there")
CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
if CHROMIUM is None or DRIVER is None:
    pytest.skip("there is no browser: chromium and chromium-driver", allow_module_level=True)

from selenium.webdriver import Chrome
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.keys import Keys

from celltrain.explore.address import View
from celltrain.explore.app import make_app
from celltrain.explore.engine import Engine
from celltrain.explore.opened import Opened
from celltrain.explore.report import row
from celltrain.explore.server import serve
from celltrain.parameters import Train
from celltrain.stability import stability

FLAGS = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
    *("--disable-dev-shm-usage", "--window-size=1300,1300"),
    # WebGL without a graphics card.
    *("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
)
#: Small, so that also the converged answer is quick.
CASE = Train(diameter=6, packing=0.3, cells=3, degree=10)
PATIENCE = 40.0


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Chrome]:
    options = Options()
    options.binary_location = CHROMIUM
    for flag in (*FLAGS, f"--user-data-dir={tmp_path_factory.mktemp('profile')}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = Chrome(options=options, service=Service(DRIVER))
    driver.set_script_timeout(PATIENCE)
    yield driver
    driver.quit()


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """The explorer, served by this process."""
    view = View(CASE)
    engine = Engine()
    engine.warm_up(view)
    served = serve(make_app(Opened(view), engine), port=0, query=view.address)
    thread = threading.Thread(target=served.server.serve_forever, daemon=True)
    thread.start()
    yield served.address
    served.server.shutdown()
    thread.join()


def wait_for(browser: Chrome, script: str, what: str) -> Any:
    """The value of a script once it is true."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        value = browser.execute_script(f"return {script}")
        if value:
            return value
        time.sleep(0.05)
    raise AssertionError(f"{what}: not within {PATIENCE:g} s")


def open_page(browser: Chrome, address: str) -> None:
    browser.get(address)
    converged(browser)


def converged(browser: Chrome) -> None:
    kind = "document.getElementById('status')?.dataset.kind"
    idle = "!window.celltrain?.explorer.busy"
    wait_for(browser, f"{kind} === 'converged' && {idle}", "a converged picture")


def shown_alpha(browser: Chrome) -> str:
    text: str = browser.execute_script("return document.querySelector('#cards .value').textContent")
    return text.replace("−", "-")


def move(browser: Chrome, name: str, key: str = Keys.ARROW_RIGHT) -> float:
    """Move a slider by a key; milliseconds until the train was drawn."""
    before = browser.execute_script("return document.body.dataset.answered")
    browser.find_element("id", f"slider-{name}").send_keys(key)
    wait_for(browser, f"document.body.dataset.answered !== '{before}'", "a picture")
    return float(browser.execute_script("return document.body.dataset.milliseconds"))


def complaints(browser: Chrome) -> list[str]:
    return [each["message"] for each in browser.get_log("browser") if each["level"] == "SEVERE"]


def hosts(browser: Chrome) -> set[str]:
    """Of all requests that pages have made."""
    found = set()
    for entry in browser.get_log("performance"):
        message = json.loads(entry["message"])["message"]
        if message["method"] != "Network.requestWillBeSent":
            continue
        if match := re.match(r"(?:https?|wss?)://([^/:]+)", message["params"]["request"]["url"]):
            found.add(match[1])
    return found


def test_a_page_loads_quietly_and_from_here_alone(browser: Chrome, address: str) -> None:
    open_page(browser, address)
    assert complaints(browser) == []
    assert hosts(browser) <= {"127.0.0.1"}


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


def test_a_field_takes_what_a_case_allows_and_tells_the_rest(browser: Chrome, address: str) -> None:
    open_page(browser, address)
    field = browser.find_element("id", "field-diameter")
    field.send_keys(Keys.CONTROL, "a")
    field.send_keys("-3", Keys.ENTER)
    message = "document.getElementById('message')"
    wait_for(browser, f"!{message}.hidden", "a message")
    assert "diameter = -3" in browser.execute_script(f"return {message}.textContent")
    assert field.get_attribute("aria-invalid") == "true"
    field.send_keys(Keys.CONTROL, "a")
    field.send_keys("6.4", Keys.ENTER)
    wait_for(browser, f"{message}.hidden", "a picture again")
    assert "diameter=6.4" in wait_for(browser, "celltrain.explorer.case", "a case")


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
