"""The Python API for cases: `impact(...)`, `rolling(...)`, `Oil(...)`.

The keywords are the keys of case files.  A quantity is a float in SI or a text with a unit, "10 mm".  An amount (a time
of the run, a size of the roughness) is a plain number in the units of the case, or a text with a unit.
"""

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from typing import Any

from ertel.case.case import Case
from ertel.case.conditions import Conditions
from ertel.case.records import ConfigError, checked, law_data, oil_data, show
from ertel.case.sections import Output, Solver, Time
from ertel.case.thermal import Thermal
from ertel.inputs.case_files import parse_case
from ertel.inputs.names import MATERIAL_KEYS
from ertel.inputs.quantities import number_or_quantity, parse_quantity, plain_data, with_unit
from ertel.physics import lubricant
from ertel.physics.fluidity import Fluidity
from ertel.physics.lubricant import Density, Viscosity
from ertel.physics.registry import FLUIDITY_LAWS
from ertel.physics.surfaces import Feature, Shape
from ertel.physics.units import HEIGHT, TEMPERATURE, TIME, Quantity, marks

Number = float | str  # SI, or a text with a unit
Roughness = Sequence[Feature | Shape | Mapping[str, Any]]


def Oil(  # reads as the record that it makes
    eta0: Number | None = None,
    alpha: Number | None = None,
    viscosity: str | Viscosity = "roelands",
    density: str | Density = "dowson-higginson",
    p0: Number = lubricant.P0_ROELANDS,
    z: float | None = None,
    reference: str = "",
    rheology: str | Fluidity = "newtonian",
) -> lubricant.Oil:
    """An oil.

    Parameters
    ----------
    eta0, alpha : float or str
        Viscosity at ambient pressure (Pa s) and pressure-viscosity coefficient (1/Pa).
    viscosity, density : str or record
        "roelands", "barus", "isoviscous"; "dowson-higginson", "incompressible"; or the record of a registered law.
    p0, z : float or str
        Roelands' pressure (Pa) and exponent; z follows from eta0 and alpha if it is not given.
    reference : str
        Source of the data.
    rheology : str or record
        "newtonian", or the record of a law of shear thinning.

    Raises ValueError, naming the argument, for a value that is not allowed.

    Examples
    --------
    >>> Oil(eta0="18.6 mPa*s", alpha=20e-9).eta0
    0.0186
    """
    given = {"eta0": eta0, "alpha": alpha, "p0": p0}
    kinds = marks(lubricant.Oil)
    z, si = plain_data(z), {}
    for name, value in given.items():
        try:
            si[name] = None if value is None else number_or_quantity(value, kinds[name])  # type: ignore[arg-type]
        except ValueError as error:
            raise ConfigError(f"oil.{name} = {show(value)}: {error}") from error
    try:
        oil = lubricant.Oil(viscosity, density, si["eta0"], si["alpha"], si["p0"] or p0, z, reference, rheology)  # type: ignore[arg-type]
        return checked(oil, "oil")
    except ValueError as error:
        raise ConfigError(str(error)) from error


def quantity(text: str) -> Quantity:
    """A length or a time with its unit, for records of roughness and signals: quantity("20 nm"), quantity("5 ms")."""
    for unit in (HEIGHT, TIME):
        try:
            found = parse_quantity(plain_data(text), unit)
        except ValueError:
            continue
        if found is not None:
            return Quantity(found, unit.unit)
    raise ConfigError(f"text = {show(text)}: must be a length or a time with its unit, such as '20 nm' or '5 ms'")


def impact(
    *,
    M: float | None = None,
    L: float | None = None,
    lambda_bar: float | None = None,
    alpha_bar: float | None = None,
    radius_ratio: float | None = None,
    radius: Number | None = None,
    radius_1: Number | None = None,
    radius_2: Number | None = None,
    radius_x: Number | None = None,
    radius_y: Number | None = None,
    radius_x_1: Number | None = None,
    radius_y_1: Number | None = None,
    radius_x_2: Number | None = None,
    radius_y_2: Number | None = None,
    entrainment_angle: Number | None = None,
    mass: Number | None = None,
    ball_density: Number | None = None,
    speed: Number | None = None,
    drop_height: Number | None = None,
    mean_speed: Number | None = None,
    slide_to_roll: float | None = None,
    E_prime: Number | None = None,
    E1: Number | None = None,
    nu1: float | None = None,
    E2: Number | None = None,
    nu2: float | None = None,
    material_1: str | None = None,
    material_2: str | None = None,
    oil: lubricant.Oil | str | None = None,
    temperature: Number | None = None,
    rheology: str | Mapping[str, Any] | Fluidity | None = None,
    method: str | None = None,
    nodes: int | None = None,
    half_width: float | None = None,
    half_width_y: float | None = None,
    inlet: float | None = None,
    tolerance: float | None = None,
    fold: bool | None = None,
    motion: Mapping[str, Any] | None = None,
    roughness: Roughness = (),
    start_approach: float | None = None,
    until: float | str | None = None,
    step: float | str | None = None,
    time_tolerance: float | None = None,
    interval: float | str | None = None,
    name: str = "",
) -> Case:
    """The impact of a ball on an oiled surface.

    Parameters
    ----------
    M, L : float
        Moes' load and lubricant parameters; or `lambda_bar`, `alpha_bar`; or physical input:
    radius, radius_1, radius_2 : float or str
        Radius of a ball on a plate, or of two balls of which the first moves (m).
    radius_x, radius_y, radius_x_1, radius_y_1, radius_x_2, radius_y_2 : float or str
        Reduced radii of an elliptical contact along its principal axes x and y (m), or those of each body: negative
        where concave, left out where plane.  radius_ratio : float, R_x/R_y of a dimensionless contact.
    entrainment_angle : float or str
        From the axis x to the direction of entrainment (degrees).
    mass, ball_density, speed, drop_height : float or str
        Mass (kg) or density (kg/m^3) of the ball; its speed at first touch (m/s) or its drop height (m).
    mean_speed, slide_to_roll : float or str
        Mean speed of the surfaces along x (m/s) and (u1 - u2)/u_m: a track that moves under the ball.
    E_prime, E1, nu1, E2, nu2 : float or str
        Reduced modulus (Pa), or Young's moduli (Pa) and Poisson's ratios.
    material_1, material_2 : str
        Or the names of the materials, "steel", see `ertel.materials`; the first one also gives the ball its density.
    oil : Oil or str
        Required for a physical contact; the default of a dimensionless contact is a typical mineral oil.  Or the name
        of an oil, "squalane", see `ertel.oils`, which brings its law of shear thinning where one is known, with its
    temperature : float or str
        Temperature in the inlet (K, or "40 degC").
    rheology : str, mapping or record
        How the oil thins under shear, instead of the oil's own: {"law": "ree-eyring", "tau0": "5 MPa"} as in case
        files, the record of a law, or "newtonian".  "carreau" takes its data from a named oil that has them.
    method : "2d" or "radial"
        On a square grid, or along the radius (smooth impacts, fast).
    nodes, half_width, half_width_y, inlet, tolerance, fold
        Grid and tolerance, see `ertel.Solver`.
    motion : mapping
        load, entrainment (signals), slide_to_roll, inertia: as [motion] of a case file.
    roughness : sequence
        Shapes, features (a shape on surface 1 or 2), or mappings as [[roughness]] of a case file.
    start_approach, until, step, time_tolerance, interval
        Start, end, steps and maps, see `ertel.Time`; until: "max-approach", "rebound", or a time.
    name : str
        For titles and directories.

    Raises ConfigError (a ValueError) that names the field, its value and what is allowed.

    Examples
    --------
    >>> case = impact(radius=0.01, ball_density=7850, speed=0.1, E1=210e9, nu1=0.3, E2=210e9, nu2=0.3,
    ...               oil=Oil(eta0=0.0186, alpha=20e-9))
    >>> round(case.scales.p_h / 1e9, 2)
    1.42
    """
    return _case("impact", locals())


def rolling(
    *,
    M: float | None = None,
    L: float | None = None,
    lambda_bar: float | None = None,
    alpha_bar: float | None = None,
    radius_ratio: float | None = None,
    radius: Number | None = None,
    radius_1: Number | None = None,
    radius_2: Number | None = None,
    radius_x: Number | None = None,
    radius_y: Number | None = None,
    radius_x_1: Number | None = None,
    radius_y_1: Number | None = None,
    radius_x_2: Number | None = None,
    radius_y_2: Number | None = None,
    entrainment_angle: Number | None = None,
    load: Number | None = None,
    mean_speed: Number | None = None,
    slide_to_roll: float | None = None,
    speed_1: Number | None = None,
    speed_2: Number | None = None,
    mass: Number | None = None,
    ball_density: Number | None = None,
    E_prime: Number | None = None,
    E1: Number | None = None,
    nu1: float | None = None,
    E2: Number | None = None,
    nu2: float | None = None,
    material_1: str | None = None,
    material_2: str | None = None,
    oil: lubricant.Oil | str | None = None,
    temperature: Number | None = None,
    rheology: str | Mapping[str, Any] | Fluidity | None = None,
    method: str | None = None,
    nodes: int | None = None,
    half_width: float | None = None,
    half_width_y: float | None = None,
    inlet: float | None = None,
    tolerance: float | None = None,
    fold: bool | None = None,
    motion: Mapping[str, Any] | None = None,
    roughness: Roughness = (),
    thermal: Mapping[str, Any] | None = None,
    until: float | str | None = None,
    step: float | str | None = None,
    time_tolerance: float | None = None,
    interval: float | str | None = None,
    name: str = "",
) -> Case:
    """The contact of a ball that rolls and slides on an oiled surface.

    Parameters
    ----------
    M, L, lambda_bar, alpha_bar, radius_ratio, E_prime, E1, nu1, E2, nu2, roughness, name
    radius, radius_1, radius_2, radius_x, radius_y, radius_x_1, radius_y_1, radius_x_2, radius_y_2, entrainment_angle
    material_1, material_2, oil, temperature, rheology
        As for `impact`; a material gives no density here, because a ball without one has no inertia.
    load : float or str
        Static load (N).
    mean_speed, slide_to_roll, speed_1, speed_2 : float or str
        Mean speed of the surfaces along x (m/s) and (u1 - u2)/u_m, or both speeds.
    mass, ball_density : float or str
        Mass or density of the ball, for its inertia in a transient run.
    method : "steady" or "transient"
        "transient" if anything changes in time: load, speed, moving roughness.
    motion : mapping
        load, entrainment (signals), slide_to_roll, inertia: as [motion] of a case file.
    thermal : mapping
        Data for the temperatures of a steady contact, as [thermal] of a case file (`ertel.case.thermal.Thermal`); {}
        takes all of them from the oil and the materials that are named.
    nodes, half_width, half_width_y, inlet, tolerance, fold, until, step, time_tolerance, interval
        See `ertel.Solver` and `ertel.Time`.

    Raises ConfigError (a ValueError) that names the field, its value and what is allowed.

    Examples
    --------
    >>> rolling(M=200, L=10, nodes=129).solver.method
    'steady'
    """
    return _case("rolling", locals())


def _case(kind: str, given: Mapping[str, Any]) -> Case:
    """The case of keyword arguments, read in the same way as a case file."""
    wanted = {key: plain_data(value) for key, value in given.items() if value is not None}
    if not isinstance(wanted.get("oil"), lubricant.Oil | str | None):
        said = show(wanted["oil"])
        raise ConfigError(f"oil = {said}: must be made by Oil(eta0=..., alpha=...), or be the name of an oil")
    time = {"tolerance" if key == "time_tolerance" else key: wanted[key] for key in TIME_KEYS if key in wanted}
    records, tables = _sorted(wanted["roughness"])
    sections: dict[str, Any] = {
        "name": given["name"],
        "contact": {"kind": kind, **_conditions(wanted)},
        "lubricant": _lubricant(wanted),
        "solver": {f.name: wanted[f.name] for f in fields(Solver) if f.name in wanted},
        "motion": wanted.get("motion"),
        "thermal": _thermal(wanted.get("thermal")),
        "roughness": tables,
        "time": time or None,
        "output": {f.name: wanted[f.name] for f in fields(Output) if f.name in wanted} or None,
    }
    case = parse_case({name: section for name, section in sections.items() if section is not None})
    try:
        return replace(case, roughness=(*case.roughness, *records)) if records else case
    except ValueError as error:
        raise ConfigError(str(error)) from error


def _lubricant(wanted: Mapping[str, Any]) -> dict[str, Any] | None:
    """The section [lubricant] of an oil, or of the name of an oil and its temperature."""
    oil = wanted.get("oil")
    data = oil_data(oil) if isinstance(oil, lubricant.Oil) else {} if oil is None else {"oil": oil}
    if "temperature" in wanted:
        data["temperature"] = with_unit(wanted["temperature"], TEMPERATURE)
    if isinstance(oil, lubricant.Oil) and oil.is_newtonian:
        del data["rheology"]  # the default of an Oil, not a wish
    if "rheology" in wanted:
        law = wanted["rheology"]
        data["rheology"] = law_data(law, FLUIDITY_LAWS) if hasattr(law, "fluidity") else law
    return data or None


def _thermal(given: Any) -> Any:
    """The section [thermal], numbers with their SI unit."""
    kinds = marks(Thermal)
    return {k: with_unit(v, kinds.get(k)) for k, v in given.items()} if isinstance(given, Mapping) else given


TIME_KEYS = (*(f.name for f in fields(Time) if f.name != "tolerance"), "time_tolerance")


def _conditions(wanted: Mapping[str, Any]) -> dict[str, Any]:
    """The keys of [contact], numbers of quantities with their SI unit."""
    kinds = marks(Conditions)
    names = (*MATERIAL_KEYS, *(f.name for f in fields(Conditions)))
    found = {name: wanted[name] for name in names if name in wanted}
    return {key: with_unit(value, kinds.get(key)) for key, value in found.items()}


def _sorted(roughness: Roughness) -> tuple[list[Feature], list[dict[str, Any]]]:
    """Records as features, and tables."""
    if isinstance(roughness, str | Mapping) or not isinstance(roughness, Sequence):
        raise ConfigError(f"roughness = {show(roughness)}: must be a list of shapes, features or tables")
    records: list[Feature] = []
    tables: list[dict[str, Any]] = []
    for item in roughness:
        if isinstance(item, Mapping):
            tables.append(dict(item))
        else:
            records.append(item if isinstance(item, Feature) else Feature(item))
    return records, tables
