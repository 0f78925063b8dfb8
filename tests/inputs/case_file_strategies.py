"""Case files of every kind for hypothesis: valid ones, and valid ones with something wrong; and what must hold for all.

The keys and their kinds of values are read off the records of the model, so that a new key is tested too.  The short
form is `test_case_files`, the long one `validation/faults/case_files.py`.
"""

import json
import math
import re
import tomllib
from collections.abc import Callable
from copy import deepcopy
from dataclasses import MISSING, fields
from datetime import date, datetime, time
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w
from cases import CASES, REFUSALS, SHEET
from hypothesis import strategies as st

from ertel.case.case import KEYS as SECTIONS
from ertel.case.case import Case
from ertel.case.conditions import Conditions
from ertel.case.sections import Drive, Output, Solver, Thermal, Time
from ertel.inputs.case_files import ConfigError, load_case, parse_case, to_toml
from ertel.inputs.layout import DataSheet, Materials, MeasuredFile, NamedLubricant
from ertel.physics.lubricant import Oil
from ertel.physics.registry import DENSITY_LAWS, FLUIDITY_LAWS, SHAPES, VISCOSITY_LAWS
from ertel.physics.units import Bounds, Unit, marks

LONGEST_MESSAGE = 600  # a key and its value at 100 each, and the list of the keys of [contact]
HEIGHTS = "heights.npy"  # a measured surface beside each case file
Data = dict[str, Any]


USUAL = {  # sizes of quantities, in SI; of other units 0.1 to 10
    **{"m": (1e-4, 0.1), "kg": (1e-3, 10.0), "kg/m^3": (1e3, 2e4), "m/s": (0.01, 10.0), "N": (1.0, 1e3)},
    **{"Pa": (1e8, 1e12), "Pa*s": (1e-3, 1.0), "1/Pa": (1e-9, 1e-7), "s": (1e-5, 1e-2), "deg": (-180.0, 180.0)},
    **{"K": (280.0, 400.0), "1/K": (1e-4, 0.1), "J/(kg*K)": (400.0, 3e3), "m^2/s": (1e-5, 1e-3)},
}
OTHER_UNITS = {"m": ("inch", 0.0254), "m/s": ("km/hour", 1 / 3.6), "Pa": ("bar", 1e5), "s": ("ms", 1e-3)}
EXTREME: tuple[Any, ...] = (
    *(0, -1, 1, 10**400, -(10**400), 2**63, 1e-30, 1e30, 1e-300, 1e300, 5e-324, -1e300),
    *(0.0, -0.0, math.inf, -math.inf, math.nan, True, False),
)
HOSTILE = (
    *("", " " * 3000, "1 m**(9**9**9)", "1 " + "m" * 10_000, "9" * 400 + " m", "1e300 m", "1e-300 m", "1e9999 m"),
    *("nan m", "-1 m", "1 m^9^9", "1 (((m)))", "1 m*m/m", "1 km**99/m**98", "10 kg", "10", "mm", "1 \u00b5m"),
    *("../../evil", "..", "x" * 10_000, "a\nb", "\x00", "\x1b[31mred", "\u202eabc", "rebound", "max-approach"),
)
TAGS = ("<number>", "<points>", "<table>", "<name>")  # as the schema calls its alternatives
NESTED = json.loads("[" * 100 + "]" * 100)
KEYS = ("", *TAGS, "a.b", "a\nb", "\x1b", "k" * 1000, "nodes ", "M", "load", "shape")


anything: st.SearchStrategy[Any] = st.one_of(
    st.sampled_from(EXTREME),
    st.sampled_from(EXTREME + HOSTILE),
    st.sampled_from(HOSTILE),
    st.text(max_size=8),
    st.floats(),
    st.integers(),
    st.sampled_from([date(2020, 1, 1), datetime(2020, 1, 1), time(12), [], {}, [[]], [{}], NESTED]),
    st.lists(st.one_of(st.floats(), st.text(max_size=3), st.booleans()), max_size=3),
    st.dictionaries(st.sampled_from(KEYS), st.one_of(st.floats(), st.text(max_size=3)), max_size=2),
    st.builds(lambda value, unit: f"{value!r} {unit}", st.floats(), st.sampled_from([*USUAL, "mm", "GPa", "t0"])),
)


def quantities(unit: Unit) -> st.SearchStrategy[str]:
    in_si = st.floats(*USUAL.get(unit.unit, (0.1, 10.0)))
    other, size = OTHER_UNITS.get(unit.unit, (unit.unit, 1.0))
    return st.one_of(in_si.map(lambda x: f"{x!r} {unit.unit}"), in_si.map(lambda x: f"{x / size!r} {other}"))


def numbers(bounds: Bounds) -> st.SearchStrategy[Any]:
    least = next((limit for limit in (bounds.gt, bounds.ge) if limit is not None), -10.0)
    most = next((limit for limit in (bounds.lt, bounds.le) if limit is not None), max(10.0, 10 * least))
    if bounds.whole:
        return st.sampled_from([33, 65, 129, 257])
    return st.floats(least + 1e-3 * (most - least), most - 1e-3 * (most - least))


def values_of(record: Any, **special: st.SearchStrategy[Any]) -> dict[str, st.SearchStrategy[Any]]:
    """Usual values of each field of a record; a field that is no number needs a special one or is left out."""
    found = {}
    for name, mark in marks(record).items():
        found[name] = numbers(mark) if isinstance(mark, Bounds) else quantities(mark)
        if isinstance(mark, Unit) and mark.scale:
            found[name] = st.one_of(st.floats(0.05, 5.0), found[name])
    return found | special


def tables(record: Any, **special: st.SearchStrategy[Any]) -> st.SearchStrategy[Data]:
    """A record as a table: all that it needs and some of the rest."""
    values = values_of(record, **special)
    needed = {f.name for f in fields(record) if f.default is MISSING and f.default_factory is MISSING} | set(special)
    optional = {name: value for name, value in values.items() if name not in needed}
    return st.fixed_dictionaries({name: values[name] for name in values if name in needed}, optional=optional)


# Valid cases: known ones with other numbers, another key and another law

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.toml"))
STARTS: list[Data] = [
    *(data for _, data in CASES),
    *REFUSALS["cases"].values(),
    *(tomllib.loads(path.read_text(encoding="utf-8")) for path in EXAMPLES),
    {**REFUSALS["cases"]["moes"], "roughness": [{"shape": "measured", "file": HEIGHTS, "rms": 0.01, "length_x": 3.0}]},
    {**REFUSALS["cases"]["bodies"], "lubricant": {"oil": SHEET, "temperature": "60 degC"}, "thermal": {}},
]
RECORDS = {"contact": Conditions, "lubricant": Oil, "solver": Solver, "motion": Drive, "time": Time, "output": Output}
LAWS = {"viscosity": VISCOSITY_LAWS, "density": DENSITY_LAWS, "rheology": FLUIDITY_LAWS}
AMOUNT = re.compile(r"^[-+]?[0-9.]+(?:e[-+]?[0-9]+)?(?= \S)")


@st.composite
def laws(draw: st.DrawFn) -> Data:
    """A law of an oil by its name or as a table, by its key."""
    key = draw(st.sampled_from([*LAWS]))
    name = draw(st.sampled_from([name for name, law in LAWS[key].items() if hasattr(law, "of") or key == "rheology"]))
    base = {"base": tables(LAWS[key]["carreau"], law=st.just("carreau"))} if name == "limited" else {}
    return {key: draw(st.one_of(st.just(name), tables(LAWS[key][name], law=st.just(name), **base)))}


@st.composite
def case_data(draw: st.DrawFn) -> Data:
    """A case file as data; mostly a valid one."""
    factor = draw(st.floats(0.8, 1.25))  # one, so that times still rise

    def other(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: other(item) for key, item in value.items()}
        if isinstance(value, list):
            return [other(item) for item in value]
        if isinstance(value, str):
            return AMOUNT.sub(lambda found: repr(float(found[0]) * factor), value)
        return value * factor if isinstance(value, float) else value

    data: Data = other(draw(st.sampled_from(STARTS)))
    if draw(st.booleans()):
        section = draw(st.sampled_from([name for name in RECORDS if name in data]))
        key = draw(st.sampled_from([*values_of(RECORDS[section])]))
        data[section] = {**data[section], key: draw(values_of(RECORDS[section])[key])}
    if not draw(st.integers(0, 3)):
        data["lubricant"] = {**data.get("lubricant", {}), **draw(laws())}
    return draw(st.sampled_from([{}, {"name": "a name"}, {"schema": 1}])) | data


def _places(data: Any) -> list[tuple[Any, Any]]:
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    found = [(data, key) for key, _ in items]
    for _, item in list(items):
        found.extend(_places(item))
    return found


OTHERS: tuple[Any, ...] = (Thermal, Materials, NamedLubricant, DataSheet, MeasuredFile)
WITH_KEYS = (*RECORDS.values(), *OTHERS, *FLUIDITY_LAWS.values(), *SHAPES.values())
KNOWN = [item.name for record in WITH_KEYS for item in fields(record)]
new_keys = st.one_of(*map(st.sampled_from, (KEYS, KNOWN, SECTIONS)), st.text(max_size=5))  # type: ignore[arg-type]


@st.composite
def spoiled(draw: st.DrawFn) -> Data:
    """A case file as data, with up to three places changed: dropped, renamed, given another value, wrapped."""
    data = deepcopy(draw(case_data()))
    for _ in range(draw(st.sampled_from([0, 0, 1, 1, 2, 3]))):
        places = _places(data)
        if not places:
            break
        holder, key = draw(st.sampled_from(range(len(places))).map(places.__getitem__))
        how = draw(st.sampled_from(["drop", "value", "value", "value", "rename", "add", "wrap"]))
        if how == "drop":
            del holder[key]
        elif how == "value":
            holder[key] = deepcopy(draw(anything))
        elif how == "wrap":
            holder[key] = draw(st.sampled_from([[holder[key]], {"value": holder[key]}, [holder[key]] * 2]))
        elif isinstance(holder, dict):
            holder[draw(new_keys)] = holder.pop(key) if how == "rename" else deepcopy(draw(anything))
    return data


Noise = Callable[[bytes, int, bytes], bytes]
BYTES = (b"\x00", b"\x1b", b'"', b"[", b"=", b"\n[contact]\n")
NOISE: dict[str, Noise] = {
    "insert": lambda text, at, noise: text[:at] + noise + text[at:],
    "overwrite": lambda text, at, noise: text[:at] + noise + text[at + len(noise) :],
    "cut": lambda text, at, noise: text[:at],
    "twice": lambda text, at, noise: text + text[at:],
}


@st.composite
def case_files(draw: st.DrawFn) -> bytes:
    """The bytes of a case file; every eighth has something wrong with the text itself, see also `test_case_files`."""
    text = tomli_w.dumps(draw(spoiled())).encode()
    if draw(st.integers(0, 7)):
        return text
    noise = draw(st.one_of(st.binary(max_size=5), st.sampled_from(BYTES)))
    return NOISE[draw(st.sampled_from(sorted(NOISE)))](text, draw(st.integers(0, len(text))), noise)


def outcome(path: Path) -> str:
    """How a case file is read: "a case", or "refused: " and the section or "the file".

    Raises AssertionError if a case does not read back as the same or its name is no plain file name, or if a message is
    not one short printable line that names a place.  Any exception but ConfigError passes through.  The measured
    surface and the heights of a case are written beside the file.
    """
    if not (path.parent / HEIGHTS).exists():
        np.save(path.parent / HEIGHTS, np.sin(np.arange(256.0)).reshape(16, 16))
    try:
        case = load_case(path)
    except ConfigError as error:
        return f"refused: {_place(str(error), path)}"
    assert case.name.isprintable() and len(Path("runs", case.name).parts) <= 2, "its name is no plain file name"
    for name, heights in case.maps.items():
        (path.parent / name).write_bytes(heights.to_bytes())
    written = case.to_data()
    stored = Case.from_data(written, case.maps)
    for again in (stored, parse_case(tomllib.loads(to_toml(case)), path.parent)):
        assert again == case and again.digest == case.digest and again.name == case.name, "reads back as another"
        assert again.oil.reference == case.oil.reference, "has lost its sources"
    assert stored.to_data() == json.loads(json.dumps(written)) == written, "holds what JSON and TOML cannot"
    assert (stored.motion, stored.features, stored.lubricant) == (case.motion, case.features, case.lubricant)
    return "a case"


def _place(message: str, path: Path) -> str:
    assert message.isprintable(), "the message has control characters or several lines"
    assert len(message) - message.count(str(path)) * len(str(path)) <= LONGEST_MESSAGE, "the message is too long"
    if message.startswith(f"the case file {path}"):
        return "the file"
    field = re.match(r"\w*", message)[0]  # type: ignore[index]
    if "unknown key" in message and field not in SECTIONS:
        return "an unknown section"
    assert field in SECTIONS and (": " in message or "; allowed" in message), "the message names no place"
    return f"[{field}]"
