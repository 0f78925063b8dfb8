"""Line contacts in the commands and in the app."""

import json
import re
import shutil

import pytest
from app_runs import refused, shown
from cases import ertel_

from ertel.inputs.case_files import load_case

pytest_plugins = "app_user"


def test_commands_show_a_line_contact(lines, tmp_path):
    told = ertel_("show", str(lines / "steady")).stdout
    assert "on 129 nodes along x" in told and "along y" not in told
    assert re.search(r"load carried by the film +load +1.57\d+ +2 kN", told)
    _, *rows = ertel_("ls", str(lines)).stdout.splitlines()
    assert [row.split()[0] for row in rows] == ["impact", "steady"]
    differing = json.loads(ertel_("compare", str(lines / "steady"), str(lines / "impact"), "--json").stdout)["numbers"]
    assert {"H_c", "X_min"} <= {each["name"] for each in differing}
    movie = ("--what", "film", "--format", "gif", "--out", str(tmp_path))
    assert "a line contact has no maps" in refused("plot", str(lines / "impact"), *movie)
    checked = json.loads(ertel_("check", str(lines / "steady" / "case.toml"), "--json").stdout)
    assert (checked["grid"]["nodes_across"], checked["parameters"]["radius_ratio"]) == (1, 0)
    assert "129 nodes along x" in ertel_("check", str(lines / "steady" / "case.toml")).stdout


@pytest.mark.parametrize("kind", ["impact", "rolling"])
def test_a_new_case_of_a_line_contact(kind, tmp_path):
    file = tmp_path / "new.toml"
    ertel_("new", kind, str(file), "--line")
    case = load_case(file)
    assert case.geometry.is_line and case.method.axes == ("X",)
    assert "warning" not in ertel_("check", str(file)).stdout.lower()


def test_the_app_draws_profiles(lines):
    pytest.importorskip("nicegui")
    from ertel.apps.browser.pictures import PlotRequest, draw_picture, run_info, stamp_of

    impact, stamp = lines / "impact", stamp_of(lines / "impact")
    assert run_info(lines / "steady", 1).figures == ("midlines", "friction", "convergence", "overview")
    figures = "profiles", "history", "front", "spacetime", "friction", "overview"
    assert run_info(impact, stamp).figures == figures
    assert draw_picture(PlotRequest(impact, "profiles", dots=20, stamp=stamp)).readout is None
    with pytest.raises(ValueError, match="film: a line contact has no such figure"):
        draw_picture(PlotRequest(impact, "film", stamp=stamp))


@pytest.mark.asyncio
async def test_pages_of_line_contacts(lines, user, site, monkeypatch):
    """The pages of a run and of two side by side ask for profiles, and have no tabs of maps."""
    from nicegui import ElementFilter, ui

    from ertel.apps.browser import pictures

    asked = set()

    def picture(request):
        asked.add((request.run.name, request.figure))
        return pictures.Picture(b"", None)

    monkeypatch.setattr(pictures, "draw_picture", picture)
    for name in ("steady", "impact"):
        shutil.copytree(lines / name, site.folder.root / name)
    first, both = {("impact", "profiles")}, {("steady", "midlines"), ("impact", "profiles")}
    for page, wanted in (("/run?name=impact", first), ("/compare?a=steady&b=impact", both)):
        asked.clear()
        await user.open(page)
        await shown(lambda wanted=wanted: asked >= wanted)
        assert asked == wanted
        with user:
            assert not {each.props["name"] for each in ElementFilter(kind=ui.tab)} & {"maps", "interferogram"}
