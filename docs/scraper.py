"""Shows ertel's own figures in the gallery: pyplot does not know them."""

from pathlib import Path
from typing import Any

from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst

SHOWN = "shown"


def ertel_figure(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Save the Figure that a script calls `figure` and that pyplot does not manage, once."""
    figure = block_vars["example_globals"].get("figure")
    if not isinstance(figure, Figure) or hasattr(figure, "number") or figure.get_gid() == SHOWN:
        return ""
    figure.set_gid(SHOWN)
    path = Path(next(block_vars["image_path_iterator"]))
    figure.savefig(path, dpi=100)
    return str(figure_rst([str(path)], gallery_conf["src_dir"]))
