"""The app in a real browser: a case is described, run, watched, stopped and resumed.

It needs Debian's `chromium` and `chromium-driver` and is skipped without them.  With ERTEL_SCREENSHOTS=DIR the pages
are kept as pictures for someone to look at.
"""

import json
import os
import re
import shutil
import time
from contextlib import suppress
from importlib.util import find_spec
from itertools import product
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from app_runs import make_run, served

from ertel.apps.browser.folder import Folder
from ertel.apps.browser.processes import Phase, Processes

pytest.importorskip("nicegui", reason="the app needs nicegui")
CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(find_spec("selenium") is None, reason="the browser is driven by selenium"),
    pytest.mark.skipif(not (CHROMIUM and DRIVER), reason="needs Debian's chromium and chromium-driver"),
    pytest.mark.skipif(not Path("/proc/self/smaps_rollup").exists(), reason="the memory is read from /proc"),
]
FLAGS = (
    "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
)  # fmt: skip
LAPTOP, TABLET, PHONE = (1280, 800), (820, 1180), (390, 844)
LARGEST, TOGETHER = 250, 300  # MB, of the web process at its peak, and of it with the one that draws (the aim: 250)
FIELD = """
const fields = [...document.querySelectorAll('.q-field')];
const labelled = fields.find(field => field.querySelector('.q-field__label')?.innerText === arguments[0]);
return labelled && labelled.offsetHeight ? labelled.querySelector('.q-field__control') : null;
"""
CHOOSE = """
const option = [...document.querySelectorAll('[role=option]')].find(each => each.innerText.includes(arguments[0]));
option?.click();
return Boolean(option);
"""


@pytest.fixture
def folder(tmp_path):
    """A folder with one finished run."""
    make_run(tmp_path / "folder" / "runs" / "before")
    return tmp_path / "folder"


@pytest.fixture
def server(folder):
    """The app as a process: the process, its address and its token."""
    with served(folder, "--no-browser") as (process, address):
        root, _, token = address.partition("/?token=")
        yield process, root, token


@pytest.fixture
def driver(tmp_path):
    """Chromium without a window."""
    from selenium import webdriver  # here: each worker imports this file

    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for flag in (*FLAGS, f"--user-data-dir={tmp_path / 'chromium'}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    found = webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))
    yield Page(found)
    found.quit()


class Page:
    """What a user does on a page and sees there."""

    def __init__(self, driver):
        self.driver = driver
        self.resize(LAPTOP)

    def resize(self, size):
        width, height = size
        screen = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)

    def look(self, scheme):
        """Let the system be "light" or "dark"."""
        feature = {"name": "prefers-color-scheme", "value": scheme}
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [feature]})

    def open(self, address):
        self.driver.get(address)

    def all(self, selector):
        return [element for element in self.driver.find_elements("css selector", selector) if element.is_displayed()]

    def text(self, selector):
        return " ".join(element.text for element in self.all(selector))

    def click(self, word):
        (button,) = self.until(
            lambda: [each for each in self.all("button, [role=tab]") if word in each.text and each.is_enabled()]
        )
        self.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", button)
        button.click()

    def fill(self, label, text):
        from selenium.webdriver import Keys

        (field,) = self.until(lambda: self.all(f"input[aria-label='{label}']"))
        field.click()
        field.send_keys(Keys.CONTROL, "a")
        field.send_keys(text)

    def choose(self, label, word):
        field = self.until(lambda: self.driver.execute_script(FIELD, label))
        self.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", field)
        field.click()
        self.until(lambda: self.driver.execute_script(CHOOSE, word))
        self.until(lambda: not self.driver.execute_script("return document.querySelectorAll('[role=option]').length"))
        time.sleep(1.0)  # the form is built again

    def type(self, text):
        """Write at the end of the case file, and wait for the answer to it."""
        (area,) = self.until(lambda: self.all("textarea"))
        before = self.text(".answer")
        area.send_keys(text)
        self.until(lambda: "roughly" in self.text(".answer") != before)

    def until(self, there, seconds=120):
        """Wait for something to become true; what is replaced while it is looked at is not there yet."""
        from selenium.common.exceptions import StaleElementReferenceException

        deadline, found = time.monotonic() + seconds, None
        while not found:
            with suppress(StaleElementReferenceException):
                if found := there():
                    break
            assert time.monotonic() < deadline, self.driver.find_element("tag name", "body").text
            time.sleep(0.1)
        return found

    def width(self):
        """That of all that the page has, in pixels."""
        return self.driver.execute_script("return document.documentElement.scrollWidth")

    def picture(self):
        """The address of the picture, when the last wish is drawn and the browser has it whole."""
        shown = [] if self.all(".canvas .waits") else self.all(".canvas img")
        whole = shown and self.driver.execute_script("return arguments[0].complete", shown[0])
        return shown[0].get_attribute("src") if whole else ""

    def keep(self, name):
        """Keep a picture of the page, where that is asked for."""
        if place := os.environ.get("ERTEL_SCREENSHOTS"):
            time.sleep(0.6)  # Quasar moves things into place
            Path(place).mkdir(parents=True, exist_ok=True)
            self.driver.save_screenshot(str(Path(place) / f"{name}.png"))

    def asked_hosts(self):
        """The hosts that the pages asked for anything."""
        events = [json.loads(entry["message"])["message"] for entry in self.driver.get_log("performance")]
        requests = [event["params"].get("request", event["params"]) for event in events if event["method"] in ASKED]
        parts = [urlsplit(request["url"]) for request in requests]
        return {part.netloc for part in parts if part.scheme in ("http", "https", "ws", "wss")}


FINE_STEPS = "step = 1e-3\n"  # of [time], the last section: a run that lasts long enough to be watched
PAGES = {
    "first-page": "/", "new-case": "/new", "run": "/run?name=runs/mine",
    "compare": "/compare?a=runs/mine&b=runs/before",
}  # fmt: skip
HEAVY = ("jaxlib", "matplotlib", "pandas", "scipy", "numcodecs")  # numcodecs: of zarr
ASKED = ("Network.requestWillBeSent", "Network.webSocketCreated")


def megabytes(process, file, entry):
    """An entry of a file in /proc.  Pss: the memory of a process, what it shares divided; VmHWM: the largest it had."""
    lines = Path(f"/proc/{process}/{file}").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith(f"{entry}:")) / 1024


def of_the_app(process):
    """The memory of the web process and of the largest that it started, which draws, in MB."""
    children = Path(f"/proc/{process}/task/{process}/children").read_text().split()
    own, *others = (megabytes(each, "smaps_rollup", "Pss") for each in (process, *children))
    return round(own), round(max(others))


def test_a_session(server, driver, folder):
    process, address, token = server
    page, runs = driver, Processes(Folder.at(folder))
    page.open(f"{address}/?token={token}")
    page.until(lambda: "Impact and rolling" in page.text(".welcome"))
    page.keep("first-page")

    page.click("New case")
    page.until(lambda: page.all("input[aria-label='Radius']"))
    page.fill("Radius", "10 mm")
    page.until(lambda: "roughly" in page.text(".answer"))
    page.keep("new-case")
    page.choose("Method", "radial")
    page.fill("Nodes", "513")
    page.until(lambda: "513 nodes along the radius" in page.text(".answer"))

    page.fill("Name of the run", "mine")
    page.click("Case file")
    page.type(FINE_STEPS)
    page.click("Run")
    run = folder / "runs" / "mine"
    page.until(lambda: "compiling" in page.text(".chip"))
    page.keep("compiling")
    page.until(lambda: "running" in page.text(".chip"))
    page.click("Stop")
    page.until(lambda: "interrupted" in page.text(".chip"))
    assert runs.status(run).phase is Phase.INTERRUPTED
    done = runs.status(run).done
    assert 0.0 < done < 1.0
    page.keep("interrupted")
    page.click("Resume")
    page.until(lambda: "finished" in page.text(".chip"), 600)  # minutes where other programs compute, too
    assert runs.status(run).phase is Phase.FINISHED

    first = page.until(page.picture)
    page.keep("finished")
    (track,) = page.all(".q-slider__track-container")
    from selenium.webdriver import ActionChains

    ActionChains(page.driver).move_to_element_with_offset(track, -200, 0).click().perform()
    page.until(lambda: page.picture() not in ("", first))
    (image,) = page.all(".canvas img")
    ActionChains(page.driver).move_to_element_with_offset(image, -image.size["width"] // 4, 0).perform()
    page.until(lambda: "h = " in page.text(".readout") and "p = " in page.text(".readout"))
    page.keep("under-the-pointer")
    sizes = (0, 0)
    for word in ("Mid-line", "Motion", "Front", "Friction", "Interferogram", "Overview"):
        before = page.until(page.picture)
        sizes = of_the_app(process.pid) if word == "Interferogram" else sizes
        page.click(word)
        page.until(lambda before=before: page.picture() not in ("", before))
        page.keep(f"run-{word.lower()}")

    page.open(f"{address}/compare?a=runs/mine&b=runs/before")
    page.until(lambda: len(page.all(".canvas img")) == 2)
    page.keep("compare")
    for size, look in product((TABLET, PHONE), ("light", "dark")):
        page.resize(size)
        page.look(look)
        for name, path in PAGES.items():
            page.open(address + path)
            page.until(lambda: page.picture() or "roughly" in page.text(".answer") or page.text(".welcome"))
            page.keep(f"{name}-{size[0]}-{look}")
            page.until(lambda size=size: page.width() <= size[0], 10)
            ground = page.driver.execute_script("return getComputedStyle(document.body).backgroundColor")
            assert (min(map(int, re.findall(r"\d+", ground))) > 200) == (look == "light")

            bar = page.driver.execute_script("return document.querySelector('.bar').offsetHeight")
            assert bar < 60  # one line, of icons where it is narrow

    for path in PAGES.values():  # closed as soon as they begin to load; a traceback in the terminal would be seen
        page.driver.execute_script("window.open(arguments[0])", address + path)  # from a page of the app
        page.driver.switch_to.window(page.driver.window_handles[-1])
        time.sleep(0.3)
        page.driver.close()
        page.driver.switch_to.window(page.driver.window_handles[0])
    time.sleep(3)

    assert page.asked_hosts() == {urlsplit(address).netloc}
    entries = page.driver.get_log("browser")
    assert [entry for entry in entries if entry["level"] == "SEVERE"] == []
    loaded = Path(f"/proc/{process.pid}/maps").read_text()
    assert [name for name in HEAVY if f"/{name}/" in loaded] == []
    later = of_the_app(process.pid)
    print(f"memory of the web process and of the one that draws: {sizes} MB, with interferograms {later} MB")
    assert megabytes(process.pid, "status", "VmHWM") < LARGEST and max(sum(sizes), sum(later)) < TOGETHER
