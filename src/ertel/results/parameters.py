"""Parameters and scales of a case, and films by formulas, known before it is run.

This module imports neither JAX nor xarray, so that they are known at once.
"""

from collections.abc import Callable, Mapping
from typing import Any

from ertel.case.case import Case
from ertel.physics import film_formulas, line_films
from ertel.physics.film_formulas import FormulaFilm
from ertel.physics.geometry import Geometry, geometry
from ertel.physics.line_scales import LineParameters
from ertel.physics.materials import RHEOLOGY
from ertel.physics.registry import FLUIDITY_LAWS
from ertel.physics.scales import FlowDirection, HamrockDowson, Parameters, Scales, hamrock_dowson
from ertel.physics.units import Unit, fields_of
from ertel.results.variables import VARIABLES, named_with_unit, with_prefix


def parameters_of(case: Case) -> dict[str, float]:
    """The dimensionless parameters by name; with the shape of an ellipse and the angle of entrainment (degrees), or of
    a line.
    """
    p = case.parameters
    parameters = {"lambda_bar": p.lambda_bar, "alpha_bar": p.alpha_bar, "M": p.M, "L": p.L}
    if p.radius_ratio == 1.0:
        return parameters
    if isinstance(p, LineParameters):
        return {**parameters, "radius_ratio": 0.0, "length_ratio": p.hertz.reach}
    shape = {"radius_ratio": p.radius_ratio, "kappa": p.hertz.kappa, "entrainment_angle": case.contact.angle}
    return {**parameters, **shape, "M_BH": p.M_BH, "L_BH": p.L_BH}


def parameter_summary(case: Case) -> dict[str, Any]:
    """The parameters of a case, known before it is run.

    For a physical case U, G, W are those of Hamrock and Dowson (for an impact with load F* and speed a*/t0), and `si`
    holds the scales, named with their units.  For an impact also stokes, St = m v0/(6 pi eta0 R^2); trapped_film, the
    scale of the film in a*^2/R, at which a rigid ball stops; and in `si` contact_time_s, the contact time of the dry
    impact, and h_c_least_m and h_c_most_m, between which the central film of an elastic ball is expected.
    """
    p, s = case.parameters, case.scales
    falls = {"stokes": p.stokes, "trapped_film": p.trapped_film} if case.starts_apart else {}
    content: dict[str, Any] = {**parameters_of(case), **falls}
    if s is None:
        return content
    return {**content, **_ugw(case, s)._asdict(), "si": {**scale_values(case), **(_fall_in_si(p, s) if falls else {})}}


def _fall_in_si(p: Parameters, s: Scales) -> dict[str, float]:
    """The expected contact time, mass and films of an impact."""
    least, most = p.impact_films
    return {
        "contact_time_s": p.hertz.contact_time * s.t0,
        "mass_kg": s.ball_mass,
        "trapped_film_m": p.trapped_film * s.film,
        "h_c_least_m": least * s.film,
        "h_c_most_m": most * s.film,
    }


def rheology_of(case: Case) -> str:
    """The law of shear thinning of a case in words, and its source or why there is none, as far as known."""
    law = case.oil.rheology
    written = "Newtonian" if case.oil.is_newtonian or isinstance(law, str) else _in_words(law)
    reason = case.oil.reference.partition(RHEOLOGY)[2].partition(" Given:")[0].removeprefix("Newtonian, ").rstrip(".")
    return f"{written} ({reason})" if reason else written


def _in_words(law: Any) -> str:
    """A law of shear thinning with its numbers: "Ree-Eyring, tau0 = 5 MPa"."""
    parts = [getattr(law, "title", FLUIDITY_LAWS.name_of(law).title())]
    for name, field in fields_of(law).items():
        value = getattr(law, name)
        unit = field.mark.unit if isinstance(field.mark, Unit) else "1"
        parts.append(f"{name} = {with_prefix(value, unit)}" if isinstance(value, float | int) else _in_words(value))
    return ", ".join(parts)


def _ugw(case: Case, s: Scales) -> HamrockDowson:
    """Hamrock and Dowson's U, G, W of a physical case."""
    p = case.parameters
    eta0 = p.lambda_bar * s.t0 * s.a**2 * s.p_h / (12 * s.R**2)
    return hamrock_dowson(s, eta0, p.alpha_bar / s.p_h)


def scale_values(case: Case) -> dict[str, float]:
    """The SI scales of a physical case, named with their units; empty for a dimensionless one."""
    s = case.scales
    if s is None:
        return {}
    across = {} if s.hertz.radius_ratio == 1.0 else {"a_y_m": s.a_y}
    named = {"R_m": s.R, "E_prime_Pa": s.E_prime, "a_m": s.a, **across, "p_h_Pa": s.p_h, "delta_m": s.approach}
    speed = {"v0_m_per_s": s.speed} if case.starts_apart else {"u_m_m_per_s": s.front_speed}
    return named | {"F_N": s.load, "t0_s": s.t0} | speed


def values_in_si(values: Mapping[str, Any], scales: Scales, zero: float = 0.0) -> dict[str, float | None]:
    """Convert dimensionless values, by the name of their variable, to SI; what has no unit is left out.

    zero: T at t = 0.

    The names in SI end with the unit: H_c becomes h_c_m, P_max p_max_Pa.  H_c_error and H_c_extrapolated scale as H_c.
    """
    converted = {}
    for name, value in values.items():
        base = name.removesuffix("_error").removesuffix("_extrapolated")
        variable = VARIABLES.get(base)
        if variable is not None and variable.scale:
            key = named_with_unit(variable.si_name + name.removeprefix(base), variable.si_units)
            start = zero if name == "T" else 0.0
            converted[key] = None if value is None else (value - start) * variable.factor(scales)
    return converted


def geometry_of(about: Mapping[str, Any]) -> Geometry:
    """The dry contact and its directions, from a summary or the attributes of a Dataset."""
    ratio, angle = about.get("radius_ratio", 1.0), about.get("entrainment_angle", 0.0)
    return geometry(ratio, angle, about.get("length_ratio", 100.0))


def domain(case: Case) -> str:
    """The number of nodes and the reach of the grid, in words."""
    s = case.solver
    across = "" if s.half_width_y is None else f", {s.half_width_y:.4g} a across"
    if case.starts_apart:
        return f"{s.nodes} nodes to {s.half_width:.4g} a*{across}"
    inlet = s.inlet or s.half_width
    return f"{s.nodes} nodes, {inlet:.4g} a upstream to {2 * s.half_width - inlet:.4g} a downstream{across}"


def formula_films(case: Case, load: float = 1.0, entrainment: float = 1.0, curvature: float = 1.0) -> list[FormulaFilm]:
    """Film thickness of a rolling contact by every formula of `physics.film_formulas`, in the case's own a^2/R.

    Of the moment with the load w in F*, the speed U in u_m and the curvature c of the gap.  Empty for an impact, and
    without load or without speed, where the formulas have no meaning.  With layers of oil the flooded films, then
    what the layers leave of those that are made for such a contact.
    """
    speed = abs(entrainment)
    if case.starts_apart or load <= 0 or speed == 0:
        return []
    at, (size, pressure) = case.parameters.at(load, speed, curvature), case.geometry.grown(load, curvature)
    ugw, is_line = _ugw(case, case.scales) if case.scales else None, case.geometry.is_line
    ugw = ugw and HamrockDowson(ugw.U * speed * curvature, ugw.G, ugw.W * load * curvature ** (1 if is_line else 2))
    lines = line_films.line_films(at, case.lubricant, ugw) if is_line else None
    formulas = lines or film_formulas.films(at, ugw, case.contact.angle)
    unit = curvature * size**2  # the formulas' a^2/R is that of the moment
    flooded = [
        film._replace(central=film.central and film.central * unit, minimum=film.minimum and film.minimum * unit)
        for film in formulas
    ]
    if case.layer is None:
        return flooded
    oil = case.layer / float(case.lubricant.density(pressure))
    starved: Callable[[FormulaFilm, float], FormulaFilm] = line_films.starved if is_line else FormulaFilm.starved
    return [*flooded, *(starved(film, oil) for film in flooded if film.central and (film.inside or is_line))]


def regime(case: Case) -> str:
    """The regime of a rolling contact at T = 0 with its g_V and g_E, see `film_formulas.regime_of`; "" of an impact."""
    if case.starts_apart:
        return ""
    w, U, c = case.motion.moment(0.0)
    at = case.parameters.at(w, abs(U), c)
    if case.geometry.is_line:
        return line_films.regime_of_line(at.M, at.L)
    flow = FlowDirection.at(case.parameters.radius_ratio, case.contact.angle)
    M, L = flow.moes(at)
    g_V, g_E = film_formulas.regime_numbers(M, L)
    return f"{film_formulas.regime_of(M, L, flow.radius_ratio)} (g_V = {g_V:.3g}, g_E = {g_E:.3g})"
