"""Text maps as programs export them: read right, or refused with the line; never silently wrong."""

from pathlib import Path

import numpy as np
import pytest

from ertel.inputs.case_files import parse_case
from ertel.inputs.text_maps import check_marks, check_matrix, is_list, map_of_points, read_rows

X, Y = np.meshgrid(np.arange(6) * 0.5, np.arange(5) * 0.5)
HEIGHTS = np.round(0.05 * np.sin(3 * X) * np.cos(2 * Y) + 0.01 * np.cos(7 * X + Y), 5)
POINTS = np.column_stack([X.ravel(), Y.ravel(), HEIGHTS.ravel()])


def rows(numbers: np.ndarray, separator: str = " ", comma: bool = False) -> list[str]:
    lines = [separator.join(f"{number:.5f}" for number in row) for row in numbers]
    return [line.replace(".", ",") for line in lines] if comma else lines


def read(lines: list[str]) -> tuple[np.ndarray, float]:
    """The heights and the length along x; 0 of a matrix."""
    text = read_rows("\n".join(lines).encode())
    if is_list(text):
        heights, lengths, _ = map_of_points(text)
        length = lengths[0] if lengths else 0.0
    else:
        check_matrix(text)
        heights, length = text.numbers, 0.0
    check_marks(heights)
    return heights, length


def changed(row: int, column: int, word: str) -> list[str]:
    lines = [line.split() for line in rows(HEIGHTS)]
    lines[row][column] = word
    return [" ".join(line) for line in lines]


PLACES, PROFILE = 0.5 * np.arange(30), np.round(0.1 * HEIGHTS.ravel(), 5)
STYLUS = np.column_stack([PLACES, PROFILE])
GWYDDION = "   Profile 1", "   x     y", "  [mm]  [um]"  # above the numbers of a graph


@pytest.mark.parametrize(
    ("lines", "heights", "length"),
    [
        (rows(HEIGHTS), HEIGHTS, 0.0),
        (rows(HEIGHTS, ","), HEIGHTS, 0.0),
        (rows(HEIGHTS, ";", comma=True), HEIGHTS, 0.0),
        (rows(HEIGHTS, "\t", comma=True), HEIGHTS, 0.0),
        (rows(HEIGHTS, " ", comma=True), HEIGHTS, 0.0),
        (["# some words", *rows(HEIGHTS)], HEIGHTS, 0.0),
        (rows(POINTS), HEIGHTS, 3.0),
        (rows(POINTS[::-1]), HEIGHTS, 3.0),
        (rows(np.random.default_rng(0).permutation(POINTS)), HEIGHTS, 3.0),
        (["X [mm]\tY [mm]\tZ [mm]", *rows(POINTS, "\t")], 1e-3 * HEIGHTS, 3e-3),
        (["X;Y;Z", "mm;mm;mm", *rows(POINTS, ";")], 1e-3 * HEIGHTS, 3e-3),
        # A profile is a list of places and heights, or of heights
        (rows(STYLUS), PROFILE, 15.0),
        (rows(STYLUS[::-1]), PROFILE, 15.0),
        (rows(STYLUS, ", "), PROFILE, 15.0),
        (rows(STYLUS, ";", comma=True), PROFILE, 15.0),
        (rows(STYLUS, "  ", comma=True), PROFILE, 15.0),
        (["Operator: X", "x (mm)\tz (um)", *rows(STYLUS, "\t")], 1e-6 * PROFILE, 15e-3),
        (["x;h", "mm;um", *rows(STYLUS, ";", comma=True)], 1e-6 * PROFILE, 15e-3),
        ([*GWYDDION, *rows(STYLUS)], 1e-6 * PROFILE, 15e-3),
        (["x_mm, y_mm, z_um", *rows(np.insert(STYLUS, 1, 3.0, axis=1), ",")], 1e-6 * PROFILE, 15e-3),
        (["z (um)", *rows(STYLUS[:, 1:])], 1e-6 * PROFILE, 0.0),
        (["# X Position, Height", *rows(STYLUS)], PROFILE, 15.0),
        (rows(STYLUS[:, 1:]), PROFILE, 0.0),
    ],
)
def test_what_is_read_is_right(lines, heights, length):
    found, along_x = read(lines)
    np.testing.assert_allclose(found, heights, rtol=1e-9, atol=1e-15)
    assert along_x == pytest.approx(length)


def test_units_of_a_header_may_differ(tmp_path: Path):
    lines = ["X [mm]\tY [mm]\tZ [um]", *(f"{x * 1e-3:.5f}\t{y * 1e-3:.5f}\t{z:.5f}" for x, y, z in POINTS)]
    heights, length = read(lines)
    assert length == pytest.approx(3e-6)
    np.testing.assert_allclose(heights, 1e-6 * HEIGHTS, rtol=1e-9, atol=1e-18)
    # Through a case: what the reader of the instrument's files took for a map of 30 x 4 is refused.
    np.savetxt(tmp_path / "map.txt", np.column_stack([POINTS, np.arange(30)]))
    table = {"shape": "measured", "file": "map.txt", "unit": "um", "length_x": 3.0}
    with pytest.raises(ValueError, match=r"^roughness\[1\].file = \"map.txt\": is a list of points with 4 columns"):
        parse_case({"contact": {"M": 1000, "L": 10}, "roughness": [table]}, tmp_path)


@pytest.mark.parametrize(
    ("lines", "complaint"),
    [
        (changed(2, 3, "***"), r"line 3: '\*\*\*' is not a number; a gap is written nan"),
        (changed(0, 0, "***"), r"line 1: '\*\*\*' is not a number"),
        ([*rows(HEIGHTS)[:2], "0.1 0.2", *rows(HEIGHTS)[2:]], "line 3 has 2 numbers, and line 1 has 6"),
        (rows(np.column_stack([np.r_[0.0, Y[:, 0]], np.vstack([X[0], HEIGHTS])])), "line 1: the first row has places"),
        (rows(np.vstack([X[0], HEIGHTS])), "line 1: the first row has places"),
        (rows(np.column_stack([Y[:, 0], HEIGHTS])), "the first column has places"),
        *((changed(1, 1, mark), "marks a gap") for mark in ("-9999", "-32768", "1e30", "9999", "-1e10", "3.4e38")),
        (rows(np.where(HEIGHTS == HEIGHTS.max(), 9999.0, 1e3 * HEIGHTS)), "marks a gap"),  # 97 ranges away
        (rows(np.column_stack([POINTS, np.arange(30)])), "a list of points with 4 columns"),
        (rows(np.column_stack([np.arange(30), POINTS])), "a list of points with 4 columns"),
        (rows(np.delete(POINTS, 7, axis=0)), "1 of its 6 x 5 points are missing"),
        (rows(np.vstack([POINTS, POINTS[4]])), "this point is given 2 times"),
        (["Y [mm] X [mm] Z [um]", *rows(POINTS)], "must have x, y and z in this order"),
        (["X Y Z [um]", *rows(POINTS)], "with all units or none"),
        (["X Y Intensity", *rows(POINTS)], "is not understood"),
        (["distance (mm)", *rows(POINTS)], "is not understood"),
        ([line.replace(" ", ";").replace(".", ",", 1) for line in rows(HEIGHTS)], "commas and points"),
        (["0,0000,42,0735,7,0560", "1,0000,42,0735,7,0560"], "may be the decimals of another number"),
        (["some words"], "no rows of numbers"),
        # No profile
        (rows(STYLUS[:, ::-1]), "not a regular profile"),
        (rows(STYLUS**2), "not a regular profile; resample them first"),
        (rows(np.delete(STYLUS, 7, axis=0)), "not a regular profile"),
        (rows(np.vstack([STYLUS, STYLUS[::-1]])), "line 1: this point is given 2 times"),  # forth and back
        (rows(STYLUS[:, 1:], comma=True), "line 1: '.*' may be one number or two; write points"),
        ([f"{place},{height}" for place, height in enumerate(range(900, 930))], "'0,900' may be one number or two"),
        (["z x", *rows(STYLUS)], "'z x' is not understood; must have .* of a profile x and z, or z"),
        (["index z", *rows(STYLUS)], "is not understood"),
        (["x: mm, z: um", *rows(STYLUS)], "is not understood"),
        (["distance (mm) height (um)", *rows(STYLUS)], "is not understood"),
        (["x (mm) z", *rows(STYLUS)], "with all units or none"),
        (["# Width: 600 um", "# Height: 1 um", *rows(STYLUS[:, 1:])], "is not understood"),  # a map of one column
        ([*rows(STYLUS), "15.0 -9999"], "height -9999 marks a gap"),
        ([*rows(STYLUS), "15.0 ***"], "line 31: '.*' is not a number; a gap is written nan"),
        ([*rows(STYLUS), "15.0"], "line 31 has 1 numbers, and line 1 has 2"),
    ],
)
def test_what_may_be_read_in_two_ways_is_refused(lines, complaint):
    with pytest.raises(ValueError, match=complaint):
        read(lines)


COUNTS = np.random.default_rng(3).integers(-32768, 32768, (30, 40)).astype(float)


@pytest.mark.parametrize(
    "heights",
    [
        np.where(COUNTS == COUNTS.max(), 32767.0, np.where(COUNTS == COUNTS.min(), -32768.0, COUNTS)),  # of 16 bits
        np.minimum(np.abs(COUNTS), 9999.0),  # clipped
        np.where(COUNTS > 30000, -1.0, 0.05 * COUNTS / 32768),  # a texture of flat dimples
        np.repeat([[0.0, 0.1, 1.0]], 4, axis=0),  # steps
    ],
)
def test_deep_and_flat_places_of_a_surface_are_no_marks(heights):
    check_marks(heights)
