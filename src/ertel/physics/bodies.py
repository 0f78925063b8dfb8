"""The two bodies: reduced modulus and radius, the mass of a ball, and its speed after a fall.

All functions take and return SI units.
"""

from math import inf, pi, sqrt

from ertel.physics.checks import require_positive


def reduced_modulus(E1: float, nu1: float, E2: float, nu2: float) -> float:
    """Reduced modulus E' (Pa), 2/E' = (1 - nu1^2)/E1 + (1 - nu2^2)/E2, from Young's moduli (Pa), Poisson's ratios."""
    for name, E in {"E1": E1, "E2": E2}.items():
        require_positive(name, E)
    for name, nu in {"nu1": nu1, "nu2": nu2}.items():
        if not -1 < nu <= 0.5:
            raise ValueError(f"{name} = {nu}: Poisson's ratio must be above -1 and not above 0.5")
    return 2 / ((1 - nu1**2) / E1 + (1 - nu2**2) / E2)


def reduced_radius(R1: float, R2: float = inf) -> float:
    """Reduced radius R (m), 1/R = 1/R1 + 1/R2, of two balls, or of a ball on a plane (R2 infinite)."""
    require_positive("R1", R1)
    if not R2 > 0:
        raise ValueError(f"R2 = {R2}: must be above zero (infinite for a plane)")
    return 1 / (1 / R1 + 1 / R2)


def conforming_radius(R1: float, R2: float) -> float:
    """Reduced radius R (m) along one principal axis, 1/R = 1/R1 + 1/R2: concave radii are negative, planes infinite.

    It is infinite or negative where the curvatures do not add up to more than zero: no contact at a point.
    """
    curvature = 1 / R1 + 1 / R2
    return 1 / curvature if curvature else inf


def sphere_mass(radius: float, density: float) -> float:
    """Mass (kg) of a solid ball of the given radius (m) and density (kg/m^3)."""
    require_positive("radius", radius)
    require_positive("density", density)
    return 4 * pi / 3 * density * radius**3


def drop_speed(height: float, g: float = 9.80665) -> float:
    """Speed v0 = sqrt(2 g h) (m/s) of a ball dropped from a height (m), without air drag."""
    require_positive("height", height)
    require_positive("g", g)
    return sqrt(2 * g * height)
