"""How Sphinx builds the pages: `docs/build`.

The source folder is the root of the repository, so that validation, benchmarks and the table of keys are pages where
they lie, and their links hold.  The command reference is written from the programs' own help before each build.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

from PIL import Image
from sphinx.application import Sphinx

HERE = Path(__file__).parent
ROOT = HERE.parent

sys.path.insert(0, str(ROOT / "src"))  # the pages speak of this checkout
sys.path.insert(0, str(HERE))  # scraper
os.environ["PYTHONPATH"] = str(ROOT / "src")

import ertel  # noqa: E402

project = "ertel"
author = "The ertel developers"
copyright = "the ertel developers"
release = version = ertel.__version__

extensions = [
    "myst_parser",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.intersphinx",
    "sphinx.ext.mathjax",
    "sphinx_gallery.gen_gallery",
]
root_doc = "docs/index"
smartquotes = False  # flags have two hyphens
include_patterns = [
    "docs/**",
    "validation/**",
    "benchmarks/**",
    "examples/README.md",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
]
exclude_patterns = [
    ".*",
    "build",
    "dist",
    "runs",
    "src",
    "sweeps",
    "tests",
    "traction",
    "venv",
    "docs/_build",
    "docs/_static",
    "docs/_templates",
    "docs/inventories",
    "docs/gallery/*.ipynb",
    "docs/tutorials/*.ipynb",
    "**/.*",
]

# -- Markdown and formulas --------------------------------------------------------------------------------------------

myst_enable_extensions = ["amsmath", "attrs_inline", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
suppress_warnings = ["myst.header"]  # tables that programs write begin where they are read
mathjax_path = "mathjax/startup.js"
mathjax3_config = {
    "loader": {"load": ["core", "input/tex-base", "[tex]/ams", "output/chtml"]},
    "tex": {"packages": {"[+]": ["ams"]}},
}
math_numfig = False

# -- the API ----------------------------------------------------------------------------------------------------------

autosummary_generate = True
autodoc_typehints = "none"
autodoc_member_order = "bysource"
numpydoc_class_members_toctree = False
numpydoc_show_inherited_class_members = False
intersphinx_mapping = {
    "python": ("https://docs.python.org/3", str(HERE / "inventories/python.inv")),
    "numpy": ("https://numpy.org/doc/stable", str(HERE / "inventories/numpy.inv")),
    "xarray": ("https://docs.xarray.dev/en/stable", str(HERE / "inventories/xarray.inv")),
    "matplotlib": ("https://matplotlib.org/stable", str(HERE / "inventories/matplotlib.inv")),
}

# -- the gallery ------------------------------------------------------------------------------------------------------

GALLERIES = ("gallery", "tutorials")
RUN = os.environ.get("ERTEL_GALLERY", "run") == "run"  # otherwise the pages have the kept thumbnails, and no pictures
THUMBNAILS = HERE / "thumbnails"
COLOURS = 48  # of a kept thumbnail
sphinx_gallery_conf = {
    "image_scrapers": ("matplotlib", "scraper.ertel_figure"),
    "examples_dirs": [str(ROOT / "examples" / name) for name in GALLERIES],
    "gallery_dirs": [f"docs/{name}" for name in GALLERIES],
    "thumbnail_size": (320, 224),
    "plot_gallery": RUN,
    "abort_on_example_error": True,
    "capture_repr": (),
    "download_all_examples": False,
    "remove_config_comments": True,
    "show_memory": False,
    "write_computation_times": False,  # its page would load scripts from elsewhere
    "within_subsection_order": "FileNameSortKey",
}

# -- the look ---------------------------------------------------------------------------------------------------------

html_theme = "pydata_sphinx_theme"
html_title = "ertel"
html_static_path = ["_static"]
templates_path = [str(HERE / "_templates")]
html_additional_pages = {"index": "start.html"}  # the first page lies in docs/
html_show_sourcelink = False
html_theme_options = {
    "navbar_end": ["theme-switcher"],
    "secondary_sidebar_items": ["page-toc"],
    "show_toc_level": 2,
    "navigation_with_keys": False,
    "footer_start": ["copyright"],
    "footer_end": [],
}
WIDE = ("index", "first_steps", "install", "developers", "theory", "theory/*")  # no pages below, formulas, code
html_sidebars = {f"docs/{page}": [] for page in WIDE}


def write_commands(app: Sphinx) -> None:
    """The page of the commands, from their own help."""
    command = [
        sys.executable,
        "-m",
        "typer",
        "ertel.apps.cli",
        "utils",
        "docs",
        "--name",
        "ertel",
        "--title",
        "Commands",
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT)
    page, text = HERE / "commands.md", with_whole_sentences(done.stdout)
    if not page.exists() or page.read_text(encoding="utf-8") != text:
        page.write_text(text, encoding="utf-8")


def with_whole_sentences(text: str) -> str:
    """The list of commands with the first paragraphs of their sections, which Typer cuts off in the list."""
    first = dict(re.findall(r"^## `ertel (\S+)`\n\n(.+?)\n\n", text, re.MULTILINE | re.DOTALL))
    return re.sub(r"^\* `(\S+)`: .*\.\.\.$", lambda cut: f"* `{cut[1]}`: {first[cut[1]]}", text, flags=re.MULTILINE)


def put_thumbnails(app: Sphinx) -> None:
    """Where no script runs: the kept thumbnails, which the gallery does not replace."""
    for name in () if RUN else GALLERIES:
        shutil.copytree(THUMBNAILS / name, HERE / name / "images/thumb", dirs_exist_ok=True)


def keep_thumbnails(app: Sphinx, failure: Exception | None) -> None:
    """Where the scripts ran: their thumbnails with fewer colours, to be committed."""
    for name in GALLERIES if RUN and failure is None else ():
        (THUMBNAILS / name).mkdir(parents=True, exist_ok=True)
        for drawn in (HERE / name / "images/thumb").glob("*.png"):
            with Image.open(drawn) as picture:
                small = picture.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
            small.save(THUMBNAILS / name / drawn.name, optimize=True)


def keep_bars(app: Sphinx, what: str, name: str, found: object, options: object, lines: list[str]) -> None:
    """The size |T| in a docstring is not a substitution."""
    lines[:] = [line.replace("|", "\\|") for line in lines]


def setup(app: Sphinx) -> None:
    app.connect("builder-inited", write_commands, priority=1)
    app.connect("builder-inited", put_thumbnails, priority=1)
    app.connect("build-finished", keep_thumbnails)
    app.connect("autodoc-process-docstring", keep_bars)
