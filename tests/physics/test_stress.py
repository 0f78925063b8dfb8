"""Stresses in a half space: closed forms, sums of point forces, equilibrium, and what must hold for any load."""

from functools import partial

import numpy as np
import pytest

from ertel.numerics import halfspace
from ertel.numerics.halfspace import Waves
from ertel.physics.dry_contact import hertz_ellipse
from ertel.physics.stress import Stresses, stress_waves, tresca, von_mises
from ertel.results import stress as results

NU = 0.3
NODES = np.linspace(-2.0, 2.0, 129)
HERTZ = np.sqrt(np.maximum(1.0 - NODES[:, None] ** 2 - NODES**2, 0.0))
NONE = np.zeros_like(HERTZ)
RANDOM = np.random.default_rng(1)


def below(z, p, q_x=NONE, q_y=NONE, nu=NU, spacing=NODES[1] - NODES[0]):
    """The stresses at a depth."""
    waves = Waves(*p.shape, spacing)
    loads = [waves.amplitudes(each) if each.any() else 0.0 for each in (p, q_x, q_y)]
    return Stresses(*waves.below(z, partial(stress_waves, nu=nu), loads))


def largest(p, mu=0.0, x=NODES, y=NODES):
    """The numbers of a summary."""
    depths = results.Loads(x, y, p, mu * p, 0.0 * p, NU)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(results, "loads_on", lambda case, maps: depths)
        return results.stress_numbers(None, {})


# -- closed forms ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("z", [0.25, 0.48, 1.0])
def test_hertz_circle_on_its_axis(z):
    """Johnson 1985, eq. (3.45)."""
    found = [each[64, 64] for each in below(z, HERTZ)]
    across = -(1 + NU) * (1 - z * np.arctan(1 / z)) + 0.5 / (1 + z * z)
    np.testing.assert_allclose(found, [across, across, -1 / (1 + z * z), 0, 0, 0], atol=1e-3)


def test_largest_stresses_of_a_hertz_circle():
    found = largest(HERTZ)
    assert found["von_mises_max"] == pytest.approx(0.62004, rel=1e-3)
    assert found["shear_max"] == pytest.approx(0.31002, rel=1e-3)
    assert found["Z_von_mises"] == pytest.approx(0.4809, abs=0.01) == found["Z_shear"]
    assert abs(found["X_von_mises"]) == abs(found["Y_von_mises"]) == 0.0


def test_tangential_load_on_the_surface():
    """Hamilton 1983 (Proc Inst Mech Eng C 197:53), y = 0: xx and yy are linear in x."""
    found, x = below(0.0, NONE, HERTZ), NODES
    inside = np.abs(x) < 0.8
    np.testing.assert_allclose(found.xx[64, inside], -(4 + NU) * np.pi / 8 * x[inside], atol=0.01)
    np.testing.assert_allclose(found.yy[64, inside], -3 * NU * np.pi / 8 * x[inside], atol=0.003)


@pytest.mark.parametrize(
    ("mu", "size", "depth", "place", "error"),
    [
        # by sums of point forces, 400 x 240 of them
        (0.1, 0.62446, 0.4749, 0.112, 2e-3),
        (0.25, 0.64760, 0.4441, 0.270, 2e-3),
        # on the edge: xx = (1 - 2 nu)/3 + mu (4 + nu) pi/8, yy = -(1 - 2 nu)/3 + mu 3 nu pi/8; singular in the depth
        (0.5, 0.9566, 0.0, -1.0, 1e-2),
    ],
)
def test_friction_moves_the_largest_stress_to_the_surface(mu, size, depth, place, error):
    """The force is along x: the compression in front of it adds to the shear stress below, and behind it there is
    tension on the surface.
    """
    found = largest(HERTZ[::2, ::2], mu, NODES[::2], NODES[::2]) if depth else largest(HERTZ, mu)
    assert found["von_mises_max"] == pytest.approx(size, rel=error)
    assert found["Z_von_mises"] == pytest.approx(depth, abs=0.01)
    assert found["X_von_mises"] == pytest.approx(place, abs=2 * (NODES[1] - NODES[0]))


def point_forces(x, y, z):
    """The stresses by a unit force into the body and by one along x, at x, y, z from it (Johnson 1985, section 3.2)."""
    R, r, a = np.sqrt(x * x + y * y + z * z), np.hypot(x, y), 1 - 2 * NU
    near, far = (1 - z / R) / r**2, z / R**3
    normal = [
        a / r**2 * (near * (x * x - y * y) + far * y * y) - 3 * z * x * x / R**5,
        a / r**2 * (near * (y * y - x * x) + far * x * x) - 3 * z * y * y / R**5,
        -3 * z**3 / R**5,
        a / r**2 * (2 * near * x * y - far * x * y) - 3 * x * y * z / R**5,
        -3 * x * z * z / R**5,
        -3 * y * z * z / R**5,
    ]
    b, c, d = 1 / (R * (R + z) ** 2), 1 / (R**3 * (R + z) ** 2), 2 / (R**2 * (R + z) ** 3)
    tangential = [
        a * (x / R**3 - 3 * x * b + x**3 * (c + d)) - 3 * x**3 / R**5,
        a * (x / R**3 - x * b + x * y * y * (c + d)) - 3 * x * y * y / R**5,
        -3 * x * z * z / R**5,
        a * (-y * b + x * x * y * (c + d)) - 3 * x * x * y / R**5,
        -3 * x * x * z / R**5,
        -3 * x * y * z / R**5,
    ]
    return np.array(normal) / (2 * np.pi), np.array(tangential) / (2 * np.pi)


@pytest.mark.parametrize("row, column, z", [(68, 72, 0.5), (56, 80, 0.3), (40, 60, 0.8)])
def test_sums_of_point_forces(row, column, z):
    """All components, under a pressure and shear stresses along x and y."""
    r, angle = 1 - ((np.arange(200) + 0.5) / 200) ** 2, (np.arange(120) + 0.5) * np.pi / 60
    weight = np.sqrt(1 - r * r) * r * 2 * np.sqrt(1 - r) / 200 * np.pi / 60
    x, y = NODES[column] - r * np.cos(angle[:, None]), NODES[row] - r * np.sin(angle[:, None])
    normal, along_x = (np.sum(each * weight, axis=(1, 2)) for each in point_forces(x, y, z))
    turned = np.sum(point_forces(y, -x, z)[1] * weight, axis=(1, 2))  # y is x there, and x is -y
    along_y = turned[[1, 0, 2, 3, 5, 4]] * [1, 1, 1, -1, -1, 1]
    expected = normal + 0.3 * along_x - 0.2 * along_y
    found = [each[row, column] for each in below(z, HERTZ, 0.3 * HERTZ, -0.2 * HERTZ)]
    np.testing.assert_allclose(found, expected, atol=1e-3)


@pytest.mark.parametrize("nodes", [129, 257])
def test_hertz_line(nodes):
    """Johnson 1985, section 4.2: 0.30 p_h at 0.786 b; by his stresses on the axis the von Mises stress for nu = 0.3."""
    x, z = np.linspace(-3.0, 3.0, nodes), np.linspace(0.01, 2.0, 2000)
    p = np.sqrt(np.maximum(1.0 - x * x, 0.0))[None]
    s = np.sqrt(1 + z * z)
    along, down = -((1 + 2 * z * z) / s - 2 * z), -1 / s
    across = NU * (along + down)
    mises = np.sqrt(((along - down) ** 2 + (down - across) ** 2 + (across - along) ** 2) / 2)
    found = largest(p, x=x, y=np.zeros(1))
    assert found["shear_max"] == pytest.approx(0.3003, rel=2e-3) and "Y_von_mises" not in found
    assert found["Z_shear"] == pytest.approx(0.786, abs=0.01)
    assert found["von_mises_max"] == pytest.approx(mises.max(), rel=2e-3)
    assert found["Z_von_mises"] == pytest.approx(z[mises.argmax()], abs=0.01)
    one = below(0.5, p, 0.2 * p, 0.0 * p, spacing=x[1] - x[0])
    np.testing.assert_allclose(one.yy, NU * (one.xx + one.zz), atol=1e-15)  # plane strain
    assert not one.xy.any() and not one.yz.any()


def test_images_stay_away_from_long_ellipses(monkeypatch):
    """The periods are long enough: twice as long ones change less than 0.001 p_h."""
    ellipse, spacing = hertz_ellipse(0.08), 0.25
    b_y = 1.0 / ellipse.kappa
    assert b_y > 5.0
    x, y = np.arange(-3.0, 3.01, spacing), np.arange(-b_y - 2.0, b_y + 2.01, spacing)
    p = np.sqrt(np.maximum(1.0 - x * x - (y[:, None] / b_y) ** 2, 0.0))
    once = below(0.5, p, 0.0 * p, 0.0 * p, spacing=spacing)
    monkeypatch.setattr(halfspace, "PADDING", 2 * halfspace.PADDING)
    monkeypatch.setattr(halfspace, "MOST_PADDING", 2 * halfspace.MOST_PADDING)
    twice = below(0.5, p, 0.0 * p, 0.0 * p, spacing=spacing)
    assert max(np.abs(one - two).max() for one, two in zip(once, twice, strict=True)) < 1e-3


# -- for any load ------------------------------------------------------------------------------------------------------


def test_the_body_is_in_equilibrium():
    """div sigma = 0 by central differences, whose error falls with the square of the step."""
    x = np.linspace(-2.0, 2.0, 65)
    bump = np.exp(-4 * (x**2 + (x[:, None] - 0.3) ** 2))
    loads, residuals = (bump, 0.5 * x * bump, 0.3 * bump), []
    for step in (1, 2):
        h = step * (x[1] - x[0])
        above, here, lower = (below(z, *loads, spacing=x[1] - x[0]) for z in (0.4 - h, 0.4, 0.4 + h))

        def along(field, axis, step=step, h=h):
            return (np.roll(field, -step, axis) - np.roll(field, step, axis)) / (2 * h)

        forces = (
            along(here.xx, 1) + along(here.xy, 0) + (lower.xz - above.xz) / (2 * h),
            along(here.xy, 1) + along(here.yy, 0) + (lower.yz - above.yz) / (2 * h),
            along(here.xz, 1) + along(here.yz, 0) + (lower.zz - above.zz) / (2 * h),
        )
        residuals.append([np.abs(force[4:-4, 4:-4]).max() for force in forces])
    assert np.max(residuals[0]) < 0.02  # of slopes of about 1
    np.testing.assert_allclose(np.divide(residuals[1], residuals[0]), 4.0, rtol=0.1)


@pytest.mark.parametrize("shape", [(33, 33), (65, 17), (17, 33), (1, 65)])
def test_the_surface_carries_its_loads(shape):
    p, q_x, q_y = RANDOM.random((3, *shape))
    found = below(0.0, p, q_x, q_y if shape[0] > 1 else 0.0 * q_y, spacing=0.1)
    np.testing.assert_allclose(found.zz, -p, atol=1e-13)
    np.testing.assert_allclose(found.xz, -q_x, atol=1e-13)
    np.testing.assert_allclose(found.yz, -q_y if shape[0] > 1 else 0.0 * q_y, atol=1e-13)


def test_linear_and_mirrored():
    one, other = RANDOM.random((2, 3, 17, 33))
    spacing, z = 0.1, 0.15
    first, second = (np.array(below(z, *loads, spacing=spacing)) for loads in (one, other))
    np.testing.assert_allclose(below(z, *(2 * one - other), spacing=spacing), 2 * first - second, atol=1e-13)
    mirrored = np.array([1, 1, -1])[:, None, None] * one[:, ::-1]  # y becomes -y
    signs = np.array([1, 1, 1, -1, 1, -1])[:, None, None]
    np.testing.assert_allclose(below(z, *mirrored, spacing=spacing), signs * first[:, ::-1], atol=1e-13)
    turned = np.swapaxes(one, 1, 2)[[0, 2, 1]]  # x and y change places
    expected = np.swapaxes(first, 1, 2)[[1, 0, 2, 3, 5, 4]]
    np.testing.assert_allclose(below(z, *turned, spacing=spacing), expected, atol=1e-13)


def test_one_row_is_that_of_all_nodes():
    p, q_x, q_y = RANDOM.random((3, 17, 33))
    waves = Waves(17, 33, 0.1)
    loads = [waves.amplitudes(each) for each in (p, q_x, q_y)]
    for z in (0.0, 0.2, 3.0):
        every = waves.below(z, partial(stress_waves, nu=NU), loads)
        row = waves.below(z, partial(stress_waves, nu=NU), loads, row=5)
        np.testing.assert_allclose(np.array(row)[:, 0], np.array(every)[:, 5], atol=1e-13)


def test_invariants_are_those_of_the_principal_stresses():
    xx, yy, zz, xy, xz, yz = components = RANDOM.normal(size=(6, 50))
    matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]).transpose(2, 0, 1)
    low, middle, high = np.linalg.eigvalsh(matrix).T
    one = Stresses(*components)
    np.testing.assert_allclose(tresca(one), (high - low) / 2, rtol=1e-7)
    mises = np.sqrt(((high - low) ** 2 + (high - middle) ** 2 + (middle - low) ** 2) / 2)
    np.testing.assert_allclose(von_mises(one), mises, rtol=1e-12)
    nothing = Stresses(*np.zeros((6, 1)))
    assert tresca(nothing) == von_mises(nothing) == 0.0
    rod = Stresses(*(np.full(1, each) for each in (0.0, 0.0, -2.0, 0.0, 0.0, 0.0)))  # compressed along z
    assert tresca(rod) == pytest.approx(1.0) and von_mises(rod) == pytest.approx(2.0)


# -- what engineers look for -------------------------------------------------------------------------------------------


def test_a_pressure_spike_has_a_largest_stress_of_its_own():
    """Just below it, at a depth of its width; that of the contact stays where it was."""
    x, width = np.linspace(-2.0, 2.0, 513), 0.05
    spike = np.sqrt(np.maximum(1 - ((x - 0.8) / width) ** 2, 0.0))
    p = (np.sqrt(np.maximum(1 - x * x, 0.0)) + spike)[None]
    near, deep = np.linspace(0.0, 0.2, 21), np.linspace(0.3, 1.2, 10)
    upper, lower = (
        np.array([von_mises(below(z, p, 0.0 * p, 0.0 * p, spacing=x[1] - x[0]))[0] for z in depths])
        for depths in (near, deep)
    )
    under = upper[:, np.abs(x - 0.8).argmin()]
    top = int(under.argmax())
    assert 0.3 * width < near[top] < 1.5 * width
    assert under[top] > 1.1 * under[0] and under[top] > 1.2 * under[top:].min()
    assert 0.6 < deep[lower.max(axis=1).argmax()] < 0.9 and lower.max() == pytest.approx(0.558, rel=0.05)


def test_rough_pressures_move_the_largest_stress_to_the_surface():
    length = 0.25
    rough = HERTZ * (1 + np.cos(2 * np.pi * NODES / length) * np.cos(2 * np.pi * NODES[:, None] / length))
    found = largest(rough)
    assert found["Z_von_mises"] < length < 0.48 and found["von_mises_max"] > 1.1 * 0.62  # of the smooth contact
