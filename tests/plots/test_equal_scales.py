"""Two runs side by side: equal units, colours and limits."""

import numpy as np
import pytest
from made_up import BALL_FALLS, BALL_ROLLS, MOES_FALLS, dry_impact, steady

from ertel import plots


@pytest.fixture(scope="module")
def slow_and_fast():
    """The dry impact at two speeds: other sizes, times, films and pressures in SI, and the unit of films."""
    case = {**BALL_FALLS, "contact": {**BALL_FALLS["contact"], "speed": "0.3 m/s"}}
    return dry_impact(BALL_FALLS, radial=True), dry_impact(case, radial=True)


@pytest.mark.parametrize("name", ["film", "pressure", "profiles", "history", "friction", "interferogram"])
def test_two_runs_on_equal_scales(slow_and_fast, name):
    """Panels at the same place have the same labels, limits and colours; those of one run alone have others."""
    one, two = (figure.axes for figure in plots.side_by_side(slow_and_fast, name, ("max-approach", 1.05)))
    assert len(one) == len(two)
    for here, there in zip(one, two, strict=True):
        for what in ("xlabel", "ylabel", "yscale"):
            assert getattr(here, f"get_{what}")() == getattr(there, f"get_{what}")(), (here.get_title(), what)
        assert limits_of([here]) == pytest.approx(np.array(limits_of([there])), rel=1e-12)
        for image, other in zip(here.images, there.images, strict=True):
            assert (
                image.get_clim() == pytest.approx(other.get_clim(), rel=1e-12) and image.get_cmap() == other.get_cmap()
            )
    alone = [getattr(plots, name)(data, at) for data, at in zip(slow_and_fast, ("max-approach", 1.05), strict=True)]
    assert limits_of(alone[0].axes) != limits_of(alone[1].axes)


def limits_of(axes):
    return [(*each.get_xlim(), *each.get_ylim()) for each in axes]


def test_equal_scales_of_runs_that_differ(slow_and_fast):
    """A run in time beside a steady contact; without SI scales in one, both have none."""
    rolls = steady(BALL_ROLLS)
    time, contact = plots.side_by_side((slow_and_fast[0], rolls), "film", ("max-approach", None))
    assert time.axes[0].images[0].get_clim() == pytest.approx(contact.axes[0].images[0].get_clim(), rel=1e-12)
    assert limits_of(time.axes[:1]) == pytest.approx(np.array(limits_of(contact.axes[:1])), rel=1e-12)
    for figure in plots.side_by_side((slow_and_fast[0], dry_impact(MOES_FALLS)), "pressure", (1.0, 1.0)):
        assert figure.axes[0].get_xlabel() == "$X$ ($a^*$)"
    with pytest.raises(plots.NoFigure, match="history: a steady contact has no such figure"):
        plots.side_by_side((slow_and_fast[0], rolls), "history")
