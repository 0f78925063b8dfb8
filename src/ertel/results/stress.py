"""Stresses in the bodies below the film, from its pressure and its shear stress.

Each body is a half space with its own Poisson's ratio (`physics.stress`), with z from its surface into it.  Body 1 has
the speed u1; in an impact it is the ball.  A case without dimensions does not know a/R, and so no shear stress in p_h,
nor the bodies: its stresses are those of the pressure alone, with `USUAL_RATIO`.

Bodies are elastic: a von Mises stress above the yield stress says that they yield, and not what happens then.
"""

from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ertel.case.case import Case
from ertel.physics.stress import Stresses, stress_waves, tresca, von_mises
from ertel.physics.units import POSITION, si_numbers
from ertel.results.dataset import indexed, to_netcdf, with_units
from ertel.results.profiles import ALONG, At, fields_at
from ertel.results.variables import to_si, variable_attributes

Values = NDArray[np.float64]
Maps = Mapping[Any, Any]  # arrays, or a Dataset, by name
USUAL_RATIO = 0.3  # Poisson's ratio of a body of which only the reduced modulus is known
DEEPEST = 1.5  # half widths of the contact: no largest stress lies below
FEW, MANY = 8, 30  # depths of a search, and of a section
NAMES = {
    **{f"sigma_{n}{n}": f"normal stress along {n}, positive in tension" for n in "xyz"},
    **{f"sigma_{n}": f"shear stress {n}" for n in ("xy", "xz", "yz")},
    **{"von_mises": "von Mises stress", "shear": "largest shear stress of all planes"},
}
NODES_OF_RINGS = 129  # a side of the plane on which an axisymmetric film is spread


class Loads(NamedTuple):
    """The loads on a body.

    x, y: of the nodes (a).  p, q_x, q_y: pressure and shear stress, the force per area on this body (p_h), shape
    (n_y, n_x).  nu: Poisson's ratio of the body.
    """

    x: Values
    y: Values
    p: Values
    q_x: Values
    q_y: Values
    nu: float


def shear_on_body(fields: Mapping[str, Values], spacing: float, body: int) -> tuple[Values, Values]:
    """The shear stress that the film exerts on a body along X and Y, in p_h a/R.

    -tau_m - (H/2) grad P on body 1, tau_m - (H/2) grad P on body 2, 0 where P = 0; see `equations.account`.  Its
    integral over the load is minus the friction coefficient of the surface.  fields: P, H, tau_x, tau_y, (n_y, n_x),
    and P_asperity, the part of P that drives no oil; tau_m has the friction of asperities.
    """
    P, sign = fields["P"], -1.0 if body == 1 else 1.0
    of_oil = P - fields.get("P_asperity", 0.0)
    slopes = [np.gradient(of_oil, spacing, axis=axis) if P.shape[axis] > 1 else 0.0 * P for axis in (1, 0)]
    stresses = [sign * fields[f"tau_{n}"] - 0.5 * fields["H"] * each for n, each in zip("xy", slopes, strict=True)]
    return np.where(P > 0.0, stresses[0], 0.0), np.where(P > 0.0, stresses[1], 0.0)


def loads_on(case: Case, maps: Maps, body: int = 1) -> Loads:
    """The loads on a body by the maps of a run at one moment, by name, with their axes.

    With heat the shear stress is that of the warm film.
    """
    nu = case.contact.nu1 if body == 1 else case.contact.nu2
    unit = case.scales.a_over_R if case.scales else 0.0
    fields = {name: np.atleast_2d(maps[name]) for name in ("P", "P_asperity", "H") if name in maps}
    for name in ("tau_x", "tau_y"):
        fields[name] = np.atleast_2d(maps.get(f"{name}_warm", maps.get(name, 0.0 * fields["P"])))
    if "r" in maps:
        r = np.asarray(maps["r"])
        x = y = np.linspace(-r[-1], r[-1], NODES_OF_RINGS)
        fields = {name: np.interp(np.hypot(x[:, None], x), r, each[0]) for name, each in fields.items()}
    else:
        x, y = np.asarray(maps["X"]), np.asarray(maps.get("Y", [0.0]))
    q_x, q_y = shear_on_body(fields, float(x[1] - x[0]), body)
    return Loads(x, y, fields["P"], unit * q_x, unit * q_y, USUAL_RATIO if nu is None else nu)


def usual_depths(loads: Loads, number: int) -> Values:
    """Depths (a) from the surface to 1.5 half widths of the contact, denser near the surface."""
    along_x, along_y = (loads.p.sum(axis) / loads.p.sum() for axis in (0, 1))
    variances = [share @ (place - share @ place) ** 2 for share, place in ((along_x, loads.x), (along_y, loads.y))]
    # of a Hertz pressure 1/5 of the half width squared, of that of a line 1/4
    size = np.sqrt(5.0 * min(variances) if loads.y.size > 1 else 4.0 * variances[0])
    return np.asarray(DEEPEST * size * np.linspace(0.0, 1.0, number + 1) ** 2)


def below(loads: Loads, depths: Iterable[float], row: int | None = None) -> Iterator[Stresses]:
    """The stresses (p_h) at each of the depths (a), at all nodes or in one row of them."""
    from ertel.numerics.halfspace import Waves  # JAX takes long to import

    rows, columns = loads.p.shape
    waves = Waves(rows, columns, float(loads.x[1] - loads.x[0]))
    amplitudes = [waves.amplitudes(load) if load.any() else 0.0 for load in (loads.p, loads.q_x, loads.q_y)]
    for depth in depths:
        yield Stresses(*waves.below(depth, partial(stress_waves, nu=loads.nu), amplitudes, row))


def stress(
    case: Case, dataset: xr.Dataset, at: At = None, body: int = 1, depths: Any = None, along: str | None = "x"
) -> xr.Dataset:
    """The stresses in a body at a moment of a run, see `runs.result.Result.stress`; in SI where the case is."""
    if body not in (1, 2):
        raise ValueError(f"body = {body!r}: must be 1 or 2")
    if along not in (*ALONG, None) or (along == "y" and case.geometry.is_line):
        raise ValueError(f'along = {along!r}: must be "x", "y" (not of a line contact), or None for all nodes')
    maps, moment = fields_at(dataset, ("P", "P_asperity", "H", "tau_x", "tau_y", "tau_x_warm", "tau_y_warm"), at)
    loads = loads_on(case, maps, body)
    if not loads.p.any():
        raise ValueError(f"at = {at!r}: the film carries no load there")
    side = float(np.ptp(loads.x if case.geometry.is_line else min(loads.x, loads.y, key=np.ptp)))
    Z = usual_depths(loads, MANY) if depths is None else _in_a(case, depths, side)
    row = int(np.abs(loads.y).argmin())
    found = Stresses(*map(np.stack, zip(*below(loads, Z, row if along == "x" else None), strict=True)))
    fields = {f"sigma_{name}": each for name, each in found._asdict().items()}
    fields |= {"von_mises": von_mises(found), "shear": tresca(found)}
    axes = {"Z": Z, "Y": loads.y[row : row + 1] if along == "x" else loads.y, "X": loads.x}
    about = {name: variable_attributes(name, case.scales, case.geometry.is_line) for name in ("P", *axes)}
    described = {name: (*indexed(name, [name], axis), about[name]) for name, axis in axes.items()}
    for name, each in fields.items():
        words = {"long_name": NAMES[name], "symbol": name, **({"si_name": name} if case.scales else {})}
        described[name] = list(axes), each, {**about["P"], **words}
    data = xr.Dataset(described, attrs={**dataset.attrs, "moment": moment, "body": body, "poisson_ratio": loads.nu})
    if along is not None or case.geometry.is_line:
        data = data.sel({"X" if along == "y" else "Y": 0.0}, method="nearest", drop=True)
    return to_si(data) if case.scales else data


def write_stress(data: xr.Dataset, directory: Path, to: str = "csv") -> Path:
    """Write the stresses of a section, along "x" or "y", as CSV with a row for each node, or as NetCDF 3; its path.

    Names in SI end with their unit: z_m, von_mises_Pa.
    """
    directory.mkdir(parents=True, exist_ok=True)
    path = directory / f"stress_{str(data['von_mises'].dims[-1]).lower()}.{'nc' if to == 'netcdf' else 'csv'}"
    if to == "netcdf":
        to_netcdf(data, directory)[0].replace(path)
    else:
        with_units(data).to_dataframe().to_csv(path)
    return path


def _in_a(case: Case, depths: Any, deepest: float) -> Values:
    """Depths in a; those of a case in SI are given in m, or with a unit.  deepest: in a, before images count."""
    unit, name = (case.scales.a, "m") if case.scales else (1.0, "a")
    try:
        Z = np.atleast_1d(np.asarray(si_numbers(depths, POSITION.in_si), dtype=float)) / unit
        if not (Z.ndim == 1 and Z.size and np.all((Z >= 0.0) & (deepest >= Z))):
            raise ValueError(f"must be from 0 to {deepest * unit:.3g} {name}, the shorter side of the grid")
    except ValueError as error:
        raise ValueError(f"depths = {depths!r}: {error}") from error
    return Z


def stress_numbers(case: Case, maps: Maps) -> dict[str, float]:
    """The largest von Mises stress in body 1 with its place, and the largest shear stress with its depth, by name.

    In p_h and a, of all nodes.  Round the largest von Mises stress of a first search the steps in depth are halved.  A
    parabola through three depths then gives the largest stresses and their depths.  maps: of a run at one moment, with
    their axes.  Empty where the film carries no load.
    """
    loads = loads_on(case, maps)
    if not loads.p.any():
        return {}
    depths, row = usual_depths(loads, FEW), loads.y.size // 2 if "r" in maps else None  # of rings one row has all
    found = [_largest(each) for each in below(loads, depths, row)]
    best = int(np.argmax([mises for mises, *_ in found]))
    between = ((depths[1:] + depths[:-1]) / 2.0)[max(best - 1, 0) : best + 1]
    found += [_largest(each) for each in below(loads, between, row)]
    mises, places, shears = zip(*found, strict=True)
    line, column = np.unravel_index(places[int(np.argmax(mises))], loads.p.shape)
    (Z, largest), (Z_shear, shear) = (_peak(np.append(depths, between), np.array(each)) for each in (mises, shears))
    across = {"Y_von_mises": float(loads.y[line if row is None else row])} if loads.y.size > 1 else {}
    place = {"X_von_mises": float(loads.x[column]), **across, "Z_von_mises": Z}
    return {"von_mises_max": largest, **place, "shear_max": shear, "Z_shear": Z_shear}


def _largest(one: Stresses) -> tuple[float, int, float]:
    """The largest von Mises stress at a depth, its node, and the largest shear stress."""
    mises = von_mises(one)
    return float(mises.max()), int(mises.argmax()), float(tresca(one).max())


def _peak(z: Values, values: Values) -> tuple[float, float]:
    """Depth and size of the largest value: at an end, or at the vertex of a parabola over sqrt(z)."""
    order = np.argsort(z)
    root, values = np.sqrt(z[order]), values[order]
    i = int(np.argmax(values))
    if i in (0, len(values) - 1):
        return float(root[i] ** 2), float(values[i])
    a, b, c = np.polyfit(root[i - 1 : i + 2], values[i - 1 : i + 2], 2)
    return float(b / (2.0 * a)) ** 2, float(c - b * b / (4.0 * a))
