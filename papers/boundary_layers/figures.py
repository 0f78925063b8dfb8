"""The figures of the paper: what is run for each of them, how it is drawn, and the page that shows them.

Lubrecht AA, Biboulet N, Venner CH. Boundary layers: unifying the impact and rolling EHL point contacts.

    python papers/boundary_layers all --quick
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from string import Template
from typing import Any

import ertel
from boundary_layers import beyond, front, line_reduction, line_runs, lines, reduction, runs
from boundary_layers.pages import Drawn, save
from boundary_layers.plans import FULL, QUICK, Plan
from boundary_layers.tasks import Failure, Task, kept, run_tasks

TITLE = "Boundary layers in impact and rolling EHL point contacts: the figures of the paper"
SETTINGS = (
    "The paper states no grid, time step or initial gap, and no oil data beyond M and L.  Here: Delta_0 = -1, "
    "Roelands' law with alpha = 22 1/GPa, eta_0 = 0.04 Pa s, z = 0.668, and Dowson and Higginson's density.  Lengths "
    "are in units a*, films in a*^2/R, times in t0 = a*^2/(R v0).  Cylinders: M and L are those of a line contact, "
    "the length is 100 half widths, and the half width b* takes the place of a*."
)
RUNS = "runs"  # directory of the kept results, below the page
PAGE = Path(__file__).with_name("page.html")


@dataclass(frozen=True)
class PaperFigure:
    """One figure.  runs: what it needs, see `runs`; draw: the figure from the same with results in place of tasks."""

    title: str
    runs: Callable[[Plan], Any]
    draw: Callable[[Any, Plan], Drawn]


FIGURES: Mapping[str, PaperFigure] = {
    "fig1": PaperFigure("Fig. 1  The dry impact", runs.radial_runs, front.dry_impact),
    "fig2": PaperFigure("Fig. 2  Speed of the front", runs.smooth_runs, front.front_speed),
    "fig3": PaperFigure("Fig. 3  Film at maximum impact", runs.smooth_runs, front.film_and_speed),
    "fig4": PaperFigure("Fig. 4  Film behind the front", runs.radial_runs, front.film_predicted),
    "fig5": PaperFigure("Fig. 5  Waves in an impact", runs.wave_runs, reduction.deformed_waves),
    "fig6": PaperFigure("Fig. 6  Amplitude reduction in impact and rolling", runs.reduction_runs, reduction.reduction),
    "fig7": PaperFigure("Beyond the paper: Fig. 7  Waves of other shapes", runs.shape_runs, beyond.other_waves),
    "fig8": PaperFigure("Beyond the paper: Fig. 8  Other lubricants", runs.oil_runs, beyond.other_oils),
    "fig9": PaperFigure("Beyond the paper: Fig. 9  Starved films", runs.starved_runs, beyond.starved),
    "line1": PaperFigure("Cylinders: Fig. 1  The dry impact", line_runs.smooth_runs, lines.dry_cylinders),
    "line2": PaperFigure("Cylinders: Fig. 2  Speed of the front", line_runs.smooth_runs, lines.front_speed),
    "line3": PaperFigure("Cylinders: Fig. 3  Film at maximum impact", line_runs.smooth_runs, lines.film_and_speed),
    "line4": PaperFigure("Cylinders: Fig. 4  Film behind the front", line_runs.smooth_runs, lines.film_predicted),
    "line5": PaperFigure("Cylinders: Fig. 5  Waves in an impact", line_runs.wave_runs, line_reduction.deformed_waves),
    "line6": PaperFigure(
        "Cylinders: Fig. 6  Amplitude reduction", line_runs.reduction_runs, line_reduction.waves_reduced
    ),
    "line7": PaperFigure(
        "Beyond the paper: the film of rolling, left by an impact", line_runs.law_runs, line_reduction.film_left
    ),
}
GROUPS = {"all": list(FIGURES), "lines": [name for name in FIGURES if name.startswith("line")]}


def names_of(figure: str) -> list[str]:
    """The names of all figures for "all", of those for cylinders for "lines", or the one name.

    Raises ValueError for any other.
    """
    if figure not in GROUPS and figure not in FIGURES:
        raise ValueError(f"figure = {figure}: must be {', '.join([*GROUPS, *FIGURES])}")
    return GROUPS.get(figure, [figure])


def tasks_of(names: Sequence[str], plan: Plan) -> list[Task]:
    """All runs that the figures need, each once."""
    return list({task.name: task for name in names for task in runs.tasks_in(FIGURES[name].runs(plan))}.values())


def expected(names: Sequence[str], quick: bool, directory: Path, jobs: int) -> tuple[int, int, float]:
    """Number of runs, number of those that are done, and seconds that the others will take."""
    tasks = tasks_of(names, QUICK if quick else FULL)
    done = kept(tasks, directory / RUNS)
    seconds = [task.seconds for task in tasks if task.name not in done]
    return len(tasks), len(done), max(sum(seconds) / jobs, max(seconds, default=0.0))


def make(
    names: Sequence[str],
    quick: bool,
    directory: Path,
    jobs: int = 1,
    on_done: Callable[[Task, Any], object] = lambda task, result: None,
) -> tuple[Path, dict[str, str]]:
    """Run what is not kept yet, on so many processes, draw the figures and write the page.

    Returns the path of the page, and for each figure that is missing its name and the reason.
    """
    plan = QUICK if quick else FULL
    results = run_tasks(tasks_of(names, plan), directory / RUNS, jobs, on_done)
    missing, sections = {}, []
    for name in names:
        figure = FIGURES[name]
        needed = figure.runs(plan)
        done = [results[task.name] for task in runs.tasks_in(needed)]
        if failures := [result.reason for result in done if isinstance(result, Failure)]:
            missing[name] = "; ".join(failures)
            content = f'<p class="failed">Not made: {escape(missing[name])}</p>'
        else:
            content = save(figure.draw(runs.in_place(needed, results), plan), name, figure.title, directory)
        sections.append(f"<section>\n<h2>{escape(figure.title)}</h2>\n{content}\n</section>")
    remarks = f"<p>{escape(f'ertel {ertel.__version__}, {plan.resolution}.  {SETTINGS}')}</p>"
    template = Template(PAGE.read_text(encoding="utf-8"))
    page = "lines" if list(names) == GROUPS["lines"] else "index" if len(names) > 1 else names[0]
    file = directory / f"{page}.html"
    file.write_text(
        template.substitute(title=escape(TITLE), remarks=remarks, sections="\n".join(sections)), encoding="utf-8"
    )
    return file, missing
