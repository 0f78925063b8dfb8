"""What stands in a figure."""


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
    """The collections of a type, such as QuadMesh."""
    return [collection for collection in axes.collections if type(collection).__name__ == name]
