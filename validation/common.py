"""What the programs of these folders share: double precision, oils, tables, and which of them to write."""

import argparse
import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

import jax

from ertel.numerics.grid import Extrapolation, extrapolate
from ertel.solvers.steady import Rolling

jax.config.update("jax_enable_x64", True)  # ertel itself asks for it in its public functions alone

BARUS = {"viscosity": "barus", "density": "incompressible"}
ISOVISCOUS = {"viscosity": "isoviscous", "density": "incompressible"}


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """The table in Markdown; each line is printed as soon as it is known."""
    lines = []
    for cells in itertools.chain([head, ["---"] * len(head)], rows):
        lines.append(f"| {' | '.join(cells)} |\n")
        print(lines[-1], end="", flush=True)
    return "".join(lines)


def nodes(usual: int) -> int:
    """The option --nodes of a program that has no other."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--nodes", type=int, default=usual)
    chosen: int = parser.parse_args().nodes
    return chosen


def extrapolated(rolling: Rolling, name: str) -> Extrapolation:
    """A quantity of `measure` by Richardson's extrapolation: the error falls with the square of the spacing."""
    return extrapolate(*(s.measure()[name] for s in rolling.solutions[-2:]))


Tables = Mapping[str, tuple[str, Callable[..., str], int | None]]  # NAME: title, its text by nodes, the usual nodes


def write(folder: Path, tables: Tables) -> None:
    """Write NAME.md of each table that the command line names, or of all; --nodes in place of the usual nodes."""
    parser = argparse.ArgumentParser()
    parser.add_argument("names", nargs="*", choices=[*tables, []])
    parser.add_argument("--nodes", type=int)
    asked = parser.parse_args()
    for name in asked.names or tables:
        title, text, usual = tables[name]
        content = text() if usual is None else text(asked.nodes or usual)
        (folder / f"{name}.md").write_text(f"# {title}\n\n{content}", encoding="utf-8")
