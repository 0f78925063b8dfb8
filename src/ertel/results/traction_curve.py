"""A traction curve: the friction of a steady contact against the slide-to-roll ratio, the speed or the load.

The curve of a physical case is in SI.  That of a dimensionless case is in the units of the case; its traction
coefficients are multiples of a/R, a number that such a case does not have.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import nan
from typing import TYPE_CHECKING, Any, NamedTuple

from ertel.case.case import Case
from ertel.physics.units import FINITE, LOAD, VELOCITY, Mark
from ertel.results.numbers import Scalar
from ertel.results.report import column
from ertel.results.study_result import DONE, TO_DO, StudyResult
from ertel.results.variables import COEFFICIENT, FRICTION, VARIABLES, Variable

if TYPE_CHECKING:  # matplotlib is imported when there is something to draw
    from matplotlib.figure import Figure


class CurveAxis(NamedTuple):
    """The quantity that varies along a curve: its name in words, its symbol and unit, and what its values must be."""

    long_name: str
    symbol: str
    unit: str
    mark: Mark

    @property
    def attributes(self) -> dict[str, str]:
        """The attributes of the coordinate of a Dataset."""
        return {"long_name": self.long_name, "symbol": self.symbol, "units": self.unit}


AXES: Mapping[str, CurveAxis] = {
    "slide_to_roll": CurveAxis("slide-to-roll ratio", "S", "1", FINITE),
    "mean_speed": CurveAxis("mean speed", "u_m", "m/s", VELOCITY),
    "load": CurveAxis("load", "F", "N", LOAD),
}
HEADS = {  # of a table, where names are long
    **{"mu_sliding": "mu", "mu_rolling": "mu_r", "power_loss": "loss"},
    **{"mu_isothermal": "mu_iso", "T_film_max": "T_film"},
}
SHOWN = ("mu_sliding", "mu_rolling", "mu_1", "power_loss", "H_c", "H_min", "tau_max")  # in a table
SHOWN_WARM = ("mu_isothermal", "T_film_max")  # with a section [thermal]
WORK = ("newton_iterations", "krylov_iterations", "convolutions")
NUMBERS = (*SHOWN, "mu_2", "mu_sliding_y", "P_max", *WORK)
WARM_NUMBERS = (*SHOWN_WARM, "T_1_max", "T_2_max", "phi_T")
CURVE_VARIABLES: Mapping[str, Variable] = {
    **VARIABLES,
    "mu_1": Variable("friction coefficient of surface 1, mu + mu_r", "mu_1", "a/R", COEFFICIENT, "mu_1", "1"),
    "mu_2": Variable("friction coefficient of surface 2, mu_r - mu", "mu_2", "a/R", COEFFICIENT, "mu_2", "1"),
    "tau_max": Variable("maximum mid-plane shear stress", "tau_max", "p_h a/R", "shear_stress", "tau_max", "Pa"),
    "mu_isothermal": replace(
        FRICTION["mu_sliding"], long_name="isothermal traction coefficient", si_name="mu_isothermal"
    ),
    "T_1_max": Variable("highest temperature of surface 1", "T_1", "K", "", "T_1_max", "K"),
    "T_2_max": Variable("highest temperature of surface 2", "T_2", "K", "", "T_2_max", "K"),
    "T_film_max": Variable("highest temperature of the film", "T_film", "K", "", "T_film_max", "K"),
    "phi_T": Variable("inlet factor of the film", "phi_T"),
}
WARM = (
    "mu, loss, films and stress include heat (inlet shear heating, flash temperature); mu_iso and mu_r are isothermal"
)


def point_scalars(case: Case, values: Mapping[str, float]) -> dict[str, Scalar]:
    """The numbers of a point from dimensionless values by name; nan where there is none.

    Those of a physical case are in SI under SI names (h_c for H_c).
    """
    found = {}
    for name in NUMBERS if case.thermal is None else (*NUMBERS, *WARM_NUMBERS):
        variable = CURVE_VARIABLES[name]
        factor = variable.factor(case.scales) if case.scales and variable.scale else 1.0
        found[shown_name(case.scales is not None, name)] = Scalar(
            values.get(name, nan) * factor, _attributes(case, variable)
        )
    return found


def shown_name(physical: bool, name: str) -> str:
    """The name of a variable in a curve: that in SI, or the dimensionless one."""
    return (physical and CURVE_VARIABLES[name].si_name) or name


def _attributes(case: Case, variable: Variable) -> dict[str, str]:
    comment = {"comment": variable.comment} if variable.comment else {}
    if case.scales:
        symbol = variable.si_name or variable.symbol
        return {"long_name": variable.long_name, "symbol": symbol, "units": variable.si_units or "1", **comment}
    unit = {"in_units_of": variable.unit} if variable.unit != "1" else {}
    return {"long_name": variable.long_name, "symbol": variable.symbol, "units": "1", **unit, **comment}


@dataclass(frozen=True, repr=False, eq=False, kw_only=True)
class TractionCurve(StudyResult):
    """A traction curve.

    Parameters
    ----------
    case : Case
        The case with whose conditions the points were computed, apart from what varies.
    dataset : xarray.Dataset
        Over slide_to_roll, mean_speed (m/s) or load (N).  The traction coefficient of sliding mu_sliding, the rolling
        resistance mu_rolling of each surface, the power loss, the central and the minimum film thickness, the maximum
        shear stress in the middle of the film, the maximum pressure, status and work of each point; nan where the film
        did not converge.  In SI under SI names (h_c for H_c) where the case is physical.  With a section [thermal] all
        but mu_rolling and p_max is of the warm film; mu_isothermal is without heat, phi_T the inlet factor in h_c and
        h_min, T_1_max, T_2_max, T_film_max (K) the highest temperatures.
    warnings : list of str
        Warnings about the oil, the grid and the domain, with the points that they are about.
    directory : Path, optional
        Where the curve is stored.
    """

    case: Case
    warnings: list[str]

    @property
    def axis(self) -> str:
        """The quantity that varies: slide_to_roll, mean_speed or load."""
        return str(self.dataset.attrs["varies"])

    @property
    def failed(self) -> list[float]:
        """The values at which the film did not converge."""
        ended = ~self.dataset["status"].isin([DONE, *TO_DO])
        found: list[float] = self.dataset[self.axis].values[ended].tolist()
        return found

    def plot(self) -> "Figure":
        """The curve: traction coefficient and rolling resistance, films, power loss and shear stress."""
        from ertel.plots import studies

        return studies.traction_figure(self.dataset)

    def as_data(self) -> dict[str, Any]:
        """The curve as plain data for JSON; names in SI end with the unit, and what is missing is None."""
        about = {name: self.dataset.attrs[name] for name in ("title", "kind", "M", "L", "varies", "film")}
        return {**about, "points": self.rows(), "warnings": self.warnings, "complete": self.complete}

    def table(self) -> list[list[str]]:
        """The columns of a table to read, each with its heading first, with units that fit."""
        physical = self.case.scales is not None
        found = [column(AXES[self.axis].symbol, self.dataset[self.axis])]
        for name in SHOWN if self.case.thermal is None else (*SHOWN, *SHOWN_WARM):
            shown = shown_name(physical, name)
            found.append(column(HEADS.get(name, shown), self.dataset[shown]))
        status = self.dataset["status"]
        return found if (status == DONE).all() else [*found, column("status", status)]

    @property
    def remarks(self) -> list[str]:
        """Lines below the table: how the film was computed, units, and warnings."""
        said = [f"film: {self.dataset.attrs['film']}"]
        if not self.case.scales:
            said.append("mu is in units a/R, films in a^2/R, stresses in p_h a/R: the case is dimensionless")
        if self.case.thermal:
            said.append(WARM)
        return [*said, *(f"warning: {warning}" for warning in self.warnings)]

    @property
    def heading(self) -> str:
        """The title of the table."""
        name = self.case.name or self.case.kind
        done = int((~self.dataset["status"].isin(TO_DO)).sum())
        ended = "" if self.complete else ", not complete"
        return f"{name}, {done} points over the {AXES[self.axis].long_name}{ended}"
