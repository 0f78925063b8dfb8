"""Studies: which values vary, in which order, and what is refused."""

import pytest
from cases import BALL, REFUSALS

from ertel.case.records import ConfigError
from ertel.inputs.studies import coordinates, load_study, parse_study

OIL = {"eta0": "10 mPa*s", "alpha": "22 / GPa"}


def moes(**contact):
    return {"contact": {"M": 200, "L": 10, **contact}, "solver": {"method": "radial"}}


def ball(speed="0.1 m/s"):
    return {"contact": {**BALL, "speed": speed}, "lubricant": OIL, "solver": {"method": "radial"}}


def shape(study):
    return tuple(len(axis.values) for axis in study.axes) if study.mode == "product" else (len(study.cases),)


def pairs(study):
    return [(case.contact.M, case.contact.L) for case in study.cases]


def test_a_product_combines_all_values():
    study = parse_study(moes(M=[100, 300], L=[5, 10, 20]))
    assert shape(study) == (2, 3) and [axis.field for axis in study.axes] == ["contact.M", "contact.L"]
    assert pairs(study) == [(100, 5), (100, 10), (100, 20), (300, 5), (300, 10), (300, 20)]
    study = parse_study({**moes(), "solver": {"method": "radial", "nodes": "101:301:3"}})
    assert [case.solver.nodes for case in study.cases] == [101, 201, 301]
    study = parse_study({**moes(M="100:300:2"), "lubricant": {"reference": "40:60 blend of two oils"}})
    assert [axis.field for axis in study.axes] == ["contact.M"]
    data = {**moes(), "lubricant": {"viscosity": ["roelands", "barus"]}, "time": {"until": [0.5, "max-approach"]}}
    found = coordinates(parse_study(data))
    assert found["viscosity"][0] == ["roelands", "barus"] and found["until"][0] == ["0.5", "max-approach"]


def test_a_zip_takes_the_values_side_by_side_which_may_be_shared():
    for M, L in (([100, 300], [5, 20]), ([100, 100, 300], [5, 20, 5])):
        study = parse_study({**moes(M=M, L=L), "sweep": {"mode": "zip"}})
        assert shape(study) == (len(M),)
        assert pairs(study) == list(zip(M, L, strict=True))


def test_a_unit_at_one_end_holds_for_both():
    for speeds in ("100 mm/s:200 mm/s:2", "100:200 mm/s:2", "100 mm/s:200:2"):
        study = parse_study(ball(speeds))
        assert [case.contact.speed for case in study.cases] == [0.1, 0.2]
        values, about = coordinates(study)["speed"]
        assert values == [0.1, 0.2] and about["units"] == "m/s" and about["field"] == "contact.speed"


def test_values_in_tables_vary_too():
    wave = {"shape": "waviness", "amplitude": [0.01, 0.02], "wavelength_x": 0.5}
    law = {"law": "carreau", "G": ["5 MPa", "10 MPa"], "n": 0.5}
    data = {
        "contact": {"kind": "rolling", "M": 200, "L": 10},
        "motion": {"load": {"mean": 1, "amplitude": [0.1, 0.2], "period": 1.0}},
        "solver": {"method": "transient"},
        "roughness": [wave],
    }
    study = parse_study(data)
    assert [axis.field for axis in study.axes] == ["motion.load.amplitude", "roughness[1].amplitude"]
    assert list(coordinates(study)) == ["motion_load_amplitude", "roughness_1_amplitude"]
    with pytest.raises(ConfigError, match="rheology"):  # the radial impact has none, but the place was found
        parse_study({**ball(), "contact": BALL, "lubricant": {**OIL, "rheology": law}})


def test_the_points_of_a_signal_are_one_value():
    rolling = {"contact": {"kind": "rolling", "M": [100, 200], "L": 10}, "solver": {"method": "transient"}}
    rises, falls = [[0, 1], [1, 2]], [[0, 1], [1, 0.5]]
    assert shape(parse_study({**rolling, "motion": {"load": rises}})) == (2,)
    study = parse_study({**rolling, "motion": {"load": [rises, falls, 1.5]}})
    assert shape(study) == (2, 3) and study.cases[1].motion.load(1.0) == 0.5
    assert coordinates(study)["load"][0] == ["[[0, 1], [1, 2]]", "[[0, 1], [1, 0.5]]", "1.5"]
    # Thicknesses in a list vary, and so do tracks.
    rolling = {"contact": {"kind": "rolling", "M": [100, 200], "L": 10}}
    thin, thick = [[-1, 0.05], [1, 0.1]], [[-1, 0.1], [1, 0.2]]
    assert shape(parse_study({**rolling, "lubricant": {"layer": thin}})) == (2,)
    for layers in ([0.05, 0.1], [thin, thick], [0.05, thick]):
        assert shape(parse_study({**rolling, "lubricant": {"layer": layers}})) == (2, 2)


def test_a_file_with_overrides(tmp_path):
    file = tmp_path / "two balls.toml"
    file.write_text('[contact]\nM = [100, 200]\nL = 10\n[solver]\nmethod = "radial"\n[sweep]\nmode = "product"\n')
    assert load_study(file).name == "two balls"
    assert shape(load_study(file, ["contact.L=[5, 10, 20]"])) == (2, 3)


SECTIONS = [({"M": [100, 200], "L": [5, 10, 20]}, said, {"sweep": sweep}) for sweep, said in REFUSALS["study_sections"]]


@pytest.mark.parametrize(("contact", "message", "more"), [*((*row, {}) for row in REFUSALS["study_values"]), *SECTIONS])
def test_a_wrong_value_or_section_is_named(contact, message, more):
    with pytest.raises(ConfigError, match=message):
        parse_study({**moes(**contact), **more})


def test_values_of_all_kinds_must_differ():
    waves = [{"law": "carreau", "n": 0.5}, {"n": 0.5, "law": "carreau"}]
    for same in (waves, [[[0, 1], [1, 2]], [[0, 1.0], [1, 2]]], ["1 MPa", "1 MPa"]):
        with pytest.raises(ConfigError, match=r"solver.method = .*: the values must differ from each other"):
            parse_study({"contact": {"M": 200, "L": 10}, "solver": {"method": same}})
    with pytest.raises(ConfigError, match=r"^solver.method"):
        parse_study({"contact": {"M": 200, "L": 10}, "solver": {"method": [{1, 2}, {1, 2}]}})
    with pytest.raises(ConfigError, match=r"^contact.speed = .* both ends must have the same unit"):
        parse_study(ball("1 mm/s:1 m/s:2"))


def test_each_value_is_not_compared_with_all_others():
    compared = []

    class Number(float):
        __hash__ = float.__hash__

        def __eq__(self, other):
            compared.append(other)
            return float(self) == other

    with pytest.raises(ConfigError, match=r"M = -500.0: must be"):
        parse_study(moes(M=[Number(value) for value in range(-500, 0)]))
    assert len(compared) < 5 * 500
