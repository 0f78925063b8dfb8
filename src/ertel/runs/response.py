"""The response of a contact to roughness: dH = H_rough - H_smooth.

Impact, at maximum approach, eq. (17): rough impacts run in lockstep with the smooth one, on its grid and its time
steps, so that their difference is the roughness and not the discretisation.  Or the response is computed directly, as
the derivative of the run with respect to the height of the roughness (tangent-linear).

Rolling over waviness of small height: the response of the steady film is periodic, and found without time steps.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import inf, pi

import numpy as np
import xarray as xr
from jax import Array

from ertel.case.case import Case
from ertel.case.records import scaled_all
from ertel.case.sections import Time
from ertel.case.status import Status
from ertel.equations import discretise
from ertel.equations.state import State, combined, interpolated
from ertel.inputs.case_files import CaseLike, as_case
from ertel.numerics import bdf
from ertel.numerics.grid import Grid
from ertel.numerics.programs import double_precision
from ertel.physics import surfaces
from ertel.physics.motion import Motion
from ertel.physics.surfaces import Feature, Waviness
from ertel.physics.units import plain
from ertel.results import diagnostics
from ertel.results.dataset import assemble_steady
from ertel.results.diagnostics import LARGE_ERROR
from ertel.runs.drive import Observer, Recorder, drive, warn
from ertel.runs.stepping import Step, TransientRun, frame_of, turning_time
from ertel.runs.workers import check_fork, one_blas_thread
from ertel.solvers import SOLVERS, steady
from ertel.solvers.response import RoughnessWave, WaveResponse, tangent_start, tangent_step, wave_response
from ertel.solvers.steady import Rolling
from ertel.solvers.transient import Transient2D

FILM_CHANGE = {"long_name": "change of the film thickness by the roughness", "symbol": "dH", "units": "1"}
PRESSURE_CHANGE = {"long_name": "change of the pressure by the roughness", "symbol": "dP", "units": "1"}
BOUND = "bound of the discretisation error of the amplitude of dH at the centre"
ERROR = {"long_name": BOUND, "symbol": "dH_error", "units": "1"}
Field = tuple[tuple[str, ...], np.ndarray, dict[str, str]]  # a variable: dimensions, values, attributes
HEIGHT = {"long_name": "height of the roughness", "symbol": "R", "units": "1"}
Roughnesses = Sequence[Sequence[Feature]]  # one for each response


@dataclass
class Companion:
    """A run that makes the same steps as the smooth one: a rough impact, or the derivative of the smooth one.

    advance: the next level, from the levels of the smooth run (newest first) and those of this one.  film_change: dH,
    from a level of this run and the same one of the smooth run.
    """

    levels: list[State]
    advance: Callable[[Sequence[State], Sequence[State]], State]
    film_change: Callable[[State, State], Array]


def rough_run(case: Case) -> Companion:
    """A rough impact of finite height."""
    method = Transient2D(case)

    def advance(smooth: Sequence[State], levels: Sequence[State]) -> State:
        return method.advance(levels, smooth[0].T - smooth[1].T)

    return Companion([method.start()], advance, lambda rough, smooth: rough.H - smooth.H)


def tangent_run(method: Transient2D, features: Sequence[Feature]) -> Companion:
    """The derivative of the smooth impact with respect to the height of the roughness, times the roughness."""
    height = partial(discretise.heights, features, method.case, method.grid)

    def advance(smooth: Sequence[State], levels: Sequence[State]) -> State:
        return tangent_step(method, smooth, levels, height(smooth[0].T))

    return Companion([tangent_start(height(0.0))], advance, lambda change, smooth: change.H)


class Lockstep:
    """An observer of the smooth run: every companion repeats its step."""

    def __init__(self, companions: Sequence[Companion]):
        self.companions, self.status = companions, Status.CONVERGED

    def __call__(self, step: Step) -> bool:
        """Repeat the step; return True if a companion has failed, so that the run stops."""
        for companion in self.companions if step.record else ():
            new = companion.advance(step.state.levels, companion.levels)
            companion.levels = [new, *companion.levels][:3]
            self.status = new.status if self.status.ok else self.status
        return not self.status.ok


@double_precision()
def respond(case: CaseLike, roughnesses: Roughnesses, observers: Sequence[Observer] = ()) -> xr.Dataset:
    """The smooth impact up to maximum approach, and the change due to each roughness of finite height.

    Parameters
    ----------
    case : Case, str, Path or mapping
        An impact by the method "2d"; its own roughness is left out of the smooth run.
    roughnesses : sequence of sequences of Feature
        One for each response.  Heights in a^2/R or, of a physical case, quantities; positive = metal towards the film.
    observers : sequence of callables
        Each sees every step of the smooth run.

    Returns
    -------
    xarray.Dataset
        H, P (Y, X) of the smooth impact at maximum approach, its scalars over time, and dH, roughness (wave, Y, X) in
        units a*^2/R; of a line contact all without Y.  The attribute `status` is not "converged" where a run gave up;
        dH is then not to be used.

    Raises
    ------
    ValueError
        The case has another method, or no scale for a quantity; before anything is computed.
    """
    smooth, roughnesses = _smooth(as_case(case), roughnesses)
    companions = [rough_run(replace(smooth, roughness=tuple(features))) for features in roughnesses]
    return _in_lockstep(Transient2D(smooth), companions, roughnesses, observers)


@double_precision()
def respond_linearly(case: CaseLike, roughnesses: Roughnesses, observers: Sequence[Observer] = ()) -> xr.Dataset:
    """The tangent-linear response: the limit of `respond` as the height of the roughness goes to zero.

    Parameters
    ----------
    case, roughnesses, observers
        As in `respond`.

    Returns
    -------
    xarray.Dataset
        As of `respond`.

    Raises
    ------
    ValueError
        As in `respond`.
    """
    smooth, roughnesses = _smooth(as_case(case), roughnesses)
    _check_flooded(smooth)
    method = Transient2D(smooth)
    companions = [tangent_run(method, features) for features in roughnesses]
    return _in_lockstep(method, companions, roughnesses, observers)


def _check_flooded(case: Case) -> None:
    """A meniscus moves with the roughness, which a linear response does not know."""
    if case.touches:
        raise ValueError("surfaces.asperities: must be left out for a linear response; asperities touch here")
    if case.layer is not None:
        raise ValueError(f"lubricant.layer: must be left out for a linear response; it is {case.layer:.4g} a^2/R here")


def _smooth(case: Case, roughnesses: Sequence[Sequence[Feature]]) -> tuple[Case, list[tuple[Feature, ...]]]:
    """The smooth impact up to maximum approach, on a part of the plane that all responses share; and these, scaled."""
    if not case.starts_apart or SOLVERS[case.solver.method] is not Transient2D:
        raise ValueError(f'solver.method = "{case.solver.method}": must be "2d" for a response to roughness')
    check_fork()
    scaled = [scaled_all(some, case.scales, f"roughnesses[{n}]") for n, some in enumerate(roughnesses, 1)]
    fold = case.solver.fold and all(surfaces.even(features) == (True, True) for features in scaled)
    solver, time = replace(case.solver, fold=fold), replace(case.time or Time(), until="max-approach")
    return replace(case, roughness=(), solver=solver, time=time), scaled


def _in_lockstep(
    method: Transient2D, companions: Sequence[Companion], roughnesses: Roughnesses, observers: Sequence[Observer]
) -> xr.Dataset:
    """The smooth run with its companions, and all fields at maximum approach, interpolated between the last levels."""
    smooth = method.case
    run = TransientRun(smooth, method)
    recorder, lockstep = Recorder(run), Lockstep(companions)
    last = drive(run, [recorder, lockstep, *observers])
    status = last.status if lockstep.status.ok else lockstep.status
    levels = last.state.levels
    T = turning_time(levels) if status.ok else levels[0].T
    frame = frame_of(method, interpolated(levels, T), "max-approach")
    data = run.dataset(recorder.records, [frame], last).assign_attrs(status=status.value).isel(frame=0)

    weights = bdf.interpolation_weights(T, [level.T for level in levels])
    changes = [combined(weights, list(map(each.film_change, each.levels, levels))) for each in companions]
    heights = [discretise.heights(features, smooth, method.grid, 0.0) for features in roughnesses]
    data = data.assign(dH=_field(map(method.whole, changes), FILM_CHANGE))
    return data.assign_coords(roughness=_field(map(method.whole, heights), HEIGHT))


def _field(fields: Iterable[Array], attributes: Mapping[str, str]) -> Field:
    """A variable of the dataset: the whole fields of all responses, on the plane or along a line."""
    values = np.stack([np.asarray(field) for field in fields])
    return ("wave", *("Y", "X")[3 - values.ndim :]), values, dict(attributes)


# -- rolling ----------------------------------------------------------------------------------------------------------


@double_precision()
@one_blas_thread()
def respond_in_rolling(case: CaseLike, roughnesses: Sequence[Sequence[Feature]]) -> xr.Dataset:
    """The periodic response of a steady rolling contact to waviness that passes through it, linear in its height.

    It is the film that a run in time reaches when waves of small height have passed, with time steps of one cell.

    Parameters
    ----------
    case : Case, str, Path or mapping
        Rolling by the method "steady".  Roughness of its own, which is at rest, belongs to the steady film.
    roughnesses : sequence of sequences of Feature
        One for each response: waviness without a front.  All features of a response must pass with one frequency.

    Returns
    -------
    xarray.Dataset
        The steady film, as `ertel.simulate` gives it.  For each response dH_amplitude and dH_phase (wave, Y, X) of
        dH(T) = dH_amplitude cos(frequency T + dH_phase), in units a^2/R and radians; likewise dP in units p_h;
        frequency (wave) in 1/t0; roughness (wave, Y, X) at T = 0.  A_d/A_i of a wave of height A at the centre is
        `dH_amplitude.sel(X=0, Y=0, method="nearest")/A`.  dH_error (wave): a bound of the discretisation error of
        dH_amplitude there, its change from the grid with twice the spacing; nan without one.  response_krylov,
        response_convolutions (wave): the work.
        The attribute `status` is not "converged" where a solve gave up; the response is then not to be used.

    Raises
    ------
    ValueError
        The case has another method, a shape is not a wave, or a response has several frequencies.

    Warns
    -----
    UserWarning
        The discretisation error is above a tenth of the amplitude, or not known.
    """
    case = as_case(case)
    if SOLVERS[case.solver.method] is not steady.SteadyFilm:
        raise ValueError(f'solver.method = "{case.solver.method}": must be "steady" for the response to passing waves')
    _check_flooded(case)
    check_fork()
    features = [_passing(case, some, f"roughnesses[{n}]") for n, some in enumerate(roughnesses, 1)]
    fold = case.solver.fold and all(surfaces.even(some)[0] for some in features)
    case = replace(case, solver=replace(case.solver, fold=fold))
    rolling = steady.steady_film(case)
    film = rolling.finest
    waves = [_wave(case, some, film.grid) for some in features]
    responses = [wave_response(case, film, wave) for wave in waves]
    status = film.status if all(response.converged for response in responses) else Status.NEWTON_STALLED
    data = assemble_steady(case, film.grid, rolling.solutions).assign_attrs(status=status.value)
    data["frequency"] = "wave", np.array([wave.frequency for wave in waves])
    for name in ("krylov", "convolutions"):
        data[f"response_{name}"] = "wave", np.array([getattr(response, name) for response in responses])
    data = data.assign(_oscillation("dH", FILM_CHANGE, [film.whole(response.H) for response in responses]))
    data = data.assign(_oscillation("dP", PRESSURE_CHANGE, [film.whole(response.P) for response in responses]))
    data = data.assign(dH_error=("wave", _errors(case, rolling, features, responses), ERROR))
    failure = diagnostics.steady_failure(case, film)
    warn([*([failure] if failure else []), *_error_warnings(data, film.grid.nodes)], frames=3)  # above two decorators
    return data.assign_coords(roughness=_field((film.whole(wave.shape.real) for wave in waves), HEIGHT))


def _errors(case: Case, rolling: Rolling, features: Roughnesses, responses: Sequence[WaveResponse]) -> np.ndarray:
    """The change of the amplitude of each response at the centre from the coarser grid.

    It is three times the error where that falls with the square of the spacing, and about the error on coarse grids:
    for M = 200, L = 10 and 65 nodes 20, 29, 33 % at wavelengths 0.5, 1, 2, where the errors are 17, 25, 26 %.
    """

    def at_centre(grid: Grid, field: Array) -> float:
        row, column = (int(np.abs(axis).argmin()) for axis in (grid.kept_y, grid.kept_x))
        return float(abs(field[row, column]))

    errors = np.full(len(responses), np.nan)
    *coarser, film = rolling.solutions
    if coarser and coarser[-1].status.ok:
        for number, (some, fine) in enumerate(zip(features, responses, strict=True)):
            coarse = wave_response(case, coarser[-1], _wave(case, some, coarser[-1].grid))
            if coarse.converged:
                errors[number] = abs(at_centre(film.grid, fine.H) - at_centre(coarser[-1].grid, coarse.H))
    return errors


def _error_warnings(data: xr.Dataset, nodes: int) -> list[str]:
    """Sentences about responses that are uncertain on this grid, or whose error is not known."""
    amplitude = data["dH_amplitude"]
    centre = amplitude.sel({axis: 0.0 for axis in amplitude.dims[1:]}, method="nearest").values
    shares = data["dH_error"].values / np.maximum(centre, np.finfo(float).tiny)
    sentences = []
    for n, (share, amplitude) in enumerate(zip(shares, centre, strict=True), 1):
        if share > LARGE_ERROR and amplitude > 0:
            uncertain = f"the response at the centre is uncertain by up to {share:.0%} on this grid"
            sentences.append(f"roughnesses[{n}]: {uncertain}; use solver.nodes >= {2 * nodes - 1}")
    if np.isnan(shares).any():
        sentences.append("there is no error estimate of the response, because there is no solution on a coarser grid")
    return sentences


def _passing(case: Case, features: Sequence[Feature], place: str) -> tuple[Feature, ...]:
    """The features in the units of the case, all of them waves that pass with one frequency."""
    scaled = scaled_all(features, case.scales, place)
    for number, feature in enumerate(scaled, 1):
        shape = feature.shape
        if not isinstance(shape, Waviness):
            kind = type(shape).__name__
            raise ValueError(f"{place}[{number}].shape = {kind}: must be a waviness, which returns after a period")
        if shape.front != inf:
            raise ValueError(f"{place}[{number}].front = {shape.front}: must be infinite, waves pass at all times")
    frequencies = [_frequency(case.motion, feature) for feature in scaled]
    if not np.allclose(frequencies, frequencies[:1], rtol=1e-9):
        listed = ", ".join(f"{frequency:g}" for frequency in frequencies)
        raise ValueError(f"{place}: its features have frequencies {listed}; must be the same, else one response each")
    return scaled


def _frequency(motion: Motion, feature: Feature) -> float:
    """The frequency at which a wave passes a point of the contact, in 1/t0."""
    assert isinstance(feature.shape, Waviness)
    return 2 * pi / plain(feature.shape.wavelength_x) * abs(motion.travel(feature.surface, 1.0))


def _wave(case: Case, features: Sequence[Feature], grid: Grid) -> RoughnessWave:
    """The features as one wave: its imaginary part is the height a quarter of a period later, with a minus sign."""
    frequency = max((_frequency(case.motion, feature) for feature in features), default=0.0)
    now = discretise.heights(features, case, grid, 0.0)
    if frequency == 0:
        return RoughnessWave(0.0, now + 0j)
    return RoughnessWave(frequency, now - 1j * discretise.heights(features, case, grid, pi / (2 * frequency)))


def _oscillation(name: str, attributes: Mapping[str, str], fields: Sequence[Array]) -> dict[str, Field]:
    """The variables of the amplitude and the phase of complex fields."""
    long_name = attributes["long_name"]
    amplitude = {**attributes, "long_name": f"amplitude of the {long_name}"}
    phase = {**attributes, "long_name": f"phase of the {long_name}", "units": "rad"}
    dims, values, _ = _field(fields, attributes)
    return {f"{name}_amplitude": (dims, np.abs(values), amplitude), f"{name}_phase": (dims, np.angle(values), phase)}
