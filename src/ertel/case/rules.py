"""The rules for valid cases.  Every rule raises a ValueError that names the field, its value and what is allowed."""

from collections.abc import Mapping, Sequence
from dataclasses import is_dataclass
from math import cbrt, inf

import numpy as np

from ertel.case.conditions import MOES_L, MOES_M, REDUCED, Conditions, Kind
from ertel.case.records import checked, scaled, show
from ertel.case.sections import (
    METHODS,
    ROLLING_UNTIL,
    WIDEST_HALF_WIDTH,
    Drive,
    Output,
    Schedule,
    Solver,
    Stop,
    Thermal,
    Time,
)
from ertel.numerics import grid
from ertel.physics.geometry import CIRCLE, HERTZ_LOAD, ContactMotion, Geometry, far_film
from ertel.physics.lubricant import DowsonHigginson, Oil
from ertel.physics.motion import Motion, Track
from ertel.physics.registry import FLUIDITY_LAWS
from ertel.physics.scales import Parameters, Scales
from ertel.physics.surfaces import Feature
from ertel.physics.units import ABOVE_ZERO, NOT_NEGATIVE, Bounds, Unit, plain

LONGEST_NAME = 100  # bytes: a file name may have 255, and a run's directory has temporary ones made of it
LONGEST_TEXT = 1000  # characters of the source of an oil's data
LONGEST_RUN = 1e5  # t0; an impact lasts about 3
MOST_STEPS = 1e7  # of a fixed length
MOST_MAPS = 1e5
LARGEST_OUTPUT = 1e11  # bytes of the maps, uncompressed
FIELDS = 6  # pressure, film, oil, two components of the shear stress, power loss
SMALLEST_RADIUS = 1.2  # of a radial grid: the contact grows to radius 1 and needs an inlet
TRANSIENT = 'solver.method = "transient"'


def check_name(name: str) -> None:
    """A name becomes a directory: it must be a plain file name on every system, and safe to print."""
    if not isinstance(name, str):
        raise ValueError(f"name = {show(name)}: must be a string")
    if name != plain_name(name):
        raise ValueError(
            f"name = {show(name)}: must be a plain file name: visible characters without / \\ and :, not starting with "
            f"a dot, at most {LONGEST_NAME} bytes"
        )


def plain_name(text: str) -> str:
    """The text as a plain file name: "_" for what is not allowed, no dot in front, cut; "" if nothing is left."""
    visible = "".join(c if c.isprintable() and c not in "/\\:" else "_" for c in text)
    return visible.lstrip(".").encode()[:LONGEST_NAME].decode(errors="ignore")


def check_reference(oil: Oil) -> None:
    """The source of the data is printed with the results: one line without control characters."""
    text = oil.reference
    if not isinstance(text, str) or not text.isprintable() or len(text) > LONGEST_TEXT:
        raise ValueError(
            f"lubricant.reference = {show(text)}: must be one line of visible characters, at most {LONGEST_TEXT}"
        )


def check_method(kind: Kind, solver: Solver) -> None:
    """Each kind of contact has its own methods; a radial grid has no inlet."""
    methods = METHODS[kind]
    if solver.method not in methods:
        allowed = " or ".join(f'"{name}"' for name in methods)
        raise ValueError(f'solver.method = "{solver.method}": must be {allowed} with contact.kind = "{kind}"')
    if solver.method == "radial" and solver.inlet is not None:
        raise ValueError(f"solver.inlet = {solver.inlet}: a radial grid has none; leave it out")


def check_oil(oil: Oil, scales: Scales | None) -> None:
    """A physical contact needs the data of its oil."""
    for key, example in {"eta0": "40 mPa*s", "alpha": "22 / GPa"}.items() if scales else ():
        if getattr(oil, key) is None and not (key == "alpha" and oil.is_isoviscous):
            raise ValueError(f'lubricant.{key}: missing, a physical contact needs it, for example "{example}"')


def check_rheology(oil: Oil, scales: Scales | None, solver: Solver) -> None:
    """An oil that thins under shear has a stress in Pa, and flows on the 2-D grid only."""
    law = checked(oil.fluidity_law, "lubricant.rheology")
    if oil.is_newtonian:
        return
    given = f'lubricant.rheology = {{ law = "{FLUIDITY_LAWS.name_of(law)}", ... }}'
    if scales is None:
        raise ValueError(
            f"{given}: has stresses in Pa, which a dimensionless case has not; give the contact in SI or "
            'lubricant.rheology = "newtonian"'
        )
    if solver.method == "radial":
        raise ValueError(
            f'{given}: solver.method = "radial" is for Newtonian oils only; use solver.method = "2d" or '
            'lubricant.rheology = "newtonian"'
        )


def check_scales(scales: Scales | None, parameters: Parameters) -> None:
    """The scales and parameters of the contact must be of a sane size, like its values."""
    numbers = {**(vars(scales) if scales else {}), **vars(parameters), "M": parameters.M, "L": parameters.L}
    bounds: Mapping[str, Unit | Bounds] = {"alpha_bar": NOT_NEGATIVE, "R": REDUCED, "M": MOES_M, "L": MOES_L}
    for name, value in numbers.items():
        complaint = bounds.get(name, ABOVE_ZERO).complaint(value)
        if complaint:
            given = f"its values together give {name} = {show(value)}"
            raise ValueError(f"contact: {given}, which {complaint}; check their units")


def check_pressure_scale(oil: Oil, scales: Scales | None, parameters: Parameters) -> None:
    """A pressure-dependent law needs a pressure scale."""
    if scales or parameters.alpha_bar:
        return
    if not oil.is_isoviscous:
        raise ValueError(f"contact.L = 0: must be above zero with lubricant.viscosity = {show(oil.viscosity)}")
    if oil.density == "dowson-higginson" or isinstance(oil.density, DowsonHigginson):
        raise ValueError(
            'lubricant.density = "dowson-higginson": needs a pressure scale, which a dimensionless isoviscous case '
            'does not have; allowed: density = "incompressible", or physical input'
        )


def check_fields(drive: Drive | None, time: Time | None, output: Output | None, roughness: Sequence[Feature]) -> None:
    """Every field of the sections must have a value that its mark allows."""
    for name, section in {"time": time, "output": output, "motion": drive}.items():
        if section is not None:
            checked(section, name)
    for number, feature in enumerate(roughness, 1):
        if not (is_dataclass(feature.shape) and hasattr(feature.shape, "heights")):
            kind = type(feature.shape).__name__
            raise ValueError(f"roughness[{number}].shape = {kind}: must be a dataclass with a method heights(X, Y)")
        checked(feature.shape, f"roughness[{number}]")


def check_time(kind: Kind, solver: Solver, time: Time | None, output: Output | None) -> None:
    """A steady contact has no time.  A rolling contact starts from its steady film and has no events."""
    if solver.method == "steady":
        for name, section in {"time": time, "output": output}.items():
            if section is not None:
                entry = _first_entry(name, section)
                raise ValueError(f"{entry}: a steady contact has no time; leave [{name}] out or use {TRANSIENT}")
    if kind == "impact" or time is None:
        return
    if time.start_approach is not None:
        raise ValueError(
            f"time.start_approach = {time.start_approach}: not for a rolling contact, its start is the steady film"
        )
    if isinstance(time.until, str):
        raise ValueError(
            f'time.until = "{time.until}": is an event of an impact; a rolling contact needs a time, in units t0'
        )


def check_schedule(time: Time, output: Output, solver: Solver, schedule: Schedule) -> None:
    """A run must end after a reasonable number of steps, with maps that fit on a disk."""
    end = schedule.duration
    if end > LONGEST_RUN:
        raise ValueError(f"time.until = {show(time.until)}: is {end:g} t0; must be at most {LONGEST_RUN:g} t0")
    if schedule.step and end / schedule.step > MOST_STEPS:
        raise ValueError(
            f"time.step = {show(time.step)}: needs {end / schedule.step:.3g} steps; must be at least "
            f"{end / MOST_STEPS:.3g} t0, for {MOST_STEPS:g} steps at most"
        )
    maps = end / schedule.interval
    nodes = solver.nodes if solver.method == "radial" else solver.nodes**2
    size = maps * FIELDS * 8 * nodes  # in double precision
    if maps > MOST_MAPS or size > LARGEST_OUTPUT:
        raise ValueError(
            f"output.interval = {show(output.interval)}: gives {maps:.3g} maps with {size / 1e9:.3g} GB; at most "
            f"{MOST_MAPS:g} and {LARGEST_OUTPUT / 1e9:g} GB are allowed, take a longer interval or fewer nodes"
        )


def _first_entry(name: str, section: Time | Output) -> str:
    """The first field of a section that differs from its default, for messages: time.until = 5.0."""
    usual = type(section)()
    for key, value in vars(section).items():
        if value != getattr(usual, key):
            return f"{name}.{key} = {show(value)}"
    return name


def check_drive(kind: Kind, contact: Conditions, drive: Drive | None) -> None:
    """[motion] must not repeat what [contact] gives."""
    if drive is None:
        return
    if drive.slide_to_roll is not None and contact.speeds.slide_to_roll is not None:
        raise ValueError(
            f"motion.slide_to_roll = {drive.slide_to_roll}: belongs to dimensionless cases; with speeds in [contact] "
            "write contact.slide_to_roll, or contact.speed_1 and contact.speed_2"
        )
    if drive.inertia is not None and (kind == "impact" or contact.is_physical):
        instead = (
            "for an impact it follows from its scales"
            if kind == "impact"
            else "give contact.mass or contact.ball_density"
        )
        raise ValueError(f"motion.inertia = {drive.inertia}: belongs to dimensionless rolling cases; {instead}")
    if kind == "impact" and drive.entrainment is not None and contact.speeds.mean is not None:
        raise ValueError(
            f"motion.entrainment = {show(drive.entrainment)} and contact.mean_speed = {contact.mean_speed} m/s "
            "are given together; allowed: one of them"
        )


def check_geometry(solver: Solver, contact: Conditions, motion: Motion) -> None:
    """The radial method is for circular contacts; an angle needs something that is entrained."""
    if contact.entrainment_angle is not None and not motion.flows:
        raise ValueError(
            f"{contact.entry('entrainment_angle')}: nothing is entrained; leave it out, or give motion.entrainment or "
            "contact.mean_speed"
        )
    if solver.method == "radial" and contact.geometry is not CIRCLE:
        raise ValueError(
            f'solver.method = "radial": is for circular contacts, this one has R_x/R_y = {contact.ratio:.6g}; use '
            'solver.method = "2d"'
        )
    if solver.method == "radial" and solver.half_width_y is not None:
        raise ValueError(f"solver.half_width_y = {solver.half_width_y}: a radial grid has none; leave it out")


def reverses(contact: Conditions, drive: Drive, time: Time | None) -> bool:
    """Whether the entrainment speed changes sign during a run in time."""
    if drive.entrainment is None:
        return False
    until = None if time is None else scaled(time, contact.scales, "time").until
    end = ROLLING_UNTIL if until is None or isinstance(until, str) else plain(until)
    signal = scaled(drive, contact.scales, "motion").entrainment
    assert signal is not None
    least, most = signal.range(end)
    return least < 0 < most


def check_layer(
    oil: Oil, track: Track | None, solver: Solver, geometry: Geometry, motion: Motion, features: Sequence[Feature]
) -> None:
    """The layers of oil are given in one way, move with the flow, cover the roughness and leave the grid's edge dry."""
    if track is None:
        return
    if oil.layer is not None and (oil.layer_1 is not None or oil.layer_2 is not None):
        raise ValueError(f"lubricant.layer = {show(oil.layer)}: give layer, or layer_1 and layer_2")
    if oil.layer is None and motion.flows and abs(motion.slide_to_roll) > 2:
        raise ValueError(
            f"lubricant.layer_1, layer_2: at slide_to_roll = {motion.slide_to_roll:g} one surface takes its oil out of "
            "the inlet; give layer, the oil that enters per area at the entrainment speed"
        )
    if solver.method == "radial" and len(track.points) > 1:
        raise ValueError(
            f'lubricant.layer = {show(oil.layer)}: solver.method = "radial" takes a uniform layer; use '
            'solver.method = "2d" or one thickness'
        )
    thinnest, thickest = track.extremes
    for number, feature in enumerate(features, 1):
        for key in ("amplitude", "rms"):
            height = getattr(feature.shape, key, 0.0)
            if thinnest < abs(height):
                raise ValueError(
                    f"lubricant.layer = {thinnest:.4g} a^2/R: must be at least roughness[{number}].{key} = "
                    f"{height:.4g} a^2/R; a layer of the same thickness everywhere does not lie on a rougher surface"
                )
    across = solver.half_width_y or solver.half_width
    contact = ContactMotion(geometry.dry_approach(1.0), 0.0, 1.0, 0.0)
    X, Y = np.array([solver.inlet or solver.half_width, 0.0]), np.array([0.0, across])
    film = float(far_film(X, Y, contact, geometry).min())
    if thickest > film / 2:
        raise ValueError(
            f"lubricant.layer = {thickest:.4g} a^2/R: the oil would reach the edge of the grid, where the gap "
            f"of the dry contact is {film:.4g}; must be at most half of that; leave it out (the gap is full) "
            "or use a wider solver.half_width"
        )


def check_grid(solver: Solver, geometry: Geometry) -> None:
    """A grid must be large enough, contain the contact, and be one that can be coarsened."""
    if solver.method == "radial":
        if solver.half_width < SMALLEST_RADIUS:
            raise ValueError(f"solver.half_width = {solver.half_width}: must be at least {SMALLEST_RADIUS}")
        return
    try:
        grid.check_nodes(solver.nodes)
        across = grid.nodes_across(solver.nodes, (solver.half_width_y or solver.half_width) / solver.half_width)
        grid.check_coarsening(grid.Grid(solver.nodes, across, 1.0))
    except ValueError as error:
        raise ValueError(f"solver.{error}") from error
    along_x, along_y = geometry.extent
    for name, width, reach in (("", solver.half_width, along_x), ("_y", solver.half_width_y, along_y)):
        if width is not None and not width > reach:
            raise ValueError(
                f"solver.half_width{name} = {width}: must be greater than {reach:g}, so that the contact lies inside "
                "the grid"
            )
    if solver.inlet is not None and not along_x < solver.inlet < 2 * solver.half_width - along_x:
        raise ValueError(
            f"solver.inlet = {solver.inlet}: must be above {along_x:g} and below "
            f"{2 * solver.half_width - along_x:g} = 2 half_width - {along_x:g}, so that the contact lies inside the "
            "grid"
        )


def check_outside(solver: Solver, parameters: Parameters, geometry: Geometry, motion: Motion) -> None:
    """The oil that carries a ball as it rolls must not all lie outside the grid.

    Far out P = lambda_bar U |X|/(5 H^2) with H = r^2/2 (`physics.geometry`): on r > w it carries 8 lambda_bar U/(5 w).
    """
    speed, load = abs(motion.entrainment(0.0)), motion.load(0.0)
    needed = 1.6 * parameters.lambda_bar * speed / (HERTZ_LOAD * load)
    if geometry is not CIRCLE or solver.half_width >= needed:
        return
    if needed > WIDEST_HALF_WIDTH:
        raise ValueError(
            f"contact: M = {parameters.M:.3g} is too low: the oil that carries the load reaches beyond the largest "
            f"domain (half_width = {WIDEST_HALF_WIDTH:g}); the film is that of rigid bodies, see the formulas"
        )
    raise ValueError(
        f"solver.half_width = {solver.half_width:g}: must be at least {needed:.3g} at M = {parameters.M:.3g}, where "
        "the oil far away carries much of the load; leave it out for a domain that is wide enough"
    )


def check_motion(kind: Kind, solver: Solver, motion: Motion, until: Stop | float) -> None:
    """The method must be able to compute the motion, and a solution must exist."""
    if solver.method == "radial" and any((*motion.load.range(inf), *motion.entrainment.range(inf))):
        raise ValueError('motion: the radial method is for a free ball on a track at rest; use solver.method = "2d"')
    if until == "rebound" and motion.load.range(inf)[1] > 0:
        raise ValueError('time.until = "rebound": a ball under a load may never leave; give a time, in units t0')
    if kind == "rolling":
        _check_rolling(solver, motion, inf if isinstance(until, str) else until)


def _check_rolling(solver: Solver, motion: Motion, until: float) -> None:
    if solver.method == "steady":
        for name in ("load", "entrainment"):
            least, most = getattr(motion, name).range(inf)
            if least != most:
                raise ValueError(f"motion.{name}: varies in time from {least:g} to {most:g}; use {TRANSIENT}")
    if motion.entrainment(0.0) == 0:
        raise ValueError(
            "motion.entrainment: is 0 at T = 0, where a rolling contact needs a film; must not be zero there, a small "
            "speed will do"
        )
    if motion.load(0.0) <= 0:
        raise ValueError(f"motion.load: is {motion.load(0.0):g} at T = 0; must be above zero there")
    lowest = motion.load.range(until)[0]
    if motion.inertia == 0 and lowest <= 0:
        raise ValueError(
            f"motion.load: goes down to {lowest:g}; must stay above zero, without inertia the film balances it at "
            "every moment"
        )


def check_roughness(solver: Solver, motion: Motion, features: Sequence[Feature]) -> None:
    """The radial method needs smooth surfaces; a steady film needs roughness that does not change in time."""
    if solver.method == "radial" and features:
        raise ValueError('roughness: the radial method is for smooth surfaces; use solver.method = "2d"')
    for number, feature in enumerate(features, 1):
        moves = motion.travel(feature.surface, 1.0) != 0
        if solver.method == "steady" and moves and not getattr(feature.shape, "is_ridges_along_x", False):
            raise ValueError(
                f"roughness[{number}].surface = {feature.surface}: moves, so that its film is not steady; use "
                f"{TRANSIENT}, or a slide_to_roll at which it is at rest (surface 1: -2, surface 2: 2)"
            )


def check_thermal(thermal: Thermal, oil: Oil, scales: Scales | None, solver: Solver, motion: Motion) -> None:
    """Temperatures are those of a steady contact in SI, in which the film's formula has a meaning."""
    if solver.method != "steady":
        raise ValueError(
            f'thermal: is for a steady contact, and this one has solver.method = "{solver.method}"; leave the section '
            '[thermal] out, or use a rolling contact with solver.method = "steady"'
        )
    if scales is None or oil.eta0 is None:
        raise ValueError("thermal: needs a contact in SI; give radius, load, ... or leave the section [thermal] out")
    try:
        thermal.viscosity_of(oil.eta0)
    except ValueError as error:
        raise ValueError(f"thermal.viscosity = {show(thermal.viscosity)}: {error}") from error
    pressure = scales.p_h * cbrt(motion.load(0.0)) / scales.E_prime
    inlet = thermal.inlet(oil.eta0, pressure, motion.entrainment(0.0) * scales.front_speed, motion.slide_to_roll)
    if not inlet.factor > 0:
        raise ValueError(
            f"thermal.inlet_factor = {show(thermal.inlet_factor)}: its formula gives phi_T = {inlet.factor:.3g} at the "
            f'thermal loading L_t = {inlet.L_t:.3g}; must be above zero, use "wilson-sheu" or "none"'
        )
