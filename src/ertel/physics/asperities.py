"""Asperities that touch: the mean pressure p that they carry where the mean gap is h.

h is the volume of the space between the rough surfaces per area, above zero always.  A law is a small frozen record in
SI with one method, `curve`, that tabulates p(h).  A user's own law needs a registered name:

    @ertel.asperity_laws.register("power")
    @dataclass(frozen=True)
    class Power:
        pressure: Annotated[float, STRESS]

        def curve(self, sigma, modulus):
            h = sigma * np.geomspace(1e-4, 10, 500)
            return GapCurve(h, self.pressure * (sigma / h) ** 8)

sigma is the rms roughness of both surfaces together.  The modulus is that of contact mechanics, E* = E'/2 with the
reduced modulus E' of ertel: 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2.
"""

from dataclasses import dataclass
from functools import lru_cache
from math import inf, pi, sqrt
from typing import Annotated, ClassVar, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ertel.physics.registry import ASPERITY_LAWS
from ertel.physics.units import ABOVE_ZERO, LENGTH, SHARE, STRESS, Meaning

Floats = NDArray[np.float64]

WAVES, PRESSURES = 600, 3000  # of the tables of Persson's law
RINGS = 200  # of equal ratios, into which the wave numbers of a measured map are gathered
GAPS = 1200  # of those of the other laws
FEWEST = 4  # points of a table
DRAG = 0.45  # gamma of Persson's law: the elastic energy of asperities that do not touch over all of their area


class GapCurve(NamedTuple):
    """A law as points, each of shape (n,): mean gap h (m, rising), pressure p (Pa, falling), share of area in touch.

    area: None where a law does not say it.
    """

    h: Floats
    p: Floats
    area: Floats | None = None

    @property
    def complaint(self) -> str:
        """The fault of a law's table, "" if there is none."""
        h, p = (np.asarray(part, dtype=np.float64) for part in (self.h, self.p))
        if h.ndim != 1 or h.shape != p.shape or h.size < FEWEST:
            return f"must have at least {FEWEST} gaps and as many pressures"
        if not (np.all(np.isfinite(h) & np.isfinite(p)) and np.all(h > 0) and np.all(p > 0)):
            return "must have finite gaps and pressures above zero"
        if not (np.all(np.diff(h) > 0) and np.all(np.diff(p) < 0)):
            return "must have rising gaps and falling pressures"
        area = np.ones(1) if self.area is None else np.asarray(self.area)
        return "" if np.all((area > 0) & (area <= 1)) else "must have shares of the area above zero and at most 1"

    def capped(self, hardness: float) -> "GapCurve":
        """The same where the asperities flow at a pressure (Pa) of their own; without an area nothing is known."""
        if self.area is None or hardness == inf:
            return self
        return self._replace(p=np.minimum(self.p, hardness * self.area))


class AsperityLaw(Protocol):
    """A law of asperities: p(h) for an rms roughness sigma (m) and the modulus E* (Pa)."""

    def curve(self, sigma: float, modulus: float) -> GapCurve: ...


@ASPERITY_LAWS.register("persson")
@dataclass(frozen=True)
class Persson:
    """Persson's theory of a self-affine surface, whose spectrum is C(q) ~ q^(-2 (1 + hurst)) between two wavelengths.

    It has no number to fit.  Against dry rough surfaces pressed together by FFT its pressure is within 10 % from a
    pressure of 0.1 E* times the rms slope on, and 35 % too high at a light touch.
    """

    longest: Annotated[float, LENGTH, Meaning("longest wavelength of the roughness", "50 um")]
    shortest: Annotated[float, LENGTH, Meaning("shortest wavelength of the roughness", "1 um")]
    hurst: Annotated[float, SHARE, Meaning("Hurst exponent; 0.7 to 0.9 for most ground and polished surfaces")] = 0.8
    reference: ClassVar[str] = (
        "Yang C, Persson BNJ. Contact mechanics: contact area and interfacial separation from small contact to full "
        "contact. J Phys: Condens Matter 2008;20:215214"
    )

    def __post_init__(self) -> None:
        if self.shortest >= self.longest:
            raise ValueError(f"shortest = {self.shortest:g} m: must be below longest ({self.longest:g} m)")

    def curve(self, sigma: float, modulus: float) -> GapCurve:
        q = np.geomspace(2 * pi / self.longest, 2 * pi / self.shortest, WAVES)
        return persson_curve(tuple(q), tuple(q ** (-2 * (1 + self.hurst))), sigma, modulus)


class Spectrum(NamedTuple):
    """The waves of a rough surface, shape (n,): wave number q (1/m), rising, and variance (m^2) of their heights."""

    q: Floats
    variance: Floats

    @classmethod
    def of(cls, q: Floats, variance: Floats) -> "Spectrum":
        """That of waves in any order, gathered in rings, with the variances of their heights and of their slopes."""
        q, variance = q[variance > 0], variance[variance > 0]
        edges = np.geomspace(q.min(initial=1.0) * (1 - 1e-9), q.max(initial=1.0) * (1 + 1e-9), RINGS + 1)
        heights, slopes = (np.histogram(q, edges, weights=weights)[0] for weights in (variance, q**2 * variance))
        filled = heights > 0
        return cls(np.sqrt(slopes[filled] / heights[filled]), heights[filled])

    @property
    def rms(self) -> float:
        """The rms of their heights (m)."""
        return float(np.sqrt(self.variance.sum()))


@ASPERITY_LAWS.register("measured")
@dataclass(frozen=True)
class MeasuredWaves:
    """Persson's theory of the waves that the cutoff of a measured map in [[roughness]] takes from the gap.

    The map is parted: its waves above the cutoff are in the gap, those below are the law.  Their variances add up to
    that of the map, so that no wave counts twice.  sigma is that of the waves; one that is given scales them.
    The law has no direction and holds everywhere, also beside the map.
    """

    shortest: Annotated[
        float | None,
        LENGTH,
        Meaning("waves below are left out, as the noise of an instrument; left out: two points of the map", "1 um"),
    ] = None
    reference: ClassVar[str] = Persson.reference

    def curve(self, sigma: float, modulus: float, waves: Spectrum) -> GapCurve:
        q, variance = waves
        spans = np.convolve(np.diff(q), [0.5, 0.5])  # the weights of the trapezoidal rule
        return persson_curve(tuple(q), tuple(variance / (q * spans)), sigma, modulus)


@ASPERITY_LAWS.register("greenwood-tripp")
@dataclass(frozen=True)
class GreenwoodTripp:
    """Greenwood and Tripp's theory, p = (16 sqrt(2)/15) pi (eta beta sigma)^2 sqrt(sigma/beta) E* F_5/2(k).

    k is the distance of the mean planes in sigma; the mean gap of heights that are cut off where they touch is
    sigma (k Phi(k) + phi(k)).  density: eta beta sigma, summits per area times their radius times sigma.  sharpness:
    sqrt(sigma/beta).  Both belong to the summits of a surface.  With the moments of a whole surface the pressure is too
    small by a factor of 2 to 20.
    """

    density: Annotated[float, ABOVE_ZERO, Meaning("eta beta sigma: summits per area, their radius, sigma")] = 0.04
    sharpness: Annotated[float, ABOVE_ZERO, Meaning("sqrt(sigma/beta)")] = 0.1
    reference: ClassVar[str] = (
        "Greenwood JA, Tripp JH. The contact of two nominally flat rough surfaces. Proc Inst Mech Eng 1970;185:625-633"
    )

    def curve(self, sigma: float, modulus: float) -> GapCurve:
        k = np.linspace(-9.0, 8.0, GAPS)
        p = 16 * sqrt(2) / 15 * pi * self.density**2 * self.sharpness * modulus * summits(2.5, k)
        return GapCurve(sigma * summits(1.0, -k), p, np.minimum(pi**2 * self.density**2 * summits(2.0, k), 1.0))


@ASPERITY_LAWS.register("exponential")
@dataclass(frozen=True)
class ExponentialTouch:
    """p = pressure e^(-h/length): a fit of any measured curve in its middle."""

    pressure: Annotated[float, STRESS, Meaning("pressure at a gap of zero", "1 GPa")]
    length: Annotated[float, LENGTH, Meaning("gap over which the pressure falls by a factor of e", "40 nm")]
    reference: ClassVar[str] = "two numbers"

    def curve(self, sigma: float, modulus: float) -> GapCurve:
        h = self.length * np.geomspace(1e-6, 200.0, GAPS)
        return GapCurve(h, self.pressure * np.exp(-h / self.length))


def summits(power: float, k: Floats) -> Floats:
    """F_n(k), the integral of (s - k)^n over the normal distribution of s > k; shape of k."""
    x, weights = np.polynomial.legendre.leggauss(200)
    # with s - k = t^2 the integrand is smooth for half-integer powers; at the end e^{-s^2/2} is e^{-40} of its largest
    end = np.sqrt(np.sqrt(np.maximum(k, 0.0) ** 2 + 80.0) - k)[:, None]
    t = 0.5 * end * (x + 1.0)
    density = np.exp(-0.5 * (k[:, None] + t**2) ** 2) / sqrt(2 * pi)
    found: Floats = (2 * t ** (2 * power + 1) * density * (0.5 * end * weights)).sum(axis=1)
    return found


@lru_cache(maxsize=8)
def persson_curve(q: tuple[float, ...], spectrum: tuple[float, ...], sigma: float, modulus: float) -> GapCurve:
    """Persson's law of a surface whose spectrum C(q), of any scale, gives the shares of its waves q (1/m)."""
    from scipy.special import erf  # SciPy loads slowly

    wave, C = np.array(q), np.array(spectrum)
    C *= sigma**2 / (2 * pi * np.trapezoid(C * wave, wave))
    slopes = 2 * pi * wave**3 * C
    steps = 0.5 * (slopes[1:] + slopes[:-1]) * np.diff(wave)
    variance = 0.25 * modulus**2 * np.concatenate([[0.5 * steps[0]], np.cumsum(steps)])
    root = np.sqrt(2 * variance)
    p = np.geomspace(1e-8, 8.0, PRESSURES) * root[-1]
    s = p[:, None] / root
    share = 2 / sqrt(pi) / root * np.exp(-(s**2)) * (DRAG + 3 * (1 - DRAG) * erf(s) ** 2)
    rise = 0.5 * pi * modulus * np.trapezoid(wave**2 * C * share, wave, axis=1)  # - dh/d(ln p)
    parts = 0.5 * (rise[1:] + rise[:-1]) * np.diff(np.log(p))
    h = np.concatenate([np.cumsum(parts[::-1])[::-1], [0.0]])
    kept = h > 1e-9 * sigma
    light = np.linspace(60.0, 0.1, GAPS)  # at a light touch p falls exponentially
    h = np.concatenate([h[0] + rise[0] * light, h[kept]])[::-1]
    p = np.concatenate([p[0] * np.exp(-light), p[kept]])[::-1]
    return GapCurve(h, p, erf(p / root[-1]))
