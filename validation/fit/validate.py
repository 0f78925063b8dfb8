"""Twins of an impact viscometer: made measurements with known noise, and how often a fit finds the oil they are of.

    python validation/fit/validate.py twins [SEEDS]     # twins.md; default 100
    python validation/fit/validate.py noise             # noise.md

A twin is the run of a known oil on a coarse radial grid, with 1 % noise of a seed on a film profile and on the
coefficient of restitution.  The fit starts from another oil.  Runs are kept in memory by the digest of their case, so
that all seeds share the first point of the search.
"""

import sys
import warnings
from pathlib import Path

import numpy as np

import ertel
from ertel.results.measurements import Measurement
from ertel.runs.fit import STEP, fit_problem, solve_fit

HERE = Path(__file__).parent
BALL = {"kind": "impact", "radius": "10 mm", "material_1": "steel", "material_2": "glass", "drop_height": "10 mm"}
TRUTH = {"eta0": "0.1 Pa*s", "alpha": "22 / GPa"}
IN_SI = np.array([0.1, 22e-9])
START = {"eta0": "50 mPa*s", "alpha": "15 / GPa"}
BOUNDS = {"lubricant.eta0": ("5 mPa*s", "1 Pa*s"), "lubricant.alpha": ("5 / GPa", "60 / GPa")}
X = np.linspace(0.0, 300e-6, 31)
NOISE = 0.01
known = {}


def case_of(oil, nodes=33):
    """The impact with an oil, until the ball has left."""
    time = {"start_approach": -1.5, "until": "rebound"}
    solver = {"method": "radial", "nodes": nodes}
    return ertel.parse_case({"name": "twin", "contact": BALL, "lubricant": oil, "solver": solver, "time": time})


def run(cases):
    """Results of cases, each computed once."""
    for case in cases:
        if case.digest not in known:
            known[case.digest] = ertel.simulate(case)
    return [known[case.digest] for case in cases]


def measured(truth, noise):
    """The film profile at maximum approach and the restitution of a run, with relative noise, one for each value."""
    film = Measurement("profile", "h", np.ones_like(X), X, at="max-approach").predicted(truth)
    restitution = truth.summary["restitution"]
    return [
        Measurement("profile", "h", film * (1 + noise[:-1]), X, sigma=NOISE * film, at="max-approach"),
        Measurement.number("restitution", restitution * (1 + noise[-1]), sigma=NOISE * restitution),
    ]


def twins(seeds):
    """Fit the twins of all seeds, and count those that are recovered within two standard errors."""
    [truth] = run([case_of(TRUTH)])
    lines, inside, squares = [], [], []
    for seed in range(seeds):
        noise = NOISE * np.random.default_rng(seed).standard_normal(len(X) + 1)
        found = solve_fit(fit_problem(case_of(START), measured(truth, noise), BOUNDS), run)
        values, errors = (np.array(list(each.values())) for each in (found.values, found.standard_errors))
        off = (values - IN_SI) / errors
        inside.append(np.abs(off) <= 2.0)
        squares.append(found.dataset.attrs["chi_square"] / found.dataset.attrs["degrees_of_freedom"])
        lines.append(
            f"| {seed} | {1e3 * values[0]:.1f} | {off[0]:+.2f} | {1e9 * values[1]:.2f} | {off[1]:+.2f} | "
            f"{squares[-1]:.2f} | {found.dataset.attrs['runs']} |"
        )
        print(lines[-1], flush=True)
        for digest in list(known)[4:]:  # those of the truth and of the first point are shared
            del known[digest]
    eta0, alpha = np.sum(inside, axis=0)
    both = int(np.sum(np.all(inside, axis=1)))
    text = f"""# Twins of an impact viscometer

`python validation/fit/validate.py twins {seeds}`: a ball falls 10 mm on an oil of 100 mPa·s and 22 /GPa; 33 rings;
31 values of the film at maximum approach and the restitution, each with 1 % noise; the fits start at 50 mPa·s and
15 /GPa.

Within two standard errors of the truth: **eta0 in {eta0} of {seeds}, alpha in {alpha} of {seeds}, both in {both}**. Chi
square for each degree of freedom: {np.mean(squares):.2f} in the mean.
The last fit: {found.dataset.attrs["decided"]}.

| seed | eta0 (mPa·s) | off by (sigma) | alpha (1/GPa) | off by (sigma) | chi square per degree | runs |
| ---: | ---: | ---: | ---: | ---: | ---: | ---: |
"""
    (HERE / "twins.md").write_text(text + "\n".join(lines) + "\n")


def noise():
    """The noise of the time steps in numbers of neighboring cases: what remains beside a parabola in ln eta0."""
    lines = []
    for nodes in (33, 65):
        shifts = np.linspace(-0.02, 0.02, 9)
        table = []
        for shift in shifts:
            [result] = run([case_of({"eta0": f"{float(0.1 * np.exp(shift))!r} Pa*s", "alpha": "22 / GPa"}, nodes)])
            film, restitution = measured(result, np.zeros(len(X) + 1))
            table.append(np.log([*film.values, *restitution.values, result.summary["contact_time"]]))
        fitted = np.polynomial.polynomial.polyfit(shifts, np.array(table), 2)
        left = np.array(table) - np.polynomial.polynomial.polyval(shifts, fitted).T
        rms = np.sqrt(np.sum(left**2, axis=0) / (len(shifts) - 3))
        for name, size, slope in (
            ("film at the centre", rms[0], fitted[1, 0]),
            ("film, largest of 31 places", rms[:-2].max(), fitted[1, rms[:-2].argmax()]),
            ("restitution", rms[-2], fitted[1, -2]),
            ("contact time", rms[-1], fitted[1, -1]),
        ):
            lines.append(f"| {nodes} | {name} | {size:.1e} | {slope:+.4f} | {size / STEP / abs(slope):.1e} |")
    text = f"""# Noise of the time steps

`python validation/fit/validate.py noise`: nine impacts whose eta0 differs by 0.5 % from one to the next; relative
standard deviation from a parabola in ln eta0, and the derivative with respect to ln eta0. The last column is the
relative error that the noise gives to a derivative by a step of {STEP:g}.

| rings | number | noise | derivative | noise / step / derivative |
| ---: | --- | ---: | ---: | ---: |
"""
    (HERE / "noise.md").write_text(text + "\n".join(lines) + "\n")


if __name__ == "__main__":
    warnings.simplefilter("ignore", UserWarning)
    command, *rest = sys.argv[1:] or ["twins"]
    if command == "noise":
        noise()
    else:
        twins(int(rest[0]) if rest else 100)
