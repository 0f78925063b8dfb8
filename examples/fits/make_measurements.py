"""Make the measurements of examples/fits/impact_viscometer.toml: runs of a known oil with noise of one percent.

    python examples/fits/make_measurements.py

It writes film.csv and prints the two restitutions that stand in impact_viscometer.toml.
"""

from pathlib import Path

import numpy as np

import ertel

HERE = Path(__file__).parent
NOISE = 0.01


def fall(height):
    """The impact on the oil that the fit should find."""
    oil = ["lubricant.eta0=100 mPa*s", "lubricant.alpha=22 / GPa"]
    return ertel.simulate(ertel.load_case(HERE / "ball.toml", [*oil, f"contact.drop_height={height}"]))


if __name__ == "__main__":
    random = np.random.default_rng(7)
    falls = [fall(height) for height in ("10 mm", "40 mm")]
    last = falls[0].si.isel(frame=falls[0].dataset["event"].values.tolist().index(1))  # maximum approach
    x = np.arange(0.0, 300.0, 10.0)  # um
    film = 1e6 * np.interp(1e-6 * x, last["r"], last["h"])
    rows = np.transpose([x, film * (1 + NOISE * random.standard_normal(x.size)), NOISE * film])
    text = "\n".join(",".join(f"{value:.4f}" for value in row) for row in rows)
    heading = "# made by examples/fits/make_measurements.py: a run of an oil of 100 mPa*s and 22 /GPa with 1 % noise\n"
    (HERE / "film.csv").write_text(f"{heading}x_um,h_um,sigma_um\n{text}\n")
    print([round(each.summary["restitution"] * (1 + NOISE * random.standard_normal()), 4) for each in falls])
