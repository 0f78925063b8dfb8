"""From a case file to a Case: which input belongs together, what follows from it, and what makes no sense."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from math import inf
from pathlib import Path
from typing import Any, NamedTuple, TypeVar, cast

from ertel.inputs import schema
from ertel.inputs.quantities import COMPLIANCE, VISCOSITY, Amount
from ertel.inputs.schema import (
    CaseFile,
    ConfigError,
    ContactSection,
    LubricantSection,
    OscillationTable,
    OutputSection,
    SolverSection,
    SpotSection,
    TimeSection,
    WavinessSection,
    plain_data,
    show,
)
from ertel.model import case as defaults
from ertel.model.case import METHODS, SOLVERS, Case, Kind, Method, Output, Solver, Time
from ertel.numerics import grid
from ertel.physics import lubricant, scales
from ertel.physics.motion import FREE_BALL, STEADY_ROLLING, Motion, Oscillation, Polyline, Signal, constant
from ertel.physics.scales import Parameters, Scales
from ertel.physics.surfaces import Feature, RingWaviness, Shape, Spot, Waviness
from ertel.solvers import radial

__all__ = ["ConfigError", "check_case", "load_case", "parse_case"]

FEWEST_NODES = 17  # of the 2-D methods
CENTRED_HALF_WIDTH = 4.5  # of a grid on which the oil comes from either side

T = TypeVar("T")


def load_case(path: str | Path, overrides: Iterable[str] = ()) -> Case:
    """The case in a TOML file, with overrides such as "solver.nodes=129" laid over it.

    Raises ConfigError when the file cannot be read or says something that is not allowed.
    """
    path = Path(path)
    data = schema.apply_overrides(schema.read_toml(path), overrides)
    data.setdefault("name", path.stem)
    return parse_case(data)


def parse_case(data: Mapping[str, object]) -> Case:
    """The case in plain data with the sections and keys of a case file.

    Examples
    --------
    >>> case = parse_case({"contact": {"M": 1000, "L": 10}, "solver": {"method": "radial"}})
    >>> round(case.parameters.alpha_bar, 2)
    36.44
    """
    file = schema.validate(data)
    kind = file.contact.kind
    written = dict(cast(Mapping[str, object], data["contact"]))
    route = _route(kind, written)
    drive = _physical(file.contact, written) if route not in (MOES, BARS) else DIMENSIONLESS[kind]
    si = drive.scales
    oil = _oil(file.lubricant, physical=si is not None)
    parameters = _parameters(file.contact, oil, si, written, route)
    method = _method(file)
    time, output = _times(file, method, si)
    motion = _motion(file, drive)
    case = Case(
        parameters=parameters,
        lubricant=_lubricant(oil, parameters, si),
        solver=_solver(file.solver, method, motion, time),
        time=time,
        output=output,
        scales=si,
        kind=kind,
        motion=motion,
        roughness=_roughness(file, si),
        name=file.name,
    )
    _check_motion(case)
    _check_roughness(case)
    return check_case(replace(case, source=plain_data(_resolved(file, case, oil))))


def check_case(case: Case) -> Case:
    """The case again, or ConfigError where its grid is too small, lies wrongly, or cannot be coarsened."""
    s = case.solver
    if s.method == "radial":
        _named("solver", radial.check_grid, s.nodes, s.half_width)
        return case
    if s.nodes < FEWEST_NODES:
        raise ConfigError(f"solver.nodes = {s.nodes}: must be at least {FEWEST_NODES}")
    _named("solver", grid.check_nodes, s.nodes)
    if s.inlet is not None and not 1 < s.inlet < 2 * s.half_width - 1:
        raise ConfigError(
            f"solver.inlet = {s.inlet}: must be above 1 and below {2 * s.half_width - 1:g} = 2 half_width - 1, so that "
            "the contact lies inside the grid"
        )
    return case


# -- which keys -------------------------------------------------------------------------------------------------------

Keys = tuple[str, ...]
MOES: Keys = ("M", "L")
BARS: Keys = ("lambda_bar", "alpha_bar")
RADII = (("radius",), ("radius_1", "radius_2"))
BALL = (("mass",), ("ball_density",))
FALL = (("speed",), ("drop_height",))
TRACK = (("mean_speed",), ("speed_1", "speed_2"))
ELASTICITY = (("E_prime",), ("E1", "nu1", "E2", "nu2"))
NEEDED: Mapping[Kind, tuple[tuple[Keys, ...], ...]] = {
    "impact": (RADII, BALL, FALL, ELASTICITY),
    "rolling": (RADII, (("load",),), TRACK, ELASTICITY),
}
OPTIONAL: Mapping[Kind, Keys] = {
    "impact": ("mean_speed", "slide_to_roll"),
    "rolling": ("mass", "ball_density", "slide_to_roll"),
}
PHYSICAL: Mapping[Kind, Keys] = {
    kind: (*(key for group in groups for keys in group for key in keys), *OPTIONAL[kind])
    for kind, groups in NEEDED.items()
}
PHYSICAL_TEXT: Mapping[Kind, str] = {
    "impact": "radius (or two radii), mass or ball_density, speed or drop_height, E_prime or E1, nu1, E2, nu2",
    "rolling": "radius (or two radii), load, mean_speed or speed_1 and speed_2, E_prime or E1, nu1, E2, nu2",
}
FOREIGN: Mapping[Kind, Mapping[str, str]] = {  # what to take instead
    "impact": {
        "load": "its load follows from mass and speed; a load that is applied to the ball is motion.load",
        "speed_1": "a track that moves under the ball has contact.mean_speed and contact.slide_to_roll",
        "speed_2": "a track that moves under the ball has contact.mean_speed and contact.slide_to_roll",
    },
    "rolling": {
        "speed": "its surfaces have contact.mean_speed, or contact.speed_1 and contact.speed_2",
        "drop_height": "its surfaces have contact.mean_speed, or contact.speed_1 and contact.speed_2",
    },
}


def _route(kind: Kind, written: Mapping[str, object]) -> Keys:
    """MOES, BARS or PHYSICAL: the one way in which the contact is given."""
    for key, instead in FOREIGN[kind].items():
        if key in written:
            article = "an impact" if kind == "impact" else "a rolling contact"
            raise ConfigError(f'{_entry(key, written)}: not for {article} (contact.kind = "{kind}"): {instead}')
    if "slide_to_roll" in written and any(key in written for key in (*MOES, *BARS)):
        raise ConfigError(f"{_entry('slide_to_roll', written)}: in a dimensionless case write motion.slide_to_roll")
    return _only_one(written, (MOES, BARS, PHYSICAL[kind]), PHYSICAL_TEXT[kind])


def _only_one(written: Mapping[str, object], alternatives: Sequence[Keys], last: str = "") -> Keys:
    """The one alternative of which something is written in [contact].  last: text that stands for the last one."""
    present = [keys for keys in alternatives if any(key in written for key in keys)]
    texts = [" and ".join(keys) for keys in alternatives]
    allowed = "; or ".join([*texts[:-1], last or texts[-1]])
    if not present:
        raise ConfigError(f"contact.{alternatives[0][0]}: missing; allowed: {allowed}")
    if len(present) > 1:
        pair = [_entry(next(key for key in keys if key in written), written) for keys in present[:2]]
        raise ConfigError(f"{' and '.join(pair)} are given together; allowed: {allowed}")
    return present[0]


def _complete(written: Mapping[str, object], keys: Keys) -> None:
    missing = [key for key in keys if key not in written]
    if missing:
        present = next(key for key in keys if key in written)
        raise ConfigError(f"contact.{missing[0]}: missing; {_entry(present, written)} needs " + " and ".join(keys))


def _entry(key: str, written: Mapping[str, object]) -> str:
    return f"contact.{key} = {show(written[key])}"


# -- the contact ------------------------------------------------------------------------------------------------------


class Drive(NamedTuple):
    """What the contact's own input says of scales and motion, None where it says nothing.

    entrainment in units a/t0: a rolling contact's is 1, or -1 where its mean speed is negative.
    """

    scales: Scales | None
    entrainment: float | None
    slide_to_roll: float | None
    inertia: float | None


DIMENSIONLESS: Mapping[Kind, Drive] = {
    "impact": Drive(None, None, None, FREE_BALL.inertia),
    "rolling": Drive(None, None, None, None),
}


def _physical(contact: ContactSection, written: Mapping[str, object]) -> Drive:
    """Scales and motion of a physical contact, each of its inputs given in exactly one of the allowed ways."""
    for alternatives in NEEDED[contact.kind]:
        _complete(written, _only_one(written, alternatives))
    R1, R2 = contact.radius or contact.radius_1, contact.radius_2 or inf
    R = _named("contact", scales.reduced_radius, R1, R2)
    if contact.E_prime is None:
        E_prime = _named("contact", scales.reduced_modulus, contact.E1, contact.nu1, contact.E2, contact.nu2)
    else:
        E_prime = contact.E_prime
    mean, slide = _speeds(contact, written)
    if contact.kind == "rolling":
        si = _named("contact", scales.rolling_scales, R, contact.load, abs(cast(float, mean)), E_prime)
        mass = _mass(contact, written, R1)
        return Drive(si, 1.0 if cast(float, mean) > 0 else -1.0, slide, mass * si.film / (si.load * si.t0**2))
    speed = contact.speed or _named("contact", scales.drop_speed, contact.drop_height)
    si = _named("contact", scales.impact_scales, R, _mass(contact, written, R1), speed, E_prime)
    return Drive(si, None if mean is None else mean / si.front_speed, slide, FREE_BALL.inertia)


def _mass(contact: ContactSection, written: Mapping[str, object], radius: float | None) -> float:
    """The ball's mass (kg), zero where none is given; radius: of the first ball."""
    if not any(key in written for keys in BALL for key in keys):
        return 0.0
    _only_one(written, BALL)
    return contact.mass or _named("contact", scales.sphere_mass, radius, contact.ball_density)


def _speeds(contact: ContactSection, written: Mapping[str, object]) -> tuple[float | None, float | None]:
    """Mean speed (m/s) and slide-to-roll ratio (u1 - u2)/u_m of the surfaces; None, None where they have none."""
    if contact.speed_1 is not None and contact.speed_2 is not None:
        if "slide_to_roll" in written:
            raise ConfigError(
                f"{_entry('slide_to_roll', written)}: follows from speed_1 and speed_2; allowed with mean_speed only"
            )
        mean, difference = (contact.speed_1 + contact.speed_2) / 2, contact.speed_1 - contact.speed_2
        if mean == 0:
            pair = f"{_entry('speed_1', written)} and {_entry('speed_2', written)}"
            raise ConfigError(f"{pair}: their mean must not be zero, it carries the oil into the contact")
        return mean, difference / mean
    if contact.mean_speed is None:
        if "slide_to_roll" in written:
            raise ConfigError(f"{_entry('slide_to_roll', written)}: needs contact.mean_speed")
        return None, None
    if contact.mean_speed == 0 and contact.kind == "rolling":
        raise ConfigError(f"{_entry('mean_speed', written)}: must not be zero, it carries the oil into the contact")
    return contact.mean_speed, contact.slide_to_roll or 0.0


def _parameters(
    contact: ContactSection, oil: LubricantSection, si: Scales | None, written: Mapping[str, object], route: Keys
) -> Parameters:
    """lambda_bar and alpha_bar by the one route that the input takes; zero pressure index where the oil has none."""
    isoviscous = oil.viscosity == "isoviscous"
    if si:
        return _named("contact", scales.parameters, si, oil.eta0, 0.0 if isoviscous else oil.alpha)
    first, second = route
    if isoviscous and written.get(second):
        raise ConfigError(f'{_entry(second, written)}: must be 0 or left out with lubricant.viscosity = "isoviscous"')
    _complete({second: 0, **written} if isoviscous else written, route)
    make = Parameters.from_moes if route is MOES else Parameters
    return _named("contact", make, getattr(contact, first), getattr(contact, second) or 0.0)


# -- the oil ----------------------------------------------------------------------------------------------------------


def _oil(oil: LubricantSection, physical: bool) -> LubricantSection:
    """The oil with typical data filled in, or with what is missing demanded where the contact is physical."""
    if not physical:
        return oil.model_copy(update={"eta0": oil.eta0 or lubricant.ETA0, "alpha": oil.alpha or lubricant.ALPHA})
    for key, si in {"eta0": VISCOSITY, "alpha": COMPLIANCE}.items():
        if getattr(oil, key) is None and not (key == "alpha" and oil.viscosity == "isoviscous"):
            raise ConfigError(f'lubricant.{key}: missing, a physical contact needs it, for example "{si.example}"')
    return oil


def _lubricant(oil: LubricantSection, parameters: Parameters, si: Scales | None) -> lubricant.Lubricant:
    p_h = si.p_h if si else parameters.alpha_bar / (oil.alpha or lubricant.ALPHA)
    if p_h == 0 and oil.viscosity != "isoviscous":
        raise ConfigError(f'contact.L = 0: must be above zero with lubricant.viscosity = "{oil.viscosity}"')
    if p_h == 0 and oil.density == "dowson-higginson":
        raise ConfigError(
            'lubricant.density = "dowson-higginson": needs a pressure scale, which a dimensionless isoviscous case '
            'does not have; allowed: density = "incompressible", or physical input'
        )
    viscosity: lubricant.Viscosity = lubricant.Isoviscous()
    if oil.viscosity == "barus":
        viscosity = lubricant.Barus(parameters.alpha_bar)
    elif oil.viscosity == "roelands":
        z = oil.z or _named("lubricant", lubricant.roelands_exponent, oil.alpha, oil.eta0, oil.p0)
        viscosity = lubricant.Roelands(parameters.alpha_bar, z, p_h / oil.p0)
    dense = oil.density == "dowson-higginson"
    density = lubricant.DowsonHigginson(p_h / lubricant.DENSITY_PRESSURE) if dense else lubricant.Incompressible()
    return lubricant.Lubricant(viscosity, density)


# -- grid and time ----------------------------------------------------------------------------------------------------


def _method(file: CaseFile) -> Method:
    methods = METHODS[file.contact.kind]
    method = file.solver.method or methods[0]
    if method not in methods:
        allowed = " or ".join(f'"{name}"' for name in methods)
        raise ConfigError(f'solver.method = "{method}": must be {allowed} with contact.kind = "{file.contact.kind}"')
    return method


def _solver(section: SolverSection, method: Method, motion: Motion, time: Time) -> Solver:
    """The solver with what is left out filled in, an inlet of its default's share of the half width."""
    found = SOLVERS[method]
    half_width, inlet = found.half_width, found.inlet
    if method == "radial" and section.inlet is not None:
        raise ConfigError(f"solver.inlet = {section.inlet}: a radial grid has none; leave it out")
    if method == "transient" and _both_signs(motion.entrainment, cast(float, time.until)):
        half_width, inlet = CENTRED_HALF_WIDTH, None
    width = section.half_width or half_width
    inlet = section.inlet or (inlet and inlet * width / half_width)
    return Solver(
        method=method,
        nodes=section.nodes or found.nodes,
        half_width=width,
        inlet=None if inlet == width else inlet,
        tolerance=section.tolerance or found.tolerance,
        fold=found.fold if section.fold is None else section.fold,
    )


def _both_signs(signal: Signal, until: float) -> bool:
    least, largest = signal.range(until)
    return least < 0 < largest


def _times(file: CaseFile, method: Method, si: Scales | None) -> tuple[Time, Output]:
    """Time and output in units t0."""
    if method == "steady":
        for name, section in {"time": file.time, "output": file.output}.items():
            if section is not None:
                key = next(iter(section.model_fields_set), "")
                said = f"{name}.{key} = {show(getattr(section, key))}" if key else name
                raise ConfigError(f"{said}: a steady contact has no time; leave [{name}] out or take {TRANSIENT}")
        return Time(), Output()
    t0 = si.t0 if si else None
    section = file.time or TimeSection()
    impact = file.contact.kind == "impact"
    if not impact and section.start_approach is not None:
        raise ConfigError(
            f"time.start_approach = {section.start_approach}: not for a rolling contact, its start is the steady film"
        )
    until = section.until or (defaults.Time.until if impact else Amount(defaults.ROLLING_UNTIL))
    if not impact and isinstance(until, str):
        raise ConfigError(
            f'time.until = "{until}": is an event of an impact; a rolling contact needs a time, in units t0'
        )
    time = Time(
        start_approach=section.start_approach or defaults.Time.start_approach,
        until=_over("time.until", until, t0) if isinstance(until, Amount) else until,
        tolerance=section.tolerance,
        step=None if section.step is None else _over("time.step", section.step, t0),
    )
    return time, Output(_over("output.interval", (file.output or OutputSection()).interval, t0))


TRANSIENT = 'solver.method = "transient"'


def _over(field: str, amount: Amount, scale: float | None) -> float:
    """An amount in the units of the case."""
    try:
        return amount.over(scale)
    except ValueError as error:
        raise ConfigError(f"{field} = {show(amount)}: {error}") from error


# -- motion -----------------------------------------------------------------------------------------------------------


def _motion(file: CaseFile, drive: Drive) -> Motion:
    """What the contact's own input and [motion] say together."""
    impact = file.contact.kind == "impact"
    section, usual = file.motion or schema.MotionSection(), FREE_BALL if impact else STEADY_ROLLING
    if section.slide_to_roll is not None and drive.slide_to_roll is not None:
        raise ConfigError(
            f"motion.slide_to_roll = {section.slide_to_roll}: belongs to dimensionless cases; with speeds in [contact] "
            "write contact.slide_to_roll, or contact.speed_1 and contact.speed_2"
        )
    if section.inertia is not None and drive.inertia is not None:
        instead = "of an impact it is always 4/5" if impact else "give contact.mass or contact.ball_density"
        raise ConfigError(f"motion.inertia = {section.inertia}: belongs to dimensionless rolling cases; {instead}")
    t0 = drive.scales.t0 if drive.scales else None
    load = usual.load if section.load is None else _signal("motion.load", section.load, t0)
    given = None if section.entrainment is None else _signal("motion.entrainment", section.entrainment, t0)
    if impact and given and drive.entrainment is not None:
        raise ConfigError(
            f"motion.entrainment = {show(section.entrainment)} and contact.mean_speed = {file.contact.mean_speed} m/s "
            "are given together; allowed: one of them"
        )
    usual_entrainment = constant(drive.entrainment) if impact and drive.entrainment else usual.entrainment
    entrainment = given or usual_entrainment
    if not impact and drive.entrainment == -1.0:
        entrainment = _reversed(entrainment)
    inertia = drive.inertia if drive.inertia is not None else section.inertia
    slide = drive.slide_to_roll if drive.slide_to_roll is not None else section.slide_to_roll
    return Motion(load, entrainment, inertia or 0.0, slide or 0.0)


def _signal(field: str, given: schema.Signal, t0: float | None) -> Signal:
    if isinstance(given, OscillationTable):
        return Oscillation(given.mean, given.amplitude, _over(f"{field}.period", given.period, t0), given.phase)
    if isinstance(given, float):
        return constant(given)
    points = tuple((_over(f"{field}[{i}]", T, t0), value) for i, (T, value) in enumerate(given, 1))
    try:
        return Polyline(points)
    except ValueError as error:
        raise ConfigError(f"{field} = {show(given)}: must be [T, value] with rising T") from error


def _reversed(signal: Signal) -> Signal:
    if isinstance(signal, Oscillation):
        return Oscillation(-signal.mean, -signal.amplitude, signal.period, signal.phase)
    return Polyline(tuple((T, -value) for T, value in cast(Polyline, signal).points))


def _check_motion(case: Case) -> None:
    """What a method cannot do, and what has no solution."""
    motion, method, until = case.motion, case.solver.method, case.time.until
    if method == "radial" and any((*motion.load.range(inf), *motion.entrainment.range(inf))):
        raise ConfigError('motion: the radial method is for a free ball on a track at rest; take solver.method = "2d"')
    if until == "rebound" and motion.load.range(inf)[1] > 0:
        raise ConfigError('time.until = "rebound": a ball under a load may never leave; give a time, in units t0')
    if case.kind == "rolling":
        _check_rolling(motion, method, inf if isinstance(until, str) else until)


def _check_rolling(motion: Motion, method: Method, until: float) -> None:
    loads = motion.load.range(until)
    if method == "steady":
        for name in ("load", "entrainment"):
            least, largest = getattr(motion, name).range(inf)
            if least != largest:
                raise ConfigError(f"motion.{name}: varies in time from {least:g} to {largest:g}; take {TRANSIENT}")
    if motion.entrainment(0.0) == 0:
        raise ConfigError(
            "motion.entrainment: is 0 at T = 0, where a rolling contact needs a film; must not be zero there, a small "
            "speed will do"
        )
    if motion.load(0.0) <= 0:
        raise ConfigError(f"motion.load: is {motion.load(0.0):g} at T = 0; must be above zero there")
    if motion.inertia == 0 and loads[0] <= 0:
        raise ConfigError(
            f"motion.load: goes down to {loads[0]:g}; must stay above zero, without inertia the film balances it at "
            "every moment"
        )


# -- roughness --------------------------------------------------------------------------------------------------------


def _roughness(file: CaseFile, si: Scales | None) -> tuple[Feature, ...]:
    features = enumerate(file.roughness, 1)
    return tuple(Feature(_shape(f"roughness[{i}]", section, si), section.surface) for i, section in features)


def _shape(field: str, section: schema.FeatureSection, si: Scales | None) -> Shape:
    a, film = (si.a, si.film) if si else (None, None)

    def given(key: str, scale: float | None, default: float = 0.0) -> float:
        amount = getattr(section, key)
        return default if amount is None else _over(f"{field}.{key}", amount, scale)

    if isinstance(section, SpotSection):
        if (section.height is None) == (section.depth is None):
            said = "missing" if section.height is None else "is given together with depth"
            raise ConfigError(f"{field}.height: {said}; allowed: height (negative: a cavity); or depth")
        height = given("height", film) if section.depth is None else -given("depth", film)
        return Spot(height, given("radius", a), given("x", a), given("y", a))
    if isinstance(section, WavinessSection):
        if section.wavelength_x is None and section.wavelength_y is None:
            raise ConfigError(f"{field}.wavelength_x: missing; needed: wavelength_x or wavelength_y, or both")
        if section.ramp is not None and section.front is None:
            raise ConfigError(f"{field}.ramp = {show(section.ramp)}: needs front, behind which the wave grows")
        return Waviness(
            given("amplitude", film),
            given("wavelength_x", a, inf),
            given("wavelength_y", a, inf),
            section.phase_x,
            section.phase_y,
            given("front", a, inf),
            given("ramp", a),
        )
    wavelength = given("wavelength", a)
    return RingWaviness(given("amplitude", film), wavelength, section.phase, given("x", a), given("y", a))


def _check_roughness(case: Case) -> None:
    method, motion = case.solver.method, case.motion
    if method == "radial" and case.roughness:
        raise ConfigError('roughness: the radial method is for smooth surfaces; take solver.method = "2d"')
    for number, feature in enumerate(case.roughness, 1):
        if method == "steady" and motion.travel(feature.surface, 1.0) and not _same_all_along(feature.shape):
            raise ConfigError(
                f"roughness[{number}].surface = {feature.surface}: moves, so that its film is not steady; take "
                f"{TRANSIENT}, or a slide_to_roll at which it is at rest (surface 1: -2, surface 2: 2)"
            )


def _same_all_along(shape: Shape) -> bool:
    """Whether a shape does not change where its surface moves along X."""
    return isinstance(shape, Waviness) and shape.wavelength_x == shape.front == inf


# -- the resolved file ------------------------------------------------------------------------------------------------


def _resolved(file: CaseFile, case: Case, oil: LubricantSection) -> CaseFile:
    """The file with all that was left out, which reads back as the same case to the last bit."""
    s = case.solver
    inlet = s.half_width if s.inlet is None and case.kind == "rolling" else s.inlet
    solver = SolverSection(method=s.method, nodes=s.nodes, half_width=s.half_width, inlet=inlet, tolerance=s.tolerance)
    update: dict[str, object] = {"lubricant": oil, "solver": solver}
    if s.method != "steady":
        section = file.time or TimeSection()
        start = case.time.start_approach if case.kind == "impact" else None
        until = section.until or (case.time.until if isinstance(case.time.until, str) else Amount(case.time.until))
        time = section.model_copy(update={"start_approach": start, "until": until})
        update |= {"time": time, "output": file.output or OutputSection()}
    return file.model_copy(update=update)


def _named(section: str, function: Callable[..., T], *arguments: Any) -> T:
    """function(*arguments), its complaint about an argument as one about a field of the section."""
    try:
        return function(*arguments)
    except (ValueError, ArithmeticError) as error:
        message = str(error)
        raise ConfigError(message if message.startswith(f"{section}.") else f"{section}.{message}") from error
