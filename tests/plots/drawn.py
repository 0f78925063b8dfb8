"""What stands in a figure."""

import numpy as np


def panels(figure):
    """The axes of a figure without colour bars and without the right-hand ones of twins."""
    return [
        axes for axes in figure.axes if axes.get_label() != "<colorbar>" and axes.yaxis.get_label_position() == "left"
    ]


def right_of(axes):
    (twin,) = [other for other in axes.figure.axes if other is not axes and other.bbox.bounds == axes.bbox.bounds]
    return twin


def line(axes, label):
    (found,) = [candidate for candidate in axes.get_lines() if candidate.get_label() == label]
    return found


def words(axes):
    """What the legend says."""
    legend = axes.get_legend()
    return [text.get_text() for text in legend.get_texts()] if legend else []


def of_type(axes, name):
    """The collections of a type, such as QuadContourSet."""
    return [collection for collection in axes.collections if type(collection).__name__ == name]


def roughness_lines(axes):
    """Level of the contour lines round hills and valleys, and whether they are solid."""
    sets = [each for each in of_type(axes, "QuadContourSet") if len(each.levels) == 1 and each.levels[0] != 0.0]
    return [(float(contours.levels[0]), contours.get_linestyle()[0][1] is None) for contours in sets]


def edge_of_oil(axes):
    """The corners of the line where the gap stops being full, (corners, 2); empty where there is none."""
    lines = [path for contours in of_type(axes, "QuadContourSet") if list(contours.levels) == [0.0]
             for path in contours.get_paths()]  # fmt: skip
    return np.concatenate([path.vertices for path in lines]) if lines else np.empty((0, 2))


def flow_arrows(axes):
    """Where the arrows of the flow point: 1 along the axis, -1 against it."""
    ends = [text.get_text()[-1] for text in axes.texts if text.get_text().startswith("flow")]
    return [{"→": 1.0, "←": -1.0, "↓": 1.0, "↑": -1.0}[end] for end in ends]
