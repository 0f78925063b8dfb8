"""Pictures: that the axes carry the numbers of the run, in the units that they say."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_rgba

from ertel.inputs.case_files import parse_case
from ertel.physics import hertz
from ertel.results import variables
from ertel.results.plots import transient
from ertel.runs.drive import Frame

BALL = {
    "contact": {"radius": "10 mm", "mass": "32.6726 g", "speed": "0.1 m/s", "E_prime": "226.37 GPa"},
    "lubricant": {"eta0": "0.1 Pa*s", "alpha": "22 / GPa"},
}
MOES = {"contact": {"M": 1000, "L": 10}}


def made_up(case_data, radial=False, rebound=True) -> xr.Dataset:
    """The dry impact with a made-up film: everything about it is known."""
    case = parse_case(case_data)
    times = np.linspace(0.05, 3.9 if rebound else 2.45, 78 if rebound else 49)
    axis = np.linspace(0, 2, 41) if radial else np.linspace(-2, 2, 81)
    r = axis if radial else np.hypot(axis[:, None], axis[None, :])
    records, frames = [], []
    for T in times:
        A = max(float(hertz.contact_radius(T - 1)), 1e-3)
        P, H = hertz.pressure(r, A), hertz.gap(r, A) + 0.05 + max(1 - T, 0)
        scalars = {"Delta": float(hertz.approach(T - 1)), "V": float(hertz.velocity(T - 1)), "F": A**3}
        scalars |= {"P_c": A, "P_max": A, "H_c": float(H.min()), "H_min": float(H.min()) / 2, "X_min": A}
        records.append({"T": T, **dict.fromkeys(variables.SCALARS, 0.0), **scalars})
        event = "max-approach" if abs(T - 2.45) < 1e-9 else ""
        frames.append(Frame(float(T), {"P": P, "H": H}, event))
    coordinates = {"r": axis} if radial else {"Y": axis, "X": axis}
    return variables.assemble(case, records, frames, coordinates)


@pytest.fixture(scope="module")
def ball():
    return made_up(BALL)


@pytest.fixture(scope="module")
def moes():
    return made_up(MOES)


def panels(figure):
    """The axes of a figure without those of colour bars."""
    return [axes for axes in figure.axes if axes.get_label() != "<colorbar>"]


def line(axes, label):
    (found,) = [candidate for candidate in axes.get_lines() if candidate.get_label() == label]
    return found


# -- labels -----------------------------------------------------------------------------------------------------------


def test_physical_labels_have_si_units(ball):
    film, pressure, film_profiles, *_ = panels(transient.overview(ball))[0], *panels(transient.overview(ball))[3:5]
    assert film.get_xlabel() == "$x$ (µm)"
    assert film.get_ylabel() == "$y$ (µm)"
    assert pressure.get_title().endswith("GPa")
    assert film_profiles.get_ylabel() == r"pressure $p$ (GPa)"
    motion = panels(transient.history(ball))[0]
    assert motion.get_xlabel() == "time $t$ (µs)"


def test_dimensionless_labels_have_the_papers_units(moes):
    film, pressure = panels(transient.profiles(moes))
    assert film.get_xlabel() == "$X$ ($a^*$)"
    assert film.get_ylabel() == "film thickness $H$ ($a^{*2}/R$)"
    assert pressure.get_ylabel() == "pressure $P$ ($p_h^*$)"


@pytest.mark.parametrize("name", transient.FIGURES)
@pytest.mark.parametrize("data", ["ball", "moes"])
def test_every_panel_says_what_it_shows(name, data, request):
    for axes in panels(transient.FIGURES[name](request.getfixturevalue(data))):
        assert axes.get_xlabel()
        assert axes.get_ylabel()
        assert axes.get_title() or axes.get_legend()


def test_title_says_the_conditions(ball, moes):
    title = transient.overview(ball).get_suptitle()
    assert "10 mm" in title and "0.1 m/s" in title and "1.394 GPa" in title and "maximum approach" in title
    assert "$M$ = 1000" in transient.overview(moes).get_suptitle()


def test_name_is_the_title():
    assert transient.maps(made_up({**MOES, "name": "my_case"})).get_suptitle().startswith("My case:")


# -- data -------------------------------------------------------------------------------------------------------------


def test_profile_at_maximum_approach(ball):
    film, pressure = panels(transient.profiles(ball))
    frame = int(np.flatnonzero(ball["event"].values)[0])
    scales = parse_case(BALL).scales
    assert scales is not None
    shown = line(film, "maximum approach")
    np.testing.assert_allclose(shown.get_xdata(), ball["X"].values * scales.a * 1e6)
    np.testing.assert_allclose(shown.get_ydata(), ball["H"].values[frame, 40] * scales.film * 1e9)  # thin: in nm
    assert film.get_ylabel() == "film thickness $h$ (nm)"
    assert to_rgba(shown.get_color()) == to_rgba("black")
    np.testing.assert_allclose(
        line(pressure, "maximum approach").get_ydata(), ball["P"].values[frame, 40] * scales.p_h * 1e-9
    )


def test_radial_profiles_are_mirrored():
    data = made_up(MOES, radial=True)
    shown = line(panels(transient.profiles(data))[1], "maximum approach")
    x, P = shown.get_xdata(), shown.get_ydata()
    assert len(x) == 81
    np.testing.assert_array_equal(x, -x[::-1])
    np.testing.assert_array_equal(P, P[::-1])
    assert P[40] == P.max()


def test_radial_map_is_the_profile_turned_round():
    field = transient.map_of(made_up(MOES, radial=True), "P", 48)
    r = np.hypot(field.y[:, None], field.x[None, :])
    np.testing.assert_allclose(field.values, hertz.pressure(r, float(hertz.contact_radius(1.45))), atol=0.12)
    np.testing.assert_array_equal(field.values, field.values.T)


def test_map_shows_the_film(moes):
    axes = panels(transient.maps(moes))[0]
    (mesh,) = [c for c in axes.collections if type(c).__name__ == "QuadMesh"]
    values = np.asarray(mesh.get_array())
    frame = int(np.flatnonzero(moes["event"].values)[0])
    cut = (81 - len(values)) // 2  # the part round the contact
    assert 0 < cut < 30
    np.testing.assert_array_equal(values, moes["H"].values[frame, cut:-cut, cut:-cut])
    step = float(axes.get_title().split()[-2])
    (contours,) = [c for c in axes.collections if type(c).__name__ == "QuadContourSet"]
    np.testing.assert_allclose(np.diff(contours.levels), step)


def test_rebound_is_dashed(moes):
    axes = panels(transient.profiles(moes))[0]
    lines = [candidate for candidate in axes.get_lines() if len(candidate.get_xdata()) > 0]
    assert {candidate.get_linestyle() for candidate in lines} == {"-", "--"}
    assert line(axes, "rebound").get_linestyle() == "--"


def test_without_maximum_the_last_map_is_shown():
    data = made_up(MOES).isel(frame=slice(0, 30))
    axes = panels(transient.profiles(data))[1]
    np.testing.assert_array_equal(line(axes, "last map").get_ydata(), data["P"].values[-1, 40])


def test_histories(moes):
    motion, film, front, pressure = panels(transient.history(moes))
    T = moes["time"].values
    np.testing.assert_array_equal(line(motion, "load $F/F^*$").get_xdata(), T)
    np.testing.assert_array_equal(line(motion, "load $F/F^*$").get_ydata(), moes["F"].values)
    assert film.get_yscale() == "log"
    assert len(film.get_lines()) == len(pressure.get_lines()) == 3  # two curves and the moment of the maximum
    dry = line(front, "edge of the dry contact").get_ydata()
    np.testing.assert_allclose(np.nanmax(dry), 1.0, atol=1e-3)
    made_of = line(front, "front: place of the least film").get_ydata()
    loaded = np.isfinite(made_of)
    np.testing.assert_allclose(made_of[loaded & np.isfinite(dry)], dry[loaded & np.isfinite(dry)])


def test_histories_mark_the_maximum(ball):
    motion = panels(transient.history(ball))[0]
    scales = parse_case(BALL).scales
    assert scales is not None
    moment = [candidate for candidate in motion.get_lines() if candidate.get_linestyle() == ":"]
    np.testing.assert_allclose(moment[0].get_xdata(), 2.45 * scales.t0 * 1e6)


@pytest.mark.parametrize(("largest", "unit"), [(1.0, "µm"), (0.01, "nm"), (300.0, "mm")])
def test_prefix_fits(ball, largest, unit):
    shown = transient.scale(ball, "H", largest)
    assert shown.unit == unit
    assert 0.5 <= largest * shown.factor < 500


def test_short_runs_can_be_drawn():
    data = made_up(MOES).isel(frame=slice(0, 1), time=slice(0, 1))
    for draw in transient.FIGURES.values():
        draw(data).draw_without_rendering()


def test_a_film_that_vanishes_can_be_drawn():
    data = made_up(MOES)
    data["H_min"][40:] = 0.0
    film = panels(transient.history(data))[1]
    assert film.get_ylim()[0] > 0


def test_a_run_without_maps_says_so():
    data = made_up(MOES).isel(frame=slice(0, 0))
    with pytest.raises(ValueError, match="no maps"):
        transient.overview(data)


def test_impact_has_no_flow(moes):
    assert not [text for axes in panels(transient.maps(moes)) for text in axes.texts if text.get_text() == "flow"]


def test_long_headings_are_broken(ball):
    heading = transient.overview(ball).get_suptitle()
    assert heading.count("\n") == 0
    assert transient.maps(ball).get_suptitle().replace("\n", "  ") == heading


def test_nothing_is_shown_and_pyplot_is_left_alone():
    import subprocess
    import sys

    code = "import sys, ertel.results.plots.transient; print('matplotlib.pyplot' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout.strip() == "False"
