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
TO_THE_MIDDLE = "arguments[0].scrollIntoView({block: 'center'})"
FINE_STEPS = "step = 1e-3\n"  # of [time], the last section: a run that lasts long enough to be watched
PAGES = {
    "first-page": "/", "new-case": "/new", "run": "/run?name=runs/mine",
    "compare": "/compare?a=runs/mine&b=runs/before",
}  # fmt: skip
HEAVY = ("jaxlib", "matplotlib", "pandas", "scipy", "numcodecs")  # numcodecs: of zarr
ASKED = ("Network.requestWillBeSent", "Network.webSocketCreated")


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
    yield found
    found.quit()


class Page:
    """What a user does on a page and sees there."""

    def __init__(self, driver):
        self.driver, self.script = driver, driver.execute_script

    def look(self, size, scheme="light"):
        """Have a screen of a size, on a system that is "light" or "dark"."""
        screen = {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": False}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
        feature = {"name": "prefers-color-scheme", "value": scheme}
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [feature]})

    def all(self, selector):
        return [element for element in self.driver.find_elements("css selector", selector) if element.is_displayed()]

    def text(self, selector):
        return " ".join(element.text for element in self.all(selector))

    def until(self, there, seconds=120):
        """Wait for something to become true; what is replaced while it is looked at is not there yet."""
        from selenium.common.exceptions import StaleElementReferenceException

        deadline = time.monotonic() + seconds
        while True:
            with suppress(StaleElementReferenceException):
                if found := there():
                    return found
            assert time.monotonic() < deadline, self.driver.find_element("tag name", "body").text
            time.sleep(0.1)

    def says(self, selector, words, seconds=120):
        self.until(lambda: words in self.text(selector), seconds)

    def click(self, word):
        named = "button, [role=tab]"
        (button,) = self.until(lambda: [each for each in self.all(named) if word in each.text and each.is_enabled()])
        self.script(TO_THE_MIDDLE, button)
        button.click()

    def point(self, element, across, click=False):
        """Move the pointer over an element, so many pixels from its middle."""
        from selenium.webdriver import ActionChains

        moved = ActionChains(self.driver).move_to_element_with_offset(element, across, 0)
        (moved.click() if click else moved).perform()

    def fill(self, label, text):
        from selenium.webdriver import Keys

        (field,) = self.until(lambda: self.all(f"input[aria-label='{label}']"))
        field.click()
        field.send_keys(Keys.CONTROL, "a")
        field.send_keys(text)

    def choose(self, label, word):
        field = self.until(lambda: self.script(FIELD, label))
        self.script(TO_THE_MIDDLE, field)
        field.click()
        self.until(lambda: self.script(CHOOSE, word))
        self.until(lambda: not self.script("return document.querySelectorAll('[role=option]').length"))
        time.sleep(1.0)  # the form is built again

    def picture(self):
        """The address of the picture, when the last wish is drawn and the browser has it whole."""
        there = [] if self.all(".canvas .waits") else self.all(".canvas img")
        whole = there and self.script("return arguments[0].complete", there[0])
        return there[0].get_attribute("src") if whole else ""

    def keep(self, name):
        if place := os.environ.get("ERTEL_SCREENSHOTS"):
            time.sleep(0.6)  # Quasar moves things into place
            Path(place).mkdir(parents=True, exist_ok=True)
            self.driver.save_screenshot(str(Path(place) / f"{name}.png"))

    def asked_hosts(self):
        events = [json.loads(entry["message"])["message"] for entry in self.driver.get_log("performance")]
        requests = [event["params"].get("request", event["params"]) for event in events if event["method"] in ASKED]
        parts = [urlsplit(request["url"]) for request in requests]
        return {part.netloc for part in parts if part.scheme in ("http", "https", "ws", "wss")}


def megabytes(process, file, entry):
    """An entry of a file in /proc.  Pss: the memory of a process, what it shares divided; VmHWM: the largest it had."""
    lines = Path(f"/proc/{process}/{file}").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith(f"{entry}:")) / 1024


def of_the_app(process):
    """The memory of the web process with the largest that it started, which draws, in MB."""
    children = Path(f"/proc/{process}/task/{process}/children").read_text().split()
    own, *others = (megabytes(each, "smaps_rollup", "Pss") for each in (process, *children))
    return own + max(others)


def test_a_session(driver, tmp_path):
    folder = tmp_path / "folder"
    make_run(folder / "runs" / "before")
    with served(folder, "--no-browser") as (process, address):
        _session(Page(driver), process.pid, address, folder)


def _session(page, process, address, folder):
    root, _, _ = address.partition("/?token=")
    runs, run = Processes(Folder.at(folder)), folder / "runs" / "mine"
    page.look(LAPTOP)
    page.driver.get(address)
    page.says(".welcome", "Impact and rolling")

    page.click("New case")
    page.fill("Radius", "10 mm")
    page.says(".answer", "roughly")
    page.choose("Method", "radial")
    page.fill("Nodes", "513")
    page.says(".answer", "513 nodes along the radius")
    page.fill("Name of the run", "mine")
    page.click("Case file")
    (area,) = page.until(lambda: page.all("textarea"))
    before = page.text(".answer")
    area.send_keys(FINE_STEPS)
    page.until(lambda: "roughly" in page.text(".answer") != before)
    page.keep("new-case-as-text")
    page.click("Run")
    page.says(".chip", "compiling")
    page.keep("compiling")
    page.says(".chip", "running")
    page.click("Stop")
    page.says(".chip", "interrupted")
    assert runs.status(run).phase is Phase.INTERRUPTED
    assert 0.0 < runs.status(run).done < 1.0
    page.keep("interrupted")
    page.click("Resume")
    page.says(".chip", "finished", 600)  # minutes where other programs compute, too
    assert runs.status(run).phase is Phase.FINISHED

    first = page.until(page.picture)
    page.point(*page.all(".q-slider__track-container"), -200, click=True)
    page.until(lambda: page.picture() not in ("", first))
    (image,) = page.all(".canvas img")
    page.point(image, -image.size["width"] // 4)
    page.until(lambda: "h = " in page.text(".readout") and "p = " in page.text(".readout"))
    sizes = []
    for word in ("Mid-line", "Motion", "Front", "Friction", "Interferogram", "Overview"):
        before = page.until(page.picture)
        sizes += [of_the_app(process)] if word == "Interferogram" else []
        page.click(word)
        page.until(lambda before=before: page.picture() not in ("", before))
        page.keep(f"run-{word.lower()}")

    page.driver.get(f"{root}/compare?a=runs/mine&b=runs/before")
    page.until(lambda: len(page.all(".canvas img")) == 2)
    for size, scheme in product((TABLET, PHONE), ("light", "dark")):
        page.look(size, scheme)
        for name, path in PAGES.items():
            page.driver.get(root + path)
            page.until(lambda: page.picture() or "roughly" in page.text(".answer") or page.text(".welcome"))
            page.keep(f"{name}-{size[0]}-{scheme}")
            page.until(lambda size=size: page.script("return document.documentElement.scrollWidth") <= size[0], 10)
            ground = page.script("return getComputedStyle(document.body).backgroundColor")
            assert (min(map(int, re.findall(r"\d+", ground))) > 200) == (scheme == "light")
            # one line, of icons where it is narrow
            assert page.script("return document.querySelector('.bar').offsetHeight") < 60

    for path in PAGES.values():  # closed as soon as they begin to load; a traceback in the terminal would be seen
        page.script("window.open(arguments[0])", root + path)  # from a page of the app
        page.driver.switch_to.window(page.driver.window_handles[-1])
        time.sleep(0.3)
        page.driver.close()
        page.driver.switch_to.window(page.driver.window_handles[0])
    time.sleep(3)

    assert page.asked_hosts() == {urlsplit(address).netloc}
    assert [entry for entry in page.driver.get_log("browser") if entry["level"] == "SEVERE"] == []
    loaded = Path(f"/proc/{process}/maps").read_text()
    assert [name for name in HEAVY if f"/{name}/" in loaded] == []
    sizes.append(of_the_app(process))
    print(f"memory of the web process with the one that draws, before and after interferograms: {sizes} MB")
    assert megabytes(process, "status", "VmHWM") < LARGEST and max(sizes) < TOGETHER
