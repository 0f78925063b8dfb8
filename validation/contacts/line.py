"""A long ellipse against the infinite line contact, in its middle.

    python validation/contacts/line.py

writes `line.md` in three minutes.  The line contact is solved here by a dense program of its own, with nothing of
ertel's solver but the laws of the oil: Newton's method on pressures, load and cavitation at once, second order in X.
Units: the half width b = 4 p_h R/E', p_h and b^2/R, so that

    H = X^2/2 + H_0 - (1/pi) integral P ln|X - X'| dX',    integral P dX = pi/2
    d/dX [rho H - rho H^3/(eta lambda) dP/dX] = 0 where P > 0,    lambda = 12 eta0 u_m R^2/(b^3 p_h)
"""

import sys
import warnings
from math import pi
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

import ertel
from ertel.physics import film_formulas
from ertel.physics.dry_contact import hertz_ellipse
from ertel.physics.lubricant import Lubricant
from ertel.physics.scales import HamrockDowson

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from common import table

HERE = Path(__file__).parent
Values = NDArray[np.float64]
R, ETA0, ALPHA = 0.01, 0.04, 2e-8
STEEL = {"material_1": "steel", "material_2": "steel", "oil": ertel.Oil(eta0=ETA0, alpha=ALPHA)}
CONDITIONS = [(0.6e9, 1.0), (1.0e9, 0.5)]  # p_h in Pa, u_m in m/s
STEP = 1e-7  # of a difference of the laws
RATIOS = (1, 2, 4, 8, 16)  # half width across over that along the flow


def kernel(X: Values) -> Values:
    """The displacement by a constant pressure on each cell."""

    def integral(s: Values) -> Values:
        return np.asarray(s * (np.log(np.abs(s)) - 1.0))  # of ln|s|

    s, h = X[:, None] - X[None, :], X[1] - X[0]
    return np.asarray(-(integral(s + h / 2) - integral(s - h / 2)) / pi)


def line_film(oil: Lubricant, lam: float, nodes: int) -> tuple[Values, Values]:
    """X and H of the line contact; the derivatives of the laws are differences."""
    X, h = np.linspace(-4.5, 1.5, nodes, retstep=True)
    K, each = kernel(X), np.arange(nodes)
    P = np.sqrt(np.maximum(1.0 - X**2, 0.0))
    H_0 = 0.1 - float(np.min(X**2 / 2 + K @ P))

    for _ in range(100):
        H = X**2 / 2 + H_0 + K @ P
        rho, eta = oil.density(P), oil.viscosity(P)
        d_rho = (oil.density(P + STEP) - rho) / STEP
        d_log_eta = np.log(oil.viscosity(P + STEP) / eta) / STEP
        m, eps = rho * H, rho * H**3 / (eta * lam)
        d_m, d_eps = rho[:, None] * K, (3 * eps / H)[:, None] * K
        d_m[each, each] += H * d_rho
        d_eps[each, each] += eps * (d_rho / rho - d_log_eta)
        d_m, d_eps = np.column_stack([d_m, rho]), np.column_stack([d_eps, 3 * eps / H])  # and by H_0
        gradient, mean = np.diff(P) / h, (eps[1:] + eps[:-1]) / 2
        before = np.maximum(each[:-1] - 1, 0)
        flux = 1.5 * m[:-1] - 0.5 * m[before] - mean * gradient  # through the faces
        d_flux = 1.5 * d_m[:-1] - 0.5 * d_m[before] - (d_eps[1:] + d_eps[:-1]) / 2 * gradient[:, None]
        d_flux[each[:-1], each[1:]] -= mean / h
        d_flux[each[:-1], each[:-1]] += mean / h
        r, J = np.zeros(nodes + 1), np.zeros((nodes + 1, nodes + 1))
        r[1 : nodes - 1], J[1 : nodes - 1] = np.diff(flux), np.diff(d_flux, axis=0)
        held = np.append((P <= 0) & (r[:-1] >= 0), False)
        held[[0, nodes - 1]] = True
        r[held], J[held] = P[held[:-1]], 0.0
        J[held, held] = 1.0
        r[-1], J[-1, :nodes] = h * P.sum() - pi / 2, h
        change = np.linalg.solve(J, -r)
        falls = -(change[-1] + K @ change[:-1])
        share = min(1.0, 0.3 / np.abs(change[:-1]).max(), 0.8 / max(float((falls / H).max()), 1e-9))
        P, H_0 = np.maximum(P + share * change[:-1], 0.0), H_0 + share * float(change[-1])
        if share == 1.0 and np.abs(change).max() < 1e-9:
            return X, X**2 / 2 + H_0 + K @ P
    raise RuntimeError("the line contact did not converge")


def line_center(oil: Lubricant, lam: float) -> float:
    """H_c of the line contact without the error of the grid, of second order."""
    coarse, fine = (H[np.abs(X).argmin()] for X, H in (line_film(oil, lam, nodes) for nodes in (601, 1201)))
    return float(fine + (fine - coarse) / 3)


def ellipse(ratio: int, p_h: float, speed: float) -> ertel.Case:
    """The contact of this ellipticity with the Hertz pressure."""
    D = 1.0 if ratio == 1 else float(brentq(lambda D: 1 / hertz_ellipse(D).kappa - ratio, 0.01, 1.0))
    given = {"radius_x": R, "radius_y": R / D, "mean_speed": speed, "nodes": 129, **STEEL}
    trial = ertel.rolling(load=100.0, **given)
    return ertel.rolling(load=100.0 * (p_h / trial.scales.p_h) ** 3, **given)


def section(p_h: float, speed: float) -> str:
    case = ellipse(1, p_h, speed)
    E = case.scales.E_prime
    b = 4 * p_h * R / E
    line = line_center(case.lubricant, 12 * ETA0 * speed * R**2 / (b**3 * p_h)) * b**2 / R
    ugw = HamrockDowson(ETA0 * speed / (E * R), ALPHA * E, 2 * pi * (p_h / E) ** 2)
    formula = film_formulas.dowson_toyoda_central(ugw) * R
    rows = [["infinite line", "", f"{1e9 * line:.1f}", "", ""]]
    rows.append(["Dowson-Toyoda", "", f"{1e9 * formula:.1f}", f"{formula / line - 1:+.1%}", ""])
    for ratio in RATIOS:
        case = ellipse(ratio, p_h, speed)
        found = ertel.simulate(case).summary
        film, error = found["H_c_extrapolated"] * case.scales.film, found["H_c_error"] / found["H_c"]
        across = case.geometry.radius_ratio**-1
        films = f"{1e9 * film:.1f}", f"{film / line - 1:+.1%}", f"{error:.1%}"
        rows.append([f"ellipse, k = {ratio}", f"{across:.3g}", *films])
    head = ["", "R_y/R_x", "H_c, nm", "over the line's", "estimated error on the grid"]
    return f"\np_h = {p_h / 1e9:g} GPa, {speed:g} m/s:\n\n" + table(head, rows)


def main() -> None:
    warnings.simplefilter("ignore")
    text = "# Long ellipses and the line contact\n\nSteel, R_x = 10 mm, oil of 0.04 Pa s and 20 /GPa. H_c without the "
    text += "error of the grid (129 nodes along x), k = b/a. Written by `line.py`.\n"
    (HERE / "line.md").write_text(text + "".join(section(*each) for each in CONDITIONS), encoding="utf-8")


if __name__ == "__main__":
    main()
