"""Two runs side by side: equal units, colours and limits."""

import numpy as np
import pytest
from made_up import BALL_FALLS, dry_impact

from ertel import plots


@pytest.fixture(scope="module")
def slow_and_fast():
    """The dry impact at two speeds: other sizes, times, films and pressures in SI, and the unit of films."""
    case = {**BALL_FALLS, "contact": {**BALL_FALLS["contact"], "speed": "0.3 m/s"}}
    return dry_impact(BALL_FALLS, radial=True), dry_impact(case, radial=True)


@pytest.mark.parametrize("name", ["film", "history", "interferogram"])
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
