"""Which waves of a rough surface are kept, and how a surface begins and ends smoothly."""

from typing import Any

import numpy as np

Array = Any  # NumPy arrays, or numbers


def smooth_step(share: Array) -> Array:
    """From 0 where share <= 0 to 1 where share >= 1, with two continuous derivatives: s^3 (10 - 15 s + 6 s^2)."""
    s = np.clip(share, 0.0, 1.0)
    return s**3 * (10.0 + s * (6.0 * s - 15.0))


def kept_share(cutoff_over_wavelength: Array) -> Array:
    """The share of the height of a wave that is left by a cutoff.

    All of a wave at least as long as the cutoff, nothing of one shorter than half of it, a smooth step in the wave
    number in between.  A cutoff of four cells of a grid leaves nothing that the grid would mistake for a longer wave,
    and does not touch waves of four cells and more: a surface that the grid resolves is the surface itself, so the
    order of the discretisation is not changed.
    """
    return smooth_step(2.0 - np.asarray(cutoff_over_wavelength))
