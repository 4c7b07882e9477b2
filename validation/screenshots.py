"""Pictures of the explorer and of a page of one file, for the documentation.

    python validation/screenshots.py [NAME ...] [--study FOLDER] [--simulation FILE.nc]

Writes docs/images/NAME.png: explore-train, explore-mode, explore-study, explore-simulation, page;
all of them unless named. The study and the simulation are computed if they are not given, which
takes a minute and half an hour. Needs Chromium and its driver.
"""

import argparse
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

HERE = Path(__file__).resolve().parent
IMAGES = HERE.parent / "docs" / "images"
sys.path.insert(0, str(HERE.parent / "tests"))

from browser import converged, open_browser, wait_for  # noqa: E402
from PIL import Image  # noqa: E402
from selenium.webdriver import Chrome  # noqa: E402

from celltrain.contract import load  # noqa: E402
from celltrain.explore.app import make_app  # noqa: E402
from celltrain.explore.engine import Engine  # noqa: E402
from celltrain.explore.opened import opened  # noqa: E402
from celltrain.explore.page import page_of  # noqa: E402
from celltrain.explore.server import serve  # noqa: E402

STUDY = """
title = "growth rate over diameter and packing"
[case]
cells = 8
degree = 12
[axes]
diameter = {from = 3.5, to = 8, points = 7}
packing = {from = 0.1, to = 0.6, points = 6}
[compute]
estimate_error = false
azimuthal_numbers = [0, 1, 2]
start = "neighbour"
"""
SIMULATION = (
    *("--diameter", "3.6", "--packing", "0.35", "--cells", "8", "--degree", "8"),
    *("--amplitude", "0.6", "--until", "60", "--every", "0.5"),
)
PLAYER = "celltrain.explorer.player"
#: Width and height of each picture, CSS pixels.
SIZES = {
    "explore-train": (1360, 1440),
    "explore-mode": (1360, 1010),
    "explore-study": (1360, 1010),
    "explore-simulation": (1360, 920),
    "page": (1180, 900),
}


@contextmanager
def explorer(path: Path | None) -> Iterator[str]:
    """The explorer of a file or folder, served while this lasts: its address."""
    what = opened(path)
    engine = Engine(what.start)
    engine.warm_up(what.view)
    served = serve(make_app(what, engine), port=0, query=what.view.address)
    thread = threading.Thread(target=served.server.serve_forever, daemon=True)
    thread.start()
    yield served.address
    served.server.shutdown()
    thread.join()


def shoot(browser: Chrome, name: str) -> None:
    time.sleep(2.0)
    path = IMAGES / f"{name}.png"
    browser.save_screenshot(str(path))
    with Image.open(path) as picture:
        picture.convert("RGB").save(path, optimize=True)
    print(path, f"{path.stat().st_size / 1000:.0f} kB")


def take(name: str, study: Path, simulation: Path, scratch: Path) -> None:
    browser = open_browser(scratch / f"profile-{name}", width=SIZES[name][0], height=SIZES[name][1])
    metrics = {"width": SIZES[name][0], "height": SIZES[name][1]}
    browser.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride", {**metrics, "deviceScaleFactor": 1, "mobile": False}
    )
    try:
        if name == "page":
            file = scratch / "page.html"
            file.write_text(page_of(load(simulation)), encoding="utf-8")
            browser.get(file.as_uri())
            ready = "document.getElementById('status')?.dataset.kind === 'ready'"
            wait_for(browser, ready, "the page")
            browser.execute_script(
                "const {player} = celltrain.page; player.set({frame: player.film.frames - 1})"
            )
            shoot(browser, name)
            return
        files = {"explore-study": study, "explore-simulation": simulation}
        with explorer(files.get(name)) as address:
            extra = "&mode=1,1,0&amplitude=0.6&phase=0" if name == "explore-mode" else ""
            browser.get(address + extra)
            converged(browser)
            if name == "explore-study":
                click = "celltrain.explorer.clickedMap({points: [{customdata: '3,1'}]})"
                browser.execute_script(click)
                wait_for(browser, "celltrain.explorer.case.includes('packing=0.2')", "the case")
                converged(browser)
            if name == "explore-simulation":
                wait_for(browser, f"Boolean({PLAYER}.film)", "the film")
                last = f"{PLAYER}.set({{frame: {PLAYER}.film.frames - 1}})"
                browser.execute_script(last)
            wait_for(browser, "document.body.dataset.curves === 'converged'", "the curves")
            shoot(browser, name)
    finally:
        browser.quit()


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--study", type=Path)
    parser.add_argument("--simulation", type=Path)
    given = parser.parse_args()
    names = given.names or list(SIZES)
    if unknown := set(names) - set(SIZES):
        parser.error(f"unknown: {', '.join(sorted(unknown))}; allowed: {', '.join(SIZES)}")
    IMAGES.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        scratch = Path(folder)
        command = [str(Path(sys.executable).with_name("celltrain"))]
        study, simulation = given.study, given.simulation
        if study is None and "explore-study" in names:
            study = scratch / "study"
            (scratch / "study.toml").write_text(STUDY, encoding="utf-8")
            subprocess.run([*command, "sweep", f"{study}.toml", "-o", study], check=True)
        if simulation is None and {"explore-simulation", "page"} & set(names):
            simulation = scratch / "simulation.nc"
            subprocess.run([*command, "evolve", *SIMULATION, "-o", simulation], check=True)
        for name in names:
            take(name, study, simulation, scratch)


if __name__ == "__main__":
    main()
