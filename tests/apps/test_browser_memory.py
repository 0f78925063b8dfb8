"""The memory of the app where a folder has many runs, and pages are loaded again and again by what never connects."""

import os
from pathlib import Path

import pytest
from app_runs import make_run, served

pytest.importorskip("nicegui")
import httpx

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(os.name == "nt", reason="the app stops runs by SIGINT"),
    pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="the memory is read from /proc"),
]
RUNS, LOADS = 300, 200
LARGEST = 400  # MB, of the web process at its peak
PAGES = ("", "new", "run?name=runs/run-007", "compare")


def test_hundreds_of_runs_and_of_page_loads(tmp_path):
    for number in range(RUNS):
        make_run(tmp_path / "runs" / f"run-{number:03}")
    with served(tmp_path, "--no-browser") as (process, address), httpx.Client(timeout=60) as client:
        client.get(address)
        for number in range(LOADS):
            page = client.get(httpx.URL(address).copy_with(query=None).join(PAGES[number % len(PAGES)]))
            assert page.status_code == 200 and page.text.count("impact, M 1000, L 10") >= RUNS
        lines = Path(f"/proc/{process.pid}/status").read_text().splitlines()
        peak = next(int(line.split()[1]) for line in lines if line.startswith("VmHWM:")) / 1024
    print(f"after {LOADS} pages: {peak:.0f} MB")
    assert peak < LARGEST
