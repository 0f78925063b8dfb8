"""
Load sharing by Johnson, Greenwood and Poon
===========================================

Johnson, Greenwood and Poon (Wear 1972;19:91) part the load between oil and asperities without solving for the film:
it is that of a smooth contact which carries the share of the oil, with its load and its elastic modulus lower by that
share.  Asperities carry what their law says at this film, nowhere more than the Hertz pressure.
"""

import numpy as np
from matplotlib import pyplot as plt

import ertel


def ball(speed, oil=1.0, nodes=129, rough=True):
    """The ball at a speed (m/s), or the smooth one that carries the share of the oil."""
    law = {"law": "persson", "longest": "50 um", "shortest": "1 um"}
    return ertel.rolling(
        radius="10 mm", load=38.9 * oil, mean_speed=speed, slide_to_roll=0.1, E_prime=oil * 219.8e9,
        oil=ertel.Oil(eta0="40 mPa*s", alpha="22 / GPa"), rheology={"law": "ree-eyring", "tau0": "5 MPa"},
        surfaces={"sigma": "100 nm", "asperities": law} if rough else None, nodes=nodes,
    )  # fmt: skip


def formula(speed, oil=1.0):
    """Central film (m) by Nijenbanning, Venner and Moes."""
    case = ball(speed, oil, rough=False)
    return case.film_scale * case.scales.film


def shared(speed):
    """Share of the asperities and central film (m) by the relation."""
    case, shares = ball(speed), np.linspace(0.001, 0.98, 60)
    films = np.array([formula(speed, 1 - share) for share in shares])
    p = np.interp(films, case.asperities.h, case.asperities.p) / case.scales.p_h
    carried = np.where(p < 1, 1.5 * p - 0.5 * p**3, 1.0)  # of a Hertz pressure that is cut off at p
    return np.interp(0.0, shares - carried, shares), np.interp(0.0, shares - carried, films)


speeds = np.geomspace(0.05, 3.0, 7)
curve = ertel.stribeck(ball(1.0), list(speeds)).dataset
share, film = curve["asperity_share"].values, curve["h_c"].values
relation = np.array([shared(speed) for speed in speeds])
Lambda = np.array([formula(speed) for speed in speeds]) / 100e-9
print(np.column_stack([Lambda, share, relation[:, 0], film / relation[:, 1]]).round(3))
assert abs(share - relation[:, 0]).max() < 0.15

figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 3.6), layout="constrained")
for axes, computed, simple in ((left, share, relation[:, 0]), (right, film * 1e9, relation[:, 1] * 1e9)):
    axes.semilogx(Lambda, computed, "o-", markersize=4, label="computed")
    axes.semilogx(Lambda, simple, "k--", label="Johnson, Greenwood, Poon")
    axes.set(xlabel="central film of the smooth contact over roughness")
    axes.set_xticks([0.5, 1, 2, 5], ["0.5", "1", "2", "5"])
    axes.minorticks_off()
left.set(ylabel="share of the load on asperities")
right.set(ylabel="central film (nm)", yscale="log", yticks=[50, 100, 200, 500], yticklabels=[50, 100, 200, 500])
left.legend(frameon=False)
plt.show()
