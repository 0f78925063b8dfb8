"""Line contacts in the commands and in the app."""

import asyncio
import json
import re
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from app_runs import refused
from cases import ertel_

from ertel.inputs.case_files import load_case


def test_commands_show_a_line_contact(lines: Path, tmp_path: Path) -> None:
    told = ertel_("show", str(lines / "steady")).stdout
    assert "on 129 nodes along x" in told and re.search(r"load carried by the film +load +1.57\d+ +2 kN", told)
    assert "along y" not in told
    _, *rows = ertel_("ls", str(lines)).stdout.splitlines()
    assert [row.split()[0] for row in rows] == ["impact", "steady"]
    differing = json.loads(ertel_("compare", str(lines / "steady"), str(lines / "impact"), "--json").stdout)["numbers"]
    assert {"H_c", "X_min"} <= {each["name"] for each in differing}
    assert "a line contact has no maps" in refused(
        "plot", str(lines / "impact"), "--what", "film", "--format", "gif", "--out", str(tmp_path)
    )
    checked = json.loads(ertel_("check", str(lines / "steady" / "case.toml"), "--json").stdout)
    assert (checked["grid"]["nodes_across"], checked["parameters"]["radius_ratio"]) == (1, 0)
    assert "129 nodes along x" in ertel_("check", str(lines / "steady" / "case.toml")).stdout


@pytest.mark.parametrize("kind", ["impact", "rolling"])
def test_a_new_case_of_a_line_contact(kind: str, tmp_path: Path) -> None:
    file = tmp_path / "new.toml"
    ertel_("new", kind, str(file), "--line")
    case = load_case(file)
    assert case.geometry.is_line and case.method.axes == ("X",)
    assert "warning" not in ertel_("check", str(file)).stdout.lower()


def test_the_app_draws_profiles(lines: Path) -> None:
    pytest.importorskip("nicegui")
    from ertel.apps.browser.pictures import PlotRequest, draw_picture, run_info, stamp_of

    figures = {name: run_info(lines / name, stamp_of(lines / name)).figures for name in ("steady", "impact")}
    assert figures["steady"] == ("midlines", "friction", "convergence", "overview")
    assert figures["impact"] == ("profiles", "history", "front", "spacetime", "friction", "overview")
    picture = draw_picture(PlotRequest(lines / "impact", "profiles", dots=20, stamp=stamp_of(lines / "impact")))
    assert picture.readout is None
    with pytest.raises(ValueError, match="film: a line contact has no such figure"):
        draw_picture(PlotRequest(lines / "impact", "film", stamp=stamp_of(lines / "impact")))


@pytest.mark.asyncio
async def test_pages_of_line_contacts(lines: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The pages of a run and of two side by side ask for profiles, and have no tabs of maps."""
    pytest.importorskip("nicegui")
    from app_runs import stand_in
    from nicegui import ElementFilter, ui
    from nicegui.testing import user_simulation

    from ertel.apps.browser import pictures, server
    from ertel.apps.browser.folder import Folder
    from ertel.apps.browser.processes import Processes
    from ertel.apps.browser.site import Site

    asked: set[tuple[str, str]] = set()

    def drawn(request: pictures.PlotRequest) -> pictures.Picture:
        asked.add((request.run.name, request.figure))
        return pictures.Picture(b"", None)

    monkeypatch.setattr(pictures, "draw_picture", drawn)
    folder = Folder.at(lines)
    site = Site(folder, Processes(folder, stand_in(tmp_path)), pictures.Worker(lambda: ThreadPoolExecutor(1)))
    async with user_simulation(root=server.root_of(site)) as user:
        site.serve_pictures()
        first, both = {("impact", "profiles")}, {("steady", "midlines"), ("impact", "profiles")}
        for page, wanted in (("/run?name=impact", first), ("/compare?a=steady&b=impact", both)):
            asked.clear()
            await user.open(page)
            for _ in range(500):
                await asyncio.sleep(0.02)
                if asked >= wanted:
                    break
            assert asked == wanted
            with user:
                assert not {each.props["name"] for each in ElementFilter(kind=ui.tab)} & {"maps", "interferogram"}
