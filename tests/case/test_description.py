"""A case shows itself in a few lines."""

from dataclasses import dataclass, replace

from ertel.case.case import Case
from ertel.physics.surfaces import Feature

BALL = {
    "name": "ball <1>",
    "contact": {
        "kind": "impact",
        "radius": "0.01 m",
        "ball_density": "7850 kg/m^3",
        "speed": "0.1 m/s",
        "E_prime": "2.3076923e11 Pa",
    },
    "lubricant": {"eta0": "0.0186 Pa*s", "alpha": "2e-8 1/Pa", "reference": "a long text"},
    "roughness": [
        {"shape": "spot", "radius": 0.1, "depth": 0.01},
        {"shape": "rings", "amplitude": 0.1, "wavelength": 1},
    ],
}


def test_text():
    lines = repr(Case.from_data(BALL)).splitlines()
    assert lines[0].startswith("Case: ball <1>, impact (2d), M = ")
    assert lines[1].startswith("  contact    kind = impact, radius = 0.01 m, ")
    assert "E_prime = 2.308e+11 Pa" in lines[1]
    assert sum(line.startswith("  roughness") for line in lines) == 2
    assert "a long text" not in "".join(lines)
    assert len(lines) < 10


def test_table():
    html = Case.from_data(BALL)._repr_html_()
    assert "ball &lt;1&gt;" in html and "<th>contact</th>" in html and "<td>shape = spot" in html


def test_a_shape_without_a_name_is_shown_too():
    @dataclass(frozen=True)
    class Mine:
        def heights(self, X, Y):
            return 0 * X * Y

    case = replace(Case.from_data({"contact": {"M": 100, "L": 5}}), roughness=(Feature(Mine()),))
    assert "Mine()" in repr(case)
