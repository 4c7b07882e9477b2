"""A headless Chromium for tests and for the pictures of the documentation."""

import json
import re
import shutil
import time
from pathlib import Path
from typing import Any

from selenium.webdriver import Chrome
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service

FLAGS = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
    *("--disable-dev-shm-usage", "--hide-scrollbars"),
    # WebGL without a graphics card.
    *("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
)
#: Seconds that a page may take for anything, on a machine that does other things as well.
PATIENCE = 90.0


def there_is_one() -> bool:
    """Whether Chromium and its driver are installed."""
    return all(shutil.which(name) for name in ("chromium", "chromedriver"))


def open_browser(profile: Path, *, width: int = 1200, height: int = 1000) -> Chrome:
    """A browser with an empty profile folder."""
    options = Options()
    options.binary_location = str(shutil.which("chromium"))
    for flag in (*FLAGS, f"--user-data-dir={profile}", f"--window-size={width},{height}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = Chrome(options=options, service=Service(shutil.which("chromedriver")))
    driver.set_script_timeout(PATIENCE)
    return driver


def wait_for(browser: Chrome, script: str, what: str) -> Any:
    """The value of a script once it is true."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        value = browser.execute_script(f"return {script}")
        if value:
            return value
        time.sleep(0.05)
    raise AssertionError(f"{what}: not within {PATIENCE:g} s")


def converged(browser: Chrome) -> None:
    """Wait until the explorer has computed and drawn all that it will."""
    kind = "document.getElementById('status')?.dataset.kind"
    idle = "!celltrain.explorer.busy && !celltrain.explorer.figures"
    wait_for(browser, f"{kind} === 'converged' && {idle}", "a converged picture")


def complaints(browser: Chrome) -> list[str]:
    """Errors on the console."""
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
