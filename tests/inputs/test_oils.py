"""The library of oils and materials: every data file is complete, and its oils behave like the real ones."""

import tomllib

import numpy as np
import pytest
import tomli_w
from cases import DATA, REFUSALS
from hypothesis import given
from hypothesis import strategies as st

import ertel
from ertel.case.records import ConfigError
from ertel.inputs import materials, oils
from ertel.physics.materials import NamedOil, Sourced

OILS = [oils.get(name) for name in oils.names()]
MATERIALS = [materials.get(name) for name in materials.names()]
named = {"ids": lambda entry: entry.name}


def test_what_is_there():
    assert {"squalane", "pao-100", "iso-vg-68", "iso-vg-100", "polyglycol"} <= set(oils.names())
    assert oils.get("ISO VG 68") is oils.get("iso-vg-68")
    assert {"steel", "glass", "sapphire", "silicon-nitride", "tungsten-carbide"} == set(materials.names())
    assert (SQUALANE.shear.data.G, SQUALANE.shear.data.n) == (6e6, 0.42)
    assert SQUALANE.limiting_stress is None
    assert oils.get("pao-100").limiting_stress.data.Lambda == 0.035
    assert oils.get("pao-100").thermal is None


@pytest.mark.parametrize("entry", [*OILS, *MATERIALS], **named)
def test_every_part_has_a_source_and_a_range(entry):
    parts = [part for part in vars(entry).values() if isinstance(part, Sourced)]
    assert len(entry.text) > 10 and parts
    for part in parts:
        assert len(part.source) > 10
        assert 273 <= part.coldest <= part.hottest <= 473.15


@pytest.mark.parametrize("oil", OILS, **named)
def test_every_oil_is_an_oil_within_its_data_and_can_be_stored(oil: NamedOil):
    """Thinner when hot, alpha of an oil, viscosity that rises with pressure at every temperature of its range."""
    temperatures = np.linspace(*oil.temperatures, 9)
    found = [oil.at(float(T)) for T in temperatures]
    for quantity in ("eta0", "alpha"):
        values = [getattr(one, quantity) for one in found]
        assert values == sorted(values, reverse=True)
    p = np.linspace(0.0, 1e9, 21)
    for T, one in zip(temperatures, found, strict=True):
        assert 1e-3 < one.eta0 < 2.0
        assert 1e-8 < one.alpha < 5e-8
        assert 0.01 < oil.thinning_at(float(T)) < 0.13
        assert np.all(np.diff(one.viscosity_law.viscosity(p)) > 0)
        assert np.all(np.diff(one.density_law.density(p)) > 0)
        slope = np.log(one.viscosity_law.viscosity(1e4)) / 1e4
        assert slope == pytest.approx(one.alpha, rel=1e-3)
    T = sum(oil.temperatures) / 2
    case = ertel.rolling(radius=0.01, load=10, mean_speed=1, E_prime=231e9, oil=oil.at(T), nodes=65)
    again = ertel.parse_case(tomllib.loads(ertel.to_toml(case)))
    assert again == case and again.digest == case.digest
    assert oil.name in again.oil.reference == case.oil.reference
    coldest, hottest = oil.temperatures
    for T in (coldest - 0.01, hottest + 0.01):
        with pytest.raises(ValueError, match=rf"^temperature = .* K: must be between .* degC.*\({oil.name}\)$"):
            oil.at(T)
    assert oil.at(coldest).eta0 > oil.at(hottest).eta0


@given(st.floats(313.2, 372.9))
def test_the_temperature_coefficient_is_the_derivative(T):
    for oil in OILS:
        h = 0.1
        difference = np.log(oil.viscosity_at(T - h) / oil.viscosity_at(T + h)) / (2 * h)
        assert oil.thinning_at(T) == pytest.approx(difference, rel=1e-5)


SQUALANE = oils.get("squalane")
MEASURED = tomllib.loads((DATA / "squalane.toml").read_text(encoding="utf-8"))


@pytest.mark.parametrize(("T", "points"), MEASURED["viscosity"])
def test_viscosity_of_squalane(T, points):
    oil = SQUALANE.at(T)
    for p, measured in points:
        found = 1e3 * oil.eta0 * float(oil.viscosity_law.viscosity(p * 1e6))
        assert found == pytest.approx(measured, rel=0.025 if p < 2 else 0.12)


def test_viscosity_and_density_of_squalane_at_ambient_pressure():
    for T, measured in MEASURED["ambient"]:
        assert 1e3 * SQUALANE.viscosity_at(T) == pytest.approx(measured, rel=0.03)
    for T, ambient, compressed in MEASURED["density"]:
        assert SQUALANE.density_at(T) == pytest.approx(ambient, rel=0.002)
        law = SQUALANE.pressure_laws_at(T).density
        assert law.density(45e6) == pytest.approx(compressed / ambient, rel=0.0015)


@pytest.mark.parametrize(
    ("name", "C", "D", "K", "off"),
    [
        ("naphthenic-100", 650, -206, 161.60e-6, (-0.20, 0.08)),
        ("mineral-100", 890, -182, 86.86e-6, (-0.08, 0.04)),
        ("pao-100", 1740, -116, 12.26e-6, (0.08, -0.03)),
    ],
)
def test_the_viscosity_in_the_law_of_arana_et_al(name, C, D, K, off):
    """K exp(C/(D + T)) against the viscosities that they measured: as the notes of these oils say."""
    for T, expected in zip((313.15, 373.15), off, strict=True):
        assert K * np.exp(C / (D + T)) / oils.get(name).viscosity_at(T) - 1 == pytest.approx(expected, abs=0.006)


@pytest.mark.parametrize(
    ("first", "second", "E_prime"),
    [("steel", "steel", 231), ("steel", "glass", 125), ("steel", "sapphire", 299), ("steel", "silicon-nitride", 273)],
)
def test_reduced_moduli(first, second, E_prime):
    """Steel on steel is SKF's 231 GPa; steel on glass lies between 110 and 125 GPa in the literature."""
    found = materials.get(first).reduced_modulus(materials.get(second))
    assert found == pytest.approx(E_prime * 1e9, rel=0.005)


@pytest.mark.parametrize("material", MATERIALS, **named)
def test_every_material_is_a_solid(material):
    elasticity, thermal = material.elasticity.data, material.thermal.data
    assert 5e10 < elasticity.E < 8e11
    assert 0.1 < elasticity.nu < 0.4
    assert 2e3 < elasticity.density < 2e4
    assert 1 < thermal.conductivity < 200
    assert 200 < thermal.heat_capacity < 1000


def test_temperatures():
    given = {"40 degC": 313.15, "40degC": 313.15, "-9.5 °C": 263.65, "313.15 K": 313.15, 9: 9}
    assert {text: oils.parse_temperature(text) for text in given} == given


@pytest.mark.parametrize("text", ["40", "40 C", "104 degF", "-300 degC", 0, 10**400, True, None, "", float("nan")])
def test_no_temperatures(text):
    with pytest.raises(ValueError, match='must be a temperature with its unit, "40 degC"'):
        oils.parse_temperature(text)


SHEET = {"nu40": "68 mm^2/s", "nu100": "8.53 mm^2/s", "density": 882.0, "temperature": "40 degC"}


def test_a_data_sheet_gives_the_oil_of_the_library_with_these_data():
    assert oils.data_sheet(**SHEET) == oils.at("iso-vg-68", "40 degC")
    assert oils.data_sheet(**SHEET | {"nu40": 68e-6, "nu100": "8.53 cSt"}) == oils.data_sheet(**SHEET)
    oil = oils.data_sheet(**SHEET, alpha="20 / GPa", expansion="6.5e-4 / K", reference="Own oil 68")
    assert oil.alpha == 2e-8
    assert oil.reference.startswith("Own oil 68 at 40 degC") and oil.reference.endswith("alpha as given.")
    assert oil.eta0 == pytest.approx(68e-6 * 882 * np.exp(-0.01625 * 1.013), rel=1e-9)


@pytest.mark.parametrize(("change", "message"), REFUSALS["data_sheets"], ids=str)
def test_what_a_data_sheet_cannot_have(change, message):
    with pytest.raises(ConfigError, match=f"^{message}"):
        oils.data_sheet(**SHEET | change)


OWN = (DATA / "own_oils.toml").read_text(encoding="utf-8")


@pytest.fixture
def own(tmp_path, monkeypatch):
    """The file of oils of the user's configuration, not there yet."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    (tmp_path / "ertel").mkdir()
    return tmp_path / "ertel" / "oils.toml"


def test_own_oils_of_the_configuration_are_in_the_library(own):
    assert "bench" not in oils.names()
    own.write_text(OWN)
    assert {"bench", "gear", "squalane"} <= set(oils.names())
    sheet = oils.data_sheet("68 mm^2/s", "8.7 mm^2/s", "880 kg/m^3", "60 degC")
    assert oils.at("gear", "60 degC").eta0 == sheet.eta0
    assert "sheet of 2024" in oils.at("gear", "60 degC").reference
    assert "our rig, batch 7" in oils.at("bench", "25 degC").reference
    with pytest.raises(ConfigError, match=r"temperature = \"90 degC\".* 20 degC and 80 degC.*\(bench\)"):
        oils.at("bench", "90 degC")
    with pytest.raises(ConfigError, match=r'oil = "bensch": allowed: bench, gear, '):
        oils.get("bensch")


def test_an_error_in_the_own_file_stops_only_those_who_ask_for_its_oils(own):
    own.write_text("[bench\n" + OWN)
    assert oils.at("squalane", "40 degC").eta0 == pytest.approx(0.0149, abs=1e-4)
    with pytest.raises(ConfigError, match=r"the file of oils .*oils.toml: "):
        oils.get("bench")
    with pytest.warns(UserWarning, match=r"own oils are left out: .*oils.toml: "):
        assert "squalane" in oils.names()
    with pytest.raises(ConfigError, match=r"no\.toml"):  # which the case names
        oils.get("squalane", own.parent / "no.toml")


def test_a_case_with_own_oils_holds_their_numbers(tmp_path):
    """The file beside the case file may go: digest and resolved case have the numbers."""
    (tmp_path / "mine.toml").write_text(OWN)
    oil = {"oil": "bench", "oils": "mine.toml", "temperature": "30 degC"}
    (tmp_path / "case.toml").write_text(tomli_w.dumps({**REFUSALS["cases"]["rolled"], "lubricant": oil}))
    case = ertel.load_case(tmp_path / "case.toml")
    assert case.oil.eta0 == oils.read_file(tmp_path / "mine.toml")["bench"].viscosity_at(303.15)
    (tmp_path / "mine.toml").write_text(OWN.replace("19 mm", "21 mm"))
    assert ertel.load_case(tmp_path / "case.toml").digest != case.digest
    (tmp_path / "mine.toml").unlink()
    again = ertel.parse_case(tomllib.loads(ertel.to_toml(case)))
    assert again.digest == case.digest and "mine.toml" not in ertel.to_toml(case)
    with pytest.raises(ConfigError, match=r"^lubricant\.oils: the file of oils .*mine\.toml: cannot be read"):
        ertel.load_case(tmp_path / "case.toml")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (OWN.replace('source = "our rig, batch 7"', ""), r"bench\.pressure\.source: missing"),
        (OWN.replace('"astm-d341"', '"so-klaus"'), r'bench\.viscosity\.law = "so-klaus": .* astm-d341, v'),
        (OWN.replace("exponent", "exponnent"), r"bench\.pressure\.exponnent = 0\.13: unknown key; .*exponent"),
        (OWN.replace("[bench.density]", "[bench.colour]"), r"bench\.colour = .*: unknown key; .*density"),
        (OWN.replace('reference = "sheet of 2024"', ""), r"gear\.reference: missing"),
        (OWN.replace("[gear]", "[squalane]"), r"squalane: the library has an oil of this name"),
        ("gear = 5", r"gear = 5: must be a table"),
    ],
)  # fmt: skip
def test_wrong_files_of_oils_are_refused_with_file_and_key(tmp_path, text, said):
    (tmp_path / "mine.toml").write_text(text)
    with pytest.raises(ConfigError, match=rf"mine\.toml: .*{said}"):
        oils.read_file(tmp_path / "mine.toml")
