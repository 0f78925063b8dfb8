"""What the tests of the programs share: a working directory with cases, and two runs that have ended.

Nothing of ertel is imported at the top: pytest reads this file before JAX is set up where it is given the folder alone.
"""

import shutil
import sys
from types import SimpleNamespace

import pytest


@pytest.fixture(autouse=True)
def _no_garbage_is_looked_for(monkeypatch):
    """NiceGUI's simulated user looks twice for it, in all that other tests have left: half of the time of a page."""
    if simulation := sys.modules.get("nicegui.testing.general"):
        monkeypatch.setattr(simulation, "gc", SimpleNamespace(collect=lambda: 0))


@pytest.fixture
def here(tmp_path, monkeypatch):
    from app_runs import CASE_FILES

    monkeypatch.chdir(tmp_path)
    for name, text in CASE_FILES.items():
        (tmp_path / name).write_text(text)
    return tmp_path


@pytest.fixture(scope="session")
def runs(tmp_path_factory):
    """Finished runs and what they printed: small, to maximum approach, and ball, six steps in SI."""
    from app_runs import CASE_FILES
    from cases import ertel_

    directory, printed = tmp_path_factory.mktemp("runs"), {}
    for name in ("small", "ball"):
        (directory / f"{name}.toml").write_text(CASE_FILES[f"{name}.toml"])
        printed[name] = ertel_("run", str(directory / f"{name}.toml"), "--out", str(directory / name)).stdout
    return directory, printed


@pytest.fixture
def ball(here, runs):
    """A copy of the ball's run in the working directory, under a name that a shell must quote."""
    return shutil.copytree(runs[0] / "ball", here / "my run")
