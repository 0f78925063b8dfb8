"""Line contacts in the commands and in the app."""

import json
import re
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
