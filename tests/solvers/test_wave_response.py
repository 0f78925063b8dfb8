"""Waves that pass through a rolling contact: a dense solve, time steps, and limits that need no other solver."""

from dataclasses import replace
from functools import cache

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import ripples
from cases import OIL, march, rolled, steady_solver

from ertel.case.case import Case
from ertel.case.methods import METHODS
from ertel.case.sections import Drive
from ertel.equations import contact, discretise
from ertel.equations.contact import Rate
from ertel.inputs.python import rolling
from ertel.numerics.stencils import folded
from ertel.physics.dry_contact import HERTZ_LOAD
from ertel.physics.fluidity import ReeEyring
from ertel.physics.lubricant import Oil
from ertel.physics.motion import constant
from ertel.physics.scales import Parameters
from ertel.physics.surfaces import Feature, Waviness
from ertel.runs.response import respond_in_rolling
from ertel.solvers import steady
from ertel.solvers.grid_solution import GridSolution
from ertel.solvers.response import RoughnessWave, wave_response
from ertel.solvers.transient import Transient2D

# the response has no oil outside that takes part
pytestmark = pytest.mark.usefixtures("nothing_outside")
P20 = Parameters.from_moes(20, 5)  # a thick film: resolved by few nodes
BALL = {"radius": 0.01, "E_prime": 226e9, "load": 20.0, "mean_speed": 1.0, "slide_to_roll": -2.0}
BALL["oil"] = Oil(eta0=0.04, alpha=20e-9)
WAVE = 1.5  # wavelength: 8 nodes on the small grid


def smooth(drive: Drive | None = None, *features: Feature) -> Case:
    """The small case, of 33 nodes a side."""
    return rolled(P20, OIL, steady_solver(33), drive, *features)


@cache
def film() -> GridSolution:
    return steady.steady_film(smooth()).finest


def wave_on(grid, frequency: float = 2 * np.pi / WAVE) -> RoughnessWave:
    """A wave of unit height that rides with the oil at this frequency, isotropic if it is that of WAVE."""
    X, Y = grid.kept_x[None, :], grid.kept_y[:, None]
    return RoughnessWave(frequency, jnp.asarray(np.exp(-1j * frequency * X) * np.cos(2 * np.pi / WAVE * Y)))


def largest(a, b) -> float:
    return float(np.abs(np.asarray(a) - np.asarray(b)).max())


# -- other ways to the same film --------------------------------------------------------------------------------------


def dense(case: Case, s: GridSolution, wave: RoughnessWave) -> tuple[np.ndarray, complex]:
    """P' and Delta' from the matrix of the equations with the three masses along the flow written out."""
    c, h, shape = discretise.smooth_contact(case, s.grid), s.grid.spacing, s.P.shape
    q = np.exp(-1j * wave.frequency * h)
    _, flux = jax.linearize(jax.jit(lambda P, H: contact.residual(c, P, H, Rate(0.0, 0.0))), s.P, s.H)
    _, mass = jax.linearize(jax.jit(lambda P, H: contact.mass(c, P, H)), s.P, s.H)
    of_changes = jax.jit(lambda es, ds: [jax.vmap(linear)(es, ds) for linear in (mass, flux)])
    free = np.flatnonzero(np.asarray(s.P) > 0)

    def residuals(es, ds) -> np.ndarray:
        """Those of real changes of P and H, each of shape (m, n, n), on the free nodes: one row for each."""
        m, flow = map(np.asarray, of_changes(es, ds))
        rate = (3 * m - 4 * q * np.roll(m, 1, axis=2) + q**2 * np.roll(m, 2, axis=2)) / (2 * h)
        rate[:, :, 1] = (m[:, :, 1] - q * m[:, :, 0]) / h
        return (rate + flow).reshape(len(m), -1)[:, free]

    es = np.eye(s.P.size)[free].reshape(-1, *shape)
    each = jax.jit(jax.vmap(lambda e: (contact.deformation(c, e), contact.pressure_load(c, e))))
    deformed, loads = map(np.asarray, each(es))
    # the last three, without a pressure: the approach and both parts of the wave
    waves = np.stack([-np.ones(shape), np.real(wave.shape), np.imag(wave.shape)])
    rows = residuals(np.append(es, np.zeros((3, *shape)), 0), np.append(deformed, waves, 0))
    rows, (approach, *parts), loads = rows[:-3], rows[-3:], loads[:, None]
    matrix = np.block([[rows, loads], [approach, 0.0]]).T
    found = np.linalg.solve(matrix, np.append(parts[0] + 1j * parts[1], 0.0))
    P = np.zeros(s.P.size, complex)
    P[free] = found[:-1]
    return P.reshape(shape), complex(found[-1])


def test_the_dense_matrix_has_the_same_solution() -> None:
    wave = wave_on(film().grid)
    P, approach = dense(smooth(), film(), wave)
    found = wave_response(smooth(), film(), wave)
    assert found.converged
    assert largest(found.P, P) < 1e-5 * np.abs(P).max()
    assert found.approach == pytest.approx(approach, abs=1e-5)


@pytest.mark.parametrize("slide", [pytest.param(0.0, marks=pytest.mark.slow), 0.5])
def test_time_steps_of_one_cell_come_to_the_same_film(slide: float) -> None:
    """(H(A) - H(-A))/(2 A) of runs from which the start has left: equal but for the square of the height A."""
    A, steps, h = 1e-3, 48, film().grid.spacing
    solver = replace(METHODS["transient"].defaults, nodes=33, tolerance=1e-9)

    def after(height: float):
        feature = Feature(Waviness(height, WAVE, WAVE))
        return march(Transient2D(rolled(P20, OIL, solver, Drive(slide_to_roll=slide), feature)), h, steps)[0]

    high, low = after(A), after(-A)
    case = smooth(Drive(slide_to_roll=slide))
    data = respond_in_rolling(case, [[Feature(Waviness(1.0, WAVE, WAVE))]])
    for name in ("H", "P"):
        angle = data[f"d{name}_phase"][0] + float(data["frequency"][0]) * high.T
        change = folded((data[f"d{name}_amplitude"][0] * np.cos(angle)).values, film().grid.even)
        marched = (high.fields[name] - low.fields[name]) / (2 * A)
        assert largest(marched, change) < 5e-5 * np.abs(change).max()


AT_REST = [
    (smooth(Drive(slide_to_roll=-2.0)), 1e-5),
    pytest.param(rolling(**BALL, rheology=ReeEyring(2e6), nodes=33), 1e-5, marks=pytest.mark.slow),
]


@pytest.mark.parametrize(("case", "close"), AT_REST, ids=["newtonian", "eyring"])
def test_at_rest_it_is_the_change_of_the_steady_film(case: Case, close: float) -> None:
    """Surface 1 at rest, of which the waves are: the wedge alone; the derivative of a thinning oil's flux is exact."""
    A, wave = 1e-4, Waviness(1.0, WAVE, WAVE)
    high, low = (
        steady.steady_film(replace(case, roughness=(Feature(replace(wave, amplitude=a)),))).finest for a in (A, -A)
    )
    found = respond_in_rolling(case, [[Feature(wave)]])
    assert float(found["frequency"][0]) == 0.0
    change = found["dH_amplitude"][0].values * np.cos(found["dH_phase"][0].values)
    assert largest(high.whole((high.H - low.H) / (2 * A)), change) < close * min(1.0, np.abs(change).max())
    assert int(found["response_krylov"].max()) <= 17


@pytest.mark.slow
def test_waves_at_rest_under_a_thick_oil_are_flattened_to_its_compression() -> None:
    """Hooke's linear theory at Q = 2400: C/(1 + C) of the height.  Eight nodes in a wave."""
    case = rolling(**BALL, nodes=65, half_width=2.0, inlet=2.5)
    data = respond_in_rolling(case, ripples.pair(0.5))
    theory = ripples.hooke(case, ripples.centre(case, data), 0.5).clearance
    assert abs(theory) == pytest.approx(0.12, abs=0.01)
    assert abs(ripples.ripples(data, 0, 0.5).clearance - theory) < 0.02


# -- limits -----------------------------------------------------------------------------------------------------------


def test_a_uniform_height_lifts_the_ball_and_changes_nothing_else() -> None:
    found = wave_response(smooth(), film(), RoughnessWave(0.0, jnp.ones(film().P.shape, complex)))
    assert found.approach == pytest.approx(-1.0, abs=1e-6)
    assert largest(found.H, 0.0) < 1e-5
    assert largest(found.P, 0.0) < 1e-5


def test_reversing_the_flow_mirrors_the_response() -> None:
    there = respond_in_rolling(smooth(), [[Feature(Waviness(1.0, WAVE, WAVE, phase_x=0.4))]])
    back = smooth(Drive(entrainment=constant(-1.0)))
    here = respond_in_rolling(back, [[Feature(Waviness(1.0, WAVE, WAVE, phase_x=-0.4))]])
    assert largest(here["dH_amplitude"].values[..., ::-1], there["dH_amplitude"].values) < 1e-5
    assert float(np.abs(there["dH_amplitude"] - there["dH_amplitude"][..., ::-1].values).max()) > 0.1


def test_a_ball_with_inertia_obeys_newtons_law() -> None:
    """Inertia times Delta'' = - omega^2 Delta' is the force that is missing; a heavy ball does not move."""
    wave = wave_on(film().grid)
    balanced, light, heavy = (
        wave_response(smooth(Drive(inertia=inertia)), film(), wave) for inertia in (0.0, 0.1, 1e4)
    )
    force = sum(np.asarray(film().whole(light.P)).ravel()) * film().grid.spacing ** 2 / HERTZ_LOAD
    assert force == pytest.approx(0.1 * wave.frequency**2 * light.approach, rel=1e-4)
    assert abs(heavy.approach) < 1e-3 * abs(balanced.approach)


@cache
def waves_of_three_lengths():
    """Isotropic waves on 65 nodes a side: 4.6, 9 and 18 nodes."""
    case = rolled(Parameters.from_moes(200, 10), Oil(), steady_solver(65, half_width=1.75, inlet=2.25))
    return respond_in_rolling(case, [[Feature(Waviness(0.01, wave, wave))] for wave in (0.25, 0.5, 1.0)])


@pytest.mark.slow
def test_short_waves_keep_their_amplitude() -> None:
    """A_d/A_i falls with the wavelength, from 1; and outside the contact nothing deforms the waves."""
    data = waves_of_three_lengths()
    short, middle, long = data["dH_amplitude"].sel(X=0.0, Y=0.0, method="nearest").values / 0.01
    assert 1.0 > short > middle > long > 0.5
    assert 1.0 - short < (1.0 - middle) / 2
    outside = data["dH_amplitude"].sel(X=slice(1.2, None), Y=0.0).values / 0.01
    np.testing.assert_allclose(outside, 1.0, atol=0.03)


@pytest.mark.slow
def test_work() -> None:
    """Krylov iterations do not depend on the wave; time steps would take 300 convolutions a wavelength and more."""
    data = waves_of_three_lengths()
    assert data.attrs["status"] == "converged"
    assert int(data["response_krylov"].max()) <= 17
    assert float(data["response_convolutions"].max()) <= 60
