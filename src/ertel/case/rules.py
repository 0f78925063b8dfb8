"""The rules for valid cases.  Each yields the fields that break it, and what is wrong and what is allowed."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import is_dataclass
from math import ceil, inf

import numpy as np

from ertel.case.case import Case
from ertel.case.conditions import LENGTH_RATIO, MOES_L, MOES_M, REDUCED
from ertel.case.methods import Method, as_written, of_kind
from ertel.case.records import ConfigError, checked, show
from ertel.case.sections import SECTIONS, WIDEST_HALF_WIDTH
from ertel.case.touching import methods_in_time, rough_surfaces, roughness_fits
from ertel.physics.dry_contact import HERTZ_LOAD
from ertel.physics.far_field import ContactMotion, far_film
from ertel.physics.film_formulas import rigid_film
from ertel.physics.geometry import CIRCLE
from ertel.physics.lubricant import DowsonHigginson
from ertel.physics.registry import FLUIDITY_LAWS
from ertel.physics.units import ABOVE_ZERO, NOT_NEGATIVE, Mark

LONGEST_NAME = 100  # bytes: a file name may have 255, and a run's directory has temporary ones made of it
LONGEST_TEXT = 1000  # characters of the source of an oil's data
LONGEST_RUN = 1e5  # t0; an impact lasts about 3
MOST_STEPS = 1e7  # of a fixed length
MOST_MAPS = 1e5
LARGEST_OUTPUT = 1e11  # bytes of the maps, uncompressed
AT_FORMULAS, FIELDS = "; ertel check prints the formulas", 6  # P, H, oil, two shear stresses, power loss

Complaints = Iterator[tuple[str, str]]  # the field, to which its value is added unless it is there; what is wrong
Rule = Callable[[Case], Complaints]


class TooLight(ConfigError):
    """A rolling contact that only the formulas know: no domain is wide enough.  case: it, complete in all else."""

    case: Case


def refuse(case: Case, rules: Iterable[Rule]) -> None:
    """Raise ValueError if a case breaks a rule; the message names the field, its value and what is allowed."""
    for rule in rules:
        for place, complaint in rule(case):
            raise ConfigError(f"{case.entry(place)}: {complaint}")


def check_values(case: Case) -> None:
    """Raise ValueError unless every value is one that its field allows; [contact] checks itself when it is made."""
    for name, section in SECTIONS.items():
        record = getattr(case, section.field)
        if record is not None and name != "contact":
            checked(record, name)


def _name(case: Case) -> Complaints:
    """A name becomes a directory: it must be a plain file name on every system, and safe to print."""
    entry = f"name = {show(case.name)}"
    if not isinstance(case.name, str):
        yield entry, "must be a string"
    elif case.name != plain_name(case.name):
        plain = "visible characters without / \\ and :, not starting with a dot"
        yield entry, f"must be a plain file name: {plain}, at most {LONGEST_NAME} bytes"


def plain_name(text: str) -> str:
    """The text as a plain file name: "_" for what is not allowed, no dot in front, cut; "" if nothing is left."""
    visible = "".join(c if c.isprintable() and c not in "/\\:" else "_" for c in text)
    return visible.lstrip(".").encode()[:LONGEST_NAME].decode(errors="ignore")


def _reference(case: Case) -> Complaints:
    """The source of the data is printed with the results: one line without control characters."""
    text = case.oil.reference
    if not isinstance(text, str) or not text.isprintable() or len(text) > LONGEST_TEXT:
        yield "lubricant.reference", f"must be one line of visible characters, at most {LONGEST_TEXT}"


def method_suits(case: Case) -> Complaints:
    """Each kind of contact has its own methods, and each method its own keys."""
    methods = of_kind(case.kind)
    if case.solver.method not in [method.name for method in methods]:
        allowed = " or ".join(f'"{method.name}"' for method in methods)
        yield "solver.method", f'must be {allowed} with contact.kind = "{case.kind}"'
        return
    for key in case.method.space.lacks:
        if getattr(case.solver, key) is not None:
            yield f"solver.{key}", f"{case.entry('solver.method')} has none; leave it out"


def _shapes(case: Case) -> Complaints:
    for number, feature in enumerate(case.roughness, 1):
        if not (is_dataclass(feature.shape) and hasattr(feature.shape, "heights")):
            name = type(feature.shape).__name__
            yield f"roughness[{number}].shape = {name}", "must be a dataclass with a method heights(X, Y)"
        checked(feature.shape, f"roughness[{number}]")


def oil_is_complete(case: Case) -> Complaints:
    """A physical contact needs the data of its oil."""
    for key, example in {"eta0": "40 mPa*s", "alpha": "22 / GPa"}.items() if case.scales else ():
        if getattr(case.oil, key) is None and not (key == "alpha" and case.oil.is_isoviscous):
            yield f"lubricant.{key}", f'missing, a physical contact needs it, for example "{example}"'


def _rheology(case: Case) -> Complaints:
    """An oil that thins under shear has a stress in Pa."""
    if case.scales is None and not case.oil.is_newtonian:
        no_stress = "has stresses in Pa, which a dimensionless case has not"
        yield _law(case), f'{no_stress}; give the contact in SI or lubricant.rheology = "newtonian"'


def _law(case: Case) -> str:
    return f'lubricant.rheology = {{ law = "{FLUIDITY_LAWS.name_of(case.oil.fluidity_law)}", ... }}'


def _supported(case: Case) -> Complaints:
    """The method must be able to compute what the case asks for."""
    for name, place, only in _asked(case):
        if not getattr(case.method.supports, name):
            others = of_kind(case.kind, lambda method: computes(method, case))
            instead = f"use {as_written(others)}" if others else f"no method of {case.kind} supports it"
            this = "" if place == "solver.method" else f"{case.entry('solver.method')} "
            joined = ", or" if others else ";"
            without = f"{joined} leave [{place}] out" if place in ("thermal", "roughness", "surfaces") else ""
            yield place, f"{this}is for {only}; {instead}{without}"


def computes(method: Method, case: Case) -> bool:
    """Whether a method computes all that a case asks for."""
    supports = method.of(case.geometry).supports
    return method.kind == case.kind and all(getattr(supports, name) for name, _, _ in _asked(case))


def _asked(case: Case) -> Iterator[tuple[str, str, str]]:
    """The demands of a case on its method: the field of `Supports`, the field of the case, and what others are for."""
    if not case.oil.is_newtonian:
        yield "thinning", _law(case), "Newtonian oils only"
    if case.geometry is not CIRCLE:
        yield "ellipse", "solver.method", f"circular contacts, this one has R_x/R_y = {case.contact.ratio:.6g}"
    if any((*case.motion.load.range(inf), *case.motion.entrainment.range(inf))):
        yield "motion", "motion", "a free ball on a track at rest"
    if case.track is not None and len(case.track.points) > 1:
        yield "track", "lubricant.layer", "a uniform layer"
    if case.roughness:
        yield "roughness", "roughness", "smooth surfaces"
    if case.touches:
        yield "touch", "surfaces", "surfaces that do not touch"
    if case.thermal is not None:
        yield "thermal", "thermal", "contacts without [thermal]"


def _scales(case: Case) -> Complaints:
    """The scales and parameters of the contact must be of a sane size, like its values."""
    p, scales = case.parameters, vars(case.scales) if case.scales else {}
    bounds: dict[str, Mark] = {"R": REDUCED, "M": MOES_M, "L": MOES_L, "alpha_bar": NOT_NEGATIVE}
    bounds |= {"length_ratio": LENGTH_RATIO} if case.geometry.is_line else {}
    for name, value in {**scales, **vars(p), "M": p.M, "L": p.L, "length_ratio": p.hertz.reach}.items():
        if name != "hertz" and (complaint := bounds.get(name, ABOVE_ZERO).complaint(value)):
            given = f"its values together give {name} = {show(value)}"
            yield "contact", f"{given}, which {complaint}; check their units"


def _pressure_scale(case: Case) -> Complaints:
    """A pressure-dependent law needs a pressure scale."""
    oil = case.oil
    if case.scales or case.parameters.alpha_bar:
        return
    if not oil.is_isoviscous:
        yield "contact.L = 0", f"must be above zero with {case.entry('lubricant.viscosity')}"
    if oil.density == "dowson-higginson" or isinstance(oil.density, DowsonHigginson):
        needs = "needs a pressure scale, which a dimensionless isoviscous case does not have"
        allowed = 'allowed: density = "incompressible", or physical input'
        yield 'lubricant.density = "dowson-higginson"', f"{needs}; {allowed}"


def _time(case: Case) -> Complaints:
    """A steady contact has no time.  A rolling contact starts from its steady film and has no events."""
    time = case.time
    for name, section in {"time": time, "output": case.output}.items() if case.is_steady else ():
        if section is not None:
            usual = vars(type(section)())
            other = next((f"{name}.{key}" for key, value in vars(section).items() if value != usual[key]), name)
            yield other, f"a steady contact has no time; leave [{name}] out or use {methods_in_time(case)}"
    if case.starts_apart or time is None:
        return
    if time.start_approach is not None:
        yield "time.start_approach", "not for a rolling contact, its start is the steady film"
    if time.start is not None:
        yield "time.start", "not for a rolling contact, its start is the steady film"
    if isinstance(time.until, str):
        yield "time.until", "is an event of an impact; a rolling contact needs a time, in units t0"


def _drive(case: Case) -> Complaints:
    """[motion] must not repeat what [contact] gives."""
    drive, contact = case.drive, case.contact
    if drive is None:
        return
    number = isinstance(drive.slide_to_roll, int | float)
    given = contact.slide_to_roll is not None or contact.speed_1 is not None
    if drive.slide_to_roll is not None and (given or number) and contact.speeds.slide_to_roll is not None:
        instead = "with speeds in [contact] write contact.slide_to_roll, or contact.speed_1 and contact.speed_2"
        allowed = "belongs to dimensionless cases" if number else "is given twice"
        yield "motion.slide_to_roll", f"{allowed}; {instead}"
    if drive.sliding is not None and (given or drive.slide_to_roll is not None):
        yield "motion.sliding", "is given together with slide_to_roll or two speeds; allowed: one of them"
    for key in ("sliding", "curvature") if case.starts_apart else ():
        if getattr(drive, key) is not None:
            yield f"motion.{key}", "is for rolling; leave it out of an impact"
    if drive.curvature is not None and case.is_steady:
        yield "motion.curvature", f"is a function of time; use {methods_in_time(case)}, or give the radius itself"
    if drive.inertia is not None and (case.starts_apart or contact.is_physical):
        of_rolling = "give contact.mass or contact.ball_density"
        instead = "for an impact it follows from its scales" if case.starts_apart else of_rolling
        yield "motion.inertia", f"belongs to dimensionless rolling cases; {instead}"
    if case.starts_apart and drive.entrainment is not None and contact.speeds.mean is not None:
        yield "motion.entrainment", f"is given together with {contact.entry('mean_speed')}; allowed: one of them"


def _geometry(case: Case) -> Complaints:
    """An angle needs something that is entrained."""
    if case.contact.entrainment_angle is not None and not case.motion.flows:
        instead = "leave it out, or give motion.entrainment or contact.mean_speed"
        yield "contact.entrainment_angle", f"nothing is entrained; {instead}"


def _grid(case: Case) -> Complaints:
    """A grid must be large enough, contain the contact at all times, and be one that can be coarsened."""
    moments = case.motion.moments(0.0 if case.is_steady or case.starts_apart else case.schedule.duration)
    grown = max([1.0, *(case.geometry.grown(w, c)[0] for w, _, c in moments if w > 0.0 < c)])
    for key, complaint in case.method.space.complaints(case.solver, case.geometry, grown):
        yield f"solver.{key}", complaint


def _layer(case: Case) -> Complaints:
    """The layers of oil are given in one way, move with the flow, cover the roughness and leave the grid's edge dry."""
    oil, solver, motion = case.oil, case.solver, case.motion
    if case.track is None:
        return
    if oil.layer is not None and (oil.layer_1 is not None or oil.layer_2 is not None):
        yield "lubricant.layer", "give layer, or layer_1 and layer_2"
    if oil.layer is None and oil.layer_1 != oil.layer_2 and not (case.starts_apart or motion.keeps_ratio):
        instead = "give layer, the oil that enters per area at the entrainment speed"
        yield "lubricant.layer_1, layer_2", f"what enters would change with the slide-to-roll ratio in time; {instead}"
    if oil.layer is None and motion.flows and abs(motion.slide_to_roll) > 2:
        away = f"at slide_to_roll = {motion.slide_to_roll:g} one surface takes its oil out of the inlet"
        instead = "give layer, the oil that enters per area at the entrainment speed"
        yield "lubricant.layer_1, layer_2", f"{away}; {instead}"
    thinnest, thickest = case.track.extremes
    for number, feature in enumerate(case.features, 1):
        for key in ("amplitude", "rms"):
            height = getattr(feature.shape, key, 0.0)
            if thinnest < abs(height):
                least = f"must be at least roughness[{number}].{key} = {height:.4g} a^2/R"
                why = "a layer of the same thickness everywhere does not lie on a rougher surface"
                yield f"lubricant.layer = {thinnest:.4g} a^2/R", f"{least}; {why}"
    c = motion.curvature.range(inf)[0]
    contact = ContactMotion(case.geometry.dry_approach(1.0), 0.0, 1.0, 0.0, curvature=c)
    if case.geometry.is_line and not case.starts_apart:
        return  # what does not pass makes the inlet full, see `steady.fed`
    X, Y = np.array([solver.inlet or solver.half_width, 0.0]), np.array([0.0, solver.half_width_y or solver.half_width])
    if case.geometry.is_line:
        X, Y = np.array([-solver.half_width, solver.half_width]), np.zeros(2)
    widths = {key: getattr(solver, key) or 0.0 for key in ("half_width", "inlet", "half_width_y")}
    wider = np.geomspace(1.0, WIDEST_HALF_WIDTH / max(widths.values()), 600)
    films = far_film(np.outer(wider, X), np.outer(wider, Y), contact, case.geometry).min(axis=1)
    if thickest > films[0] / 2:
        wet = f"the oil would reach the edge of the grid, where the gap of the dry contact is {films[0]:.4g}"
        allowed = "must be at most half of that; leave it out (the gap is full)"
        if thickest <= films.max() / 2:
            needed = 4 * wider[np.argmax(films >= 2 * thickest)]  # the first of them, in quarters
            wide = [f"solver.{key} = {ceil(needed * width) / 4:g}" for key, width in widths.items() if width]
            allowed += f" or use {', '.join(wide)}"
        yield f"lubricant.layer = {thickest:.4g} a^2/R", f"{wet}; {allowed}"


def _schedule(case: Case) -> Complaints:
    """A run must end after a reasonable number of steps, with maps that fit on a disk."""
    if case.is_steady:
        return
    start, end, step = case.schedule.start_approach, case.schedule.duration, case.schedule.step
    if start < -LONGEST_RUN:  # a gap of 1 takes the ball 1 t0
        yield "time.start_approach", f"the ball would fall for {-start:g} t0; must be at least {-LONGEST_RUN:g}"
    if end > LONGEST_RUN:
        yield "time.until", f"is {end:g} t0; must be at most {LONGEST_RUN:g} t0"
    if step and end / step > MOST_STEPS:
        least = f"must be at least {end / MOST_STEPS:.3g} t0, for {MOST_STEPS:g} steps at most"
        yield "time.step", f"needs {end / step:.3g} steps; {least}"
    maps = end / case.schedule.interval
    nodes = case.solver.nodes ** len(case.method.axes)
    size = maps * (FIELDS + case.touches) * 8 * nodes  # in double precision
    if maps > MOST_MAPS or size > LARGEST_OUTPUT:
        allowed = f"at most {MOST_MAPS:g} and {LARGEST_OUTPUT / 1e9:g} GB are allowed"
        given = f"gives {maps:.3g} maps with {size / 1e9:.3g} GB"
        yield "output.interval", f"{given}; {allowed}, take a longer interval or fewer nodes"


def _motion(case: Case) -> Complaints:
    """A solution must exist, and a steady film needs a motion that does not change in time."""
    load, entrainment, sliding = case.motion.load, case.motion.entrainment, case.motion.sliding
    until = inf if case.is_steady else case.schedule.until
    if until == "rebound" and load.range(inf)[1] > 0:
        yield "time.until", "a ball under a load may never leave; give a time, in units t0"
    if case.starts_apart:
        return
    varied = {"load": load, "entrainment": entrainment, "sliding": sliding}
    for name, signal in varied.items() if case.is_steady else ():
        least, most = signal.range(inf)
        if least != most:
            yield f"motion.{name}", f"varies in time from {least:g} to {most:g}; use {methods_in_time(case)}"
    if entrainment(0.0) == 0:
        needs = "where a rolling contact needs a film; must not be zero there, a small speed will do"
        yield "motion.entrainment", f"is 0 at T = 0, {needs}"
    if load(0.0) <= 0:
        yield "motion.load", f"is {load(0.0):g} at T = 0; must be above zero there"
    lowest = load.range(inf if isinstance(until, str) else until)[0]
    flattest = case.motion.curvature.range(inf)[0]
    if flattest <= 0:
        yield "motion.curvature", f"goes down to {flattest:g}; must stay above zero"
    if case.motion.inertia == 0 and lowest <= 0:
        why = "without inertia the film balances it at every moment"
        yield "motion.load", f"goes down to {lowest:g}; must stay above zero, {why}"


def _outside(case: Case) -> Complaints:
    """The oil that carries a ball as it rolls must not all lie outside the grid.

    Far out P = lambda_bar U |X|/(5 H^2) with H = r^2/2 (`physics.far_field`): on r > w it carries 8 lambda_bar U/(5 w).
    """
    if case.starts_apart or case.geometry is not CIRCLE:
        return
    p = case.parameters
    needed = 1.6 * p.lambda_bar * abs(case.motion.entrainment(0.0)) / (HERTZ_LOAD * case.motion.load(0.0))
    if needed > WIDEST_HALF_WIDTH:
        beyond = f"reaches beyond the largest domain (half_width = {WIDEST_HALF_WIDTH:g})"
        in_si = f" = {rigid_film(p.M) * case.scales.film * 1e6:.3g} um" if case.scales else ""
        film = f"the film is a rigid ball's, {rigid_film(p.M):.3g} a^2/R{in_si}{AT_FORMULAS}"
        error = TooLight(f"contact: M = {p.M:.3g} is too low: the oil that carries the load {beyond}; {film}")
        error.case = case
        raise error
    if needed > case.solver.half_width:
        least = f"must be at least {needed:.3g} at M = {p.M:.3g}, where the oil far away carries much of the load"
        yield "solver.half_width", f"{least}; leave it out for a domain that is wide enough"


def _thermal(case: Case) -> Complaints:
    """Temperatures are those of a steady contact in SI, in which the film's formula has a meaning."""
    thermal, scales, eta0 = case.thermal, case.scales, case.oil.eta0
    if thermal is None:
        return
    if scales is None or eta0 is None:
        yield "thermal", "needs a contact in SI; give radius, load, ... or leave the section [thermal] out"
        return
    try:
        thermal.viscosity_of(eta0)
    except ValueError as error:
        yield "thermal.viscosity", str(error)
    pressure = scales.p_h * case.geometry.grown(case.motion.load(0.0))[1] / scales.E_prime
    speed = case.motion.entrainment(0.0) * scales.front_speed
    inlet = thermal.inlet_of(eta0, pressure, speed, case.motion.slide_to_roll)
    if not inlet.factor > 0:
        at = f"its formula gives phi_T = {inlet.factor:.3g} at the thermal loading L_t = {inlet.L_t:.3g}"
        yield "thermal.inlet", f'{at}; must be above zero, use "wilson-sheu" or "none"'


GIVEN = (_name, _reference, method_suits, _shapes)  # rules for what is given
COMPLETE = (  # rules for a case with its defaults, in the order in which they are looked at
    oil_is_complete,
    _rheology,
    _scales,
    _pressure_scale,
    _time,
    _drive,
    _supported,
    _geometry,
    _grid,
    _layer,
    _schedule,
    _motion,
    roughness_fits,
    rough_surfaces,
    _thermal,
    _outside,  # last: see `TooLight`
)
