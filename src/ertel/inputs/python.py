"""The Python API for cases: `impact(...)`, `rolling(...)`, `Oil(...)`.

The keywords are the keys of case files.  A quantity is a float in SI or a text with a unit, "10 mm".  An amount (a
layer, a size of the roughness, a time) is a text with a unit in a case in SI, a plain number in one without dimensions;
those of the grid and of the end of a run may be plain numbers in both, see `case_files.with_all_units`.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from inspect import Parameter, Signature
from itertools import pairwise
from math import inf
from textwrap import wrap
from typing import Any, Literal, TypedDict, Unpack, get_type_hints

from ertel.case.case import Case
from ertel.case.conditions import FOREIGN, Conditions, Kind
from ertel.case.reading import hint_for, parse_number
from ertel.case.records import ConfigError, law_data, oil_data, refusing, show, with_own_numbers, with_unit
from ertel.case.sections import Output, Solver, Time
from ertel.inputs.case_files import case_in
from ertel.inputs.layout import IN_SI, READER, Materials, NamedLubricant, field_names
from ertel.inputs.quantities import NumberOrText, parse_quantity, plain_data
from ertel.physics import units
from ertel.physics.fluidity import Fluidity
from ertel.physics.lubricant import Oil as Oil
from ertel.physics.motion import Smooth
from ertel.physics.registry import ASPERITY_LAWS, FLUIDITY_LAWS
from ertel.physics.surfaces import Feature, Shape
from ertel.physics.units import HEIGHT, TEMPERATURE, TIME, Mark, Meaning, Quantity, marks, meanings, parameter_lines


class _Keywords(TypedDict, total=False):
    """The keywords of every case, as they may be given; what is None is left out."""

    M: float | None
    L: float | None
    lambda_bar: float | None
    alpha_bar: float | None
    radius_ratio: float | None
    length_ratio: float | None
    radius: NumberOrText | None
    radius_1: NumberOrText | None
    radius_2: NumberOrText | None
    radius_x: NumberOrText | None
    radius_y: NumberOrText | None
    radius_x_1: NumberOrText | None
    radius_y_1: NumberOrText | None
    radius_x_2: NumberOrText | None
    radius_y_2: NumberOrText | None
    length: NumberOrText | None
    entrainment_angle: NumberOrText | None
    mass: NumberOrText | None
    ball_density: NumberOrText | None
    mean_speed: NumberOrText | None
    slide_to_roll: float | None
    E_prime: NumberOrText | None
    E1: NumberOrText | None
    nu1: float | None
    E2: NumberOrText | None
    nu2: float | None
    material_1: str | None
    material_2: str | None
    oil: Oil | str | None
    temperature: NumberOrText | None
    rheology: str | Mapping[str, Any] | Fluidity | None
    layer: NumberOrText | None
    layer_1: NumberOrText | None
    layer_2: NumberOrText | None
    method: str | None
    nodes: int | None
    half_width: float | None
    half_width_y: float | None
    inlet: float | None
    tolerance: float | None
    fold: bool | None
    motion: Mapping[str, Any] | None
    roughness: Sequence[Feature | Shape | Mapping[str, Any]]
    surfaces: Mapping[str, Any] | None
    until: float | str | None
    step: float | str | None
    time_tolerance: float | None
    interval: float | str | None
    name: str


class ImpactKeywords(_Keywords, total=False):
    """The keywords of an impact."""

    speed: NumberOrText | None
    drop_height: NumberOrText | None
    start_approach: float | None
    start: Literal["undeformed"] | None


class RollingKeywords(_Keywords, total=False):
    """The keywords of a rolling contact."""

    load: NumberOrText | None
    speed_1: NumberOrText | None
    speed_2: NumberOrText | None
    thermal: Mapping[str, Any] | None


SPECIAL: Mapping[str, Meaning] = {  # keywords that are not fields of a record
    "oil": Meaning(
        "an Oil, or the name of one (`ertel.oils`), which brings its law of shear thinning where it has one; needed by "
        "a physical contact, otherwise a typical mineral oil"
    ),
    "rheology": Meaning(
        "how the oil thins under shear, instead of the oil's own: a table as in case files, "
        "{'law': 'ree-eyring', 'tau0': '5 MPa'}, the record of a law, or 'newtonian'; 'carreau' takes its data from a "
        "named oil that has them"
    ),
    "motion": Meaning(
        "load, entrainment, slide_to_roll, sliding, curvature (signals) and inertia, as [motion] of a case file; a "
        "function of time becomes a signal by `ertel.sampled`"
    ),
    "roughness": Meaning(
        "shapes, features (a shape on surface 1 or 2), or tables as [[roughness]] of a case file; heights are added"
    ),
    "surfaces": Meaning(
        "roughness as numbers and the asperities that touch, as [surfaces] of a case file; the law is a table, "
        "{'law': 'persson', 'longest': '50 um', 'shortest': '1 um'}, or a record"
    ),
    "time_tolerance": meanings(Time)["tolerance"],
    "thermal": Meaning(
        "data for the temperatures of a steady contact, as [thermal] of a case file (`ertel.case.sections.Thermal`); "
        "{} takes all of them from the oil and the materials that are named"
    ),
    "name": Meaning("for titles and directories"),
}
GROUPS: Mapping[str, tuple[tuple[Any, ...], tuple[str, ...]]] = {  # of the keywords: records with them, and others
    "contact": ((Materials, Conditions), ("roughness", "surfaces")),
    "oil": ((NamedLubricant, Oil), ("thermal",)),
    "grid": ((Solver,), ()),
    "time and output": ((Time, Output), ("time_tolerance", "motion", "name")),
}
# sections that are one keyword, with a key as it is written
TABLES = {
    "lubricant": "oil=Oil({}=...)",
    "motion": "motion={{'{}': ...}}",
    "surfaces": "surfaces={{'{}': ...}}",
    "thermal": "thermal={{'{}': ...}}",
}
OFTEN = ("material_1", "material_2", "M", "L", "oil", "temperature", "method", "nodes", "until")  # most cases need


def _explain(function: Callable[..., Case], keywords: Any, often: Sequence[str]) -> None:
    """Name the keywords in the signature of a function and explain them in its docstring, group by group.

    often: the keywords that most cases need, which come first in their group and have a section of their own.
    """
    hints = get_type_hints(keywords)
    left = sorted(hints, key=lambda name: often.index(name) if name in often else len(often))
    groups: dict[str, list[str]] = {}
    texts: dict[str, tuple[str, ...]] = {}
    for group, (records, others) in GROUPS.items():  # the first group that knows a keyword has it
        known: dict[str, tuple[Meaning, Mark | None]] = {name: (SPECIAL[name], None) for name in others}
        for record in records:
            known |= {
                name: (SPECIAL.get(name, each), marks(record).get(name)) for name, each in meanings(record).items()
            }
        groups[group] = [name for name in left if name in known]
        texts |= {name: parameter_lines(name, *known[name]) for name in groups[group]}
        left = [name for name in left if name not in known]
    lines = [f"* {group}: {', '.join(names)}" for group, names in groups.items()]
    lines = [part for line in lines for part in wrap(line, 110, subsequent_indent="  ")]
    usual, seldom = [name for name in texts if name in often], [name for name in texts if name not in often]
    for title, names in {"Parameters": usual, "Other Parameters": seldom}.items():
        lines += ["", title, "-" * len(title), *(line for name in names for line in texts[name])]
    function.__doc__ = (function.__doc__ or "").replace("{parameters}", "\n    ".join(lines))
    given = [Parameter(name, Parameter.KEYWORD_ONLY, default=None, annotation=hints[name]) for name in texts]
    function.__signature__ = Signature(given, return_annotation=Case)  # type: ignore[attr-defined]


def impact(**given: Unpack[ImpactKeywords]) -> Case:
    """The impact of a ball on an oiled surface.

    A dimensionless contact is given by `M` and `L` or by `lambda_bar` and `alpha_bar`; a physical one by a radius, mass
    or density, speed or drop height, and the elasticity or the materials.  Quantities are floats in SI or texts with a
    unit, "10 mm".

    The keywords by what they are about; those that most cases need come first.

    {parameters}

    Returns
    -------
    Case
        The case, checked.

    Raises
    ------
    ConfigError
        A ValueError that names the field, its value and what is allowed.

    Examples
    --------
    >>> case = impact(radius=0.01, ball_density=7850, speed=0.1, E1=210e9, nu1=0.3, E2=210e9, nu2=0.3,
    ...               oil=Oil(eta0=0.0186, alpha=20e-9))
    >>> round(case.scales.p_h / 1e9, 2)
    1.42
    """
    return _case("impact", given, ImpactKeywords)


def rolling(**given: Unpack[RollingKeywords]) -> Case:
    """The contact of a ball that rolls and slides on an oiled surface.

    A dimensionless contact is given by `M` and `L` or by `lambda_bar` and `alpha_bar`; a physical one by a radius, the
    load, the speeds, and the elasticity or the materials.  A material gives no density here, because a ball without one
    has no inertia.  The method is "transient" if anything changes in time: load, speed, moving roughness.  Quantities
    are floats in SI or texts with a unit, "10 mm".

    The keywords by what they are about; those that most cases need come first.

    {parameters}

    Returns
    -------
    Case
        The case, checked.

    Raises
    ------
    ConfigError
        A ValueError that names the field, its value and what is allowed.

    Examples
    --------
    >>> rolling(M=200, L=10, nodes=129).solver.method
    'steady'
    """
    return _case("rolling", given, RollingKeywords)


_explain(impact, ImpactKeywords, ("radius", "speed", *OFTEN))
_explain(rolling, RollingKeywords, ("radius", "load", "mean_speed", *OFTEN))


def quantity(text: str) -> Quantity:
    """A length or a time with its unit, for records of roughness and signals.

    Parameters
    ----------
    text : str
        A number and a unit, "20 nm" or "5 ms".

    Returns
    -------
    Quantity
        The same in SI.

    Raises
    ------
    ConfigError
        For anything else.
    """
    for unit in (HEIGHT, TIME):
        with suppress(ValueError):
            return Quantity(parse_quantity(plain_data(text), unit.in_si), unit.unit)
    raise ConfigError(f"text = {show(text)}: must be a length or a time with its unit, such as '20 nm' or '5 ms'")


MOST_CELLS, SAMPLED_TO = 1024, 1e-4  # of a function; the largest error between the samples, of its largest value


def sampled(function: Callable[[float], float], until: float | str) -> dict[str, list[tuple[float | str, float]]]:
    """A function of time as a signal: samples with a smooth curve through them, which a case can write down.

    Parameters
    ----------
    function : callable
        The value at a time: in t0, or in seconds where `until` has a unit.  It should be smooth: the kinks of points
        with straight lines between them are better given as such, [[T, value], ...].
    until : float or str
        The last time, from zero on: a number in t0, or a text with its unit, "5 ms".

    Returns
    -------
    dict
        The table { smooth = [[T, value], ...] } of a case file; so many samples that the curve is within 1e-4 of the
        largest value half-way between them, at most 1025.

    Raises
    ------
    ConfigError
        The last time is not above zero, or a value is not a finite number.

    Examples
    --------
    >>> len(sampled(lambda T: 1.0 + 0.1 * T**2, until=2.0)["smooth"])
    17
    """
    with refusing("until", until):
        end = READER.amount(until, units.DURATION)
    last, cells = end.value if isinstance(end, Quantity) else end, 8
    error = inf
    while error > SAMPLED_TO and cells < MOST_CELLS:
        cells *= 2
        times = [last * n / cells for n in range(cells + 1)]
        points = tuple((time, _finite(function(time), time)) for time in times)
        halves = [(early + late) / 2 for early, late in pairwise(times)]
        curve, largest = Smooth(points), max(abs(value) for _, value in points)
        error = max(abs(curve(time) - _finite(function(time), time)) for time in halves) / (largest or 1.0)
    unit = " s" if isinstance(end, Quantity) else ""
    return {"smooth": [(f"{time!r}{unit}" if unit else time, value) for time, value in points]}


def _finite(value: Any, time: float) -> float:
    with refusing(f"function({time:g})", value):
        return parse_number(plain_data(value), units.FINITE)


def _case(kind: Kind, given: Mapping[str, Any], keywords: Any) -> Case:
    """The case of keyword arguments, read in the same way as a case file."""
    known = tuple(keywords.__annotations__)
    for name in given:
        if name not in known:
            hint = FOREIGN[kind].get(name) or hint_for(name, known, _in_tables(name, known))
            raise TypeError(f"{kind}() got an unexpected keyword argument '{name}': {hint}")
    values = {key: plain_data(value) for key, value in given.items() if value is not None}
    if not isinstance(values.get("oil"), Oil | str | None):
        oil = show(values["oil"])
        raise ConfigError(f"oil = {oil}: must be made by Oil(eta0=..., alpha=...), or be the name of an oil")

    def section(*records: Any) -> dict[str, Any]:
        names = [name for record in records for name in field_names(record)]
        return {name: values[name] for name in names if name in values}

    time = {key: value for key, value in section(Time).items() if key != "tolerance"}
    if "time_tolerance" in values:
        time["tolerance"] = values["time_tolerance"]
    records, tables = _sorted(values.get("roughness", ()))
    sections: dict[str, Any] = {
        "name": values.get("name"),
        "contact": {"kind": kind, **section(Materials, Conditions)},
        "lubricant": _lubricant(values),
        "solver": section(Solver),
        "motion": values.get("motion"),
        "thermal": values.get("thermal"),
        "roughness": tables,
        "surfaces": _surfaces(values.get("surfaces")),
        "time": time or None,
        "output": section(Output) or None,
    }
    given = {name: table for name, table in sections.items() if table is not None}
    return case_in(given, features=records, reader=IN_SI)


def _in_tables(name: str, known: Sequence[str]) -> list[str]:
    """The ways to write a key of a section that is one keyword in Python."""
    places = (full.split(".") for full in READER.full_names(name))
    ways = (TABLES[section].format(key) for section, key in places if section in TABLES)
    return [way for way in ways if way.partition("=")[0] in known]


def _lubricant(values: Mapping[str, Any]) -> dict[str, Any] | None:
    """The section [lubricant] of an oil, or of the name of an oil and its temperature."""
    oil = values.get("oil")
    data = oil_data(with_own_numbers(oil)) if isinstance(oil, Oil) else {} if oil is None else {"oil": oil}
    if "temperature" in values:
        data["temperature"] = with_unit(values["temperature"], TEMPERATURE)
    if isinstance(oil, Oil) and oil.is_newtonian:
        del data["rheology"]  # the default of an Oil, not a wish
    if "rheology" in values:
        law = values["rheology"]
        data["rheology"] = law_data(law, FLUIDITY_LAWS) if hasattr(law, "fluidity") else law
    data |= {name: values[name] for name in ("layer", "layer_1", "layer_2") if name in values}
    return data or None


def _surfaces(section: Any) -> Any:
    """The section [surfaces], its law as a table."""
    law = section.get("asperities") if isinstance(section, Mapping) else None
    return {**section, "asperities": law_data(law, ASPERITY_LAWS)} if hasattr(law, "curve") else section


def _sorted(roughness: Any) -> tuple[list[Feature], list[dict[str, Any]]]:
    """Records as features, and tables."""
    if isinstance(roughness, str | Mapping) or not isinstance(roughness, Sequence):
        raise ConfigError(f"roughness = {show(roughness)}: must be a list of shapes, features or tables")
    tables = [dict(item) for item in roughness if isinstance(item, Mapping)]
    shapes = [item for item in roughness if not isinstance(item, Mapping)]
    return [item if isinstance(item, Feature) else Feature(item) for item in shapes], tables
