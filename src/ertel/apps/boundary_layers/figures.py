"""The paper, reproduced: what to run for each of its figures, and the page that shows them.

Lubrecht AA, Biboulet N, Venner CH. Boundary layers: unifying the impact and rolling EHL point contacts.

    ertel paper all --quick
"""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import ertel
from ertel.apps.boundary_layers import beyond, front, page, reduction, waves
from ertel.apps.boundary_layers.page import Drawn
from ertel.runs.sweep import Failure, Task, kept, sweep

TITLE = "Boundary layers: impact and rolling EHL point contacts, the paper reproduced"
RUNS = "runs"  # where results are kept, below the page


@dataclass(frozen=True)
class PaperFigure:
    """One figure.  tasks: what it needs, coarse (quick) or not; draw: the figure from their results, in that order."""

    title: str
    tasks: Callable[[bool], list[Task]]
    draw: Callable[[Sequence[Any], bool], Drawn]


FIGURES: Mapping[str, PaperFigure] = {
    "fig1": PaperFigure("Fig. 1  The dry impact", front.radial_tasks, front.dry_impact),
    "fig2": PaperFigure("Fig. 2  Speed of the front", front.all_tasks, front.front_speed),
    "fig3": PaperFigure("Fig. 3  Film at maximum impact", front.all_tasks, front.film_and_speed),
    "fig4": PaperFigure("Fig. 4  Film behind the front", front.radial_tasks, front.film_predicted),
    "fig5": PaperFigure("Fig. 5  Waves in an impact", waves.impact_tasks, waves.deformed_waves),
    "fig6": PaperFigure("Fig. 6  Amplitude reduction: impact and rolling", reduction.all_tasks, reduction.reduction),
    "fig7": PaperFigure("Beyond the paper: Fig. 7  Waves of other shapes", beyond.shape_tasks, beyond.other_waves),
    "fig8": PaperFigure("Beyond the paper: Fig. 8  Other lubricants", beyond.oil_tasks, beyond.other_oils),
}


def names_of(figure: str) -> list[str]:
    """The figures that "all" or a name stands for.  Raises ValueError for any other."""
    if figure != "all" and figure not in FIGURES:
        raise ValueError(f"figure = {figure}: must be all, {', '.join(FIGURES)}")
    return list(FIGURES) if figure == "all" else [figure]


def tasks_of(names: Sequence[str], quick: bool) -> list[Task]:
    """All runs that the figures need, each once."""
    found = {task.name: task for name in names for task in FIGURES[name].tasks(quick)}
    return list(found.values())


def expected(names: Sequence[str], quick: bool, directory: Path, jobs: int) -> tuple[int, int, float]:
    """How many runs there are, how many of them are done already, and how many seconds the rest will take."""
    tasks = tasks_of(names, quick)
    done = kept(tasks, directory / RUNS)
    left = [task.seconds for task in tasks if task.name not in done]
    return len(tasks), len(done), max(sum(left) / jobs, max(left, default=0.0))


def make(
    names: Sequence[str],
    quick: bool,
    directory: Path,
    executor: Executor,
    on_done: Callable[[Task, Any], object] = lambda task, result: None,
) -> tuple[Path, dict[str, str]]:
    """Run what is not kept yet, draw the figures, write the page: where it is, and why figures are missing."""
    tasks = tasks_of(names, quick)
    results = dict(zip([t.name for t in tasks], sweep(tasks, executor, directory / RUNS, on_done), strict=True))
    bodies, missing = {}, {}
    for name in names:
        wanted = [results[task.name] for task in FIGURES[name].tasks(quick)]
        failures = [result.reason for result in wanted if isinstance(result, Failure)]
        if failures:
            missing[name] = "; ".join(failures)
        drawn = None if failures else FIGURES[name].draw(wanted, quick)
        bodies[FIGURES[name].title] = page.save(drawn, name, directory) if drawn else page.failed(missing[name])
    remarks = [
        f"ertel {ertel.__version__}, {'quick: coarse grids' if quick else 'full resolution'}.  The paper gives no "
        "grid, no time step, no initial gap and no oil beyond M and L: Delta_0 = -1, Roelands' law with alpha = 22 "
        "1/GPa, eta_0 = 0.04 Pa s, z = 0.668, Dowson and Higginson's density.  Lengths in a*, films in a*^2/R, times "
        "in t0 = a*^2/(R v0)."
    ]
    file = directory / ("index.html" if len(names) > 1 else f"{names[0]}.html")
    file.write_text(page.page(TITLE, remarks, bodies), encoding="utf-8")
    return file, missing
