"""
Impact and rolling: the same film
=================================

A cylinder falls on an oiled plane.  The edge of its contact runs outwards and draws oil in, like a roller with the
speed of this edge.  The film that it leaves at X is then that of steady rolling at the speed, size and pressure that
the contact had when its edge passed X: nothing is fitted.
"""

import matplotlib.pyplot as plt
import numpy as np

import ertel

M, L, LINE = 60, 10, {"radius_ratio": 0}
FINE = {"nodes": 1025, "half_width": 1.75, "inlet": 2.25}  # the films are thin and their inlets short
impact = ertel.simulate(ertel.impact(M=M, L=L, **LINE, nodes=1025, half_width=1.5))
there = ertel.fronts.at_max_approach(impact.dataset)
left = there["oil"] * impact.case.lubricant.density(there["P"])


def rolled(A):
    """The oil rho H that rolling leaves where the edge of the dry impact is at A."""
    p = impact.case.parameters
    speed = impact.case.geometry.hertz.front_speed(A)
    local = {"lambda_bar": p.lambda_bar * speed / A**4, "alpha_bar": p.alpha_bar * A}
    film = ertel.simulate(ertel.rolling(**local, **LINE, **FINE)).dataset["inflow"]
    return A**2 * float(film[-1] + (film[-1] - film[-2]) / 3)  # without the error of the grid


# %%
# Towards the edge they agree within some per cent.  Inside, where the edge ran first, the oil had time to flow.
X = np.array([0.5, 0.6, 0.7, 0.8, 0.85, 0.9])
expected = np.array([rolled(A) for A in X])
ratio = left.interp(X=X).values / expected
print(dict(zip(X.tolist(), ratio.round(3).tolist(), strict=True)))
assert (abs(ratio[2:] - 1) < 0.1).all() and (np.diff(ratio) < 0).all()

figure, axes = plt.subplots(figsize=(5, 3.5), layout="constrained")
axes.plot(left["X"], left, label=f"impact, M = {M}, L = {L}")
axes.plot(X, expected, "o", label="steady rolling at the speed of the edge")
axes.set(xlim=(0, 1.1), ylim=(0, 0.09), xlabel="$X$, in half widths", ylabel=r"$\bar\rho H$ left")
axes.legend()
