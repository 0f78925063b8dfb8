"""Many impacts in one compiled step: equal to single runs, alike or refused, failures apart, few compilations."""

from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import jax.numpy as jnp
import numpy as np
import pytest
from cases import impact, rolled

from ertel.case.case import Case
from ertel.case.sections import SOLVERS, Drive
from ertel.case.status import Status
from ertel.physics.lubricant import Oil
from ertel.physics.registry import DENSITY_LAWS
from ertel.physics.scales import Parameters
from ertel.runs.batch import lanes_for, run_together, simulate_batch
from ertel.runs.compile import compilations
from ertel.runs.drive import simulate
from ertel.runs.result import Result
from ertel.runs.stepping import Step
from ertel.runs.workers import Failure

ROLLED = rolled(Parameters.from_moes(20, 5), Oil(), replace(SOLVERS["transient"], nodes=33))
TIGHT = {"tolerance": 1e-8, "half_width": 2.0}  # the default width depends on M


def three(until: tuple[float, ...] = (1.5, 1.1, 1.3)) -> list[Case]:
    """They end at different times, after different numbers of steps."""
    pairs = ((20, 5), (100, 10), (50, 3))
    return [impact(M, L, 33, solver=TIGHT, time={"until": T}) for (M, L), T in zip(pairs, until, strict=True)]


def test_a_batch_equals_single_runs_and_its_step_is_compiled_once() -> None:
    seen = [0, 0, 0]

    def count(number: int, step: Step) -> None:
        seen[number] += 1

    results = simulate_batch(three(), count)
    for case, found, steps in zip(three(), results, seen, strict=True):
        assert isinstance(found, Result)
        alone = simulate(case)
        assert found.status is alone.status is Status.CONVERGED
        assert found.dataset.sizes == alone.dataset.sizes
        assert steps == found.dataset.sizes["time"]
        for name in ("time", "Delta", "F", "H_c", "H_min", "H", "P", "krylov_iterations"):
            np.testing.assert_allclose(found.dataset[name], alone.dataset[name], rtol=1e-9, atol=1e-10, err_msg=name)
    before = compilations()
    simulate_batch([impact(M, 5, 33, solver=TIGHT, time={"until": 0.9}) for M in (30, 40, 60)])
    assert compilations() == before


def test_a_case_that_raises_or_gives_up_does_not_stop_the_others() -> None:
    first, second, third = three((0.2, 0.3, 0.4))
    hopeless = replace(second, solver=replace(second.solver, tolerance=1e-30))

    def raise_once(number: int, step: Step) -> None:
        if number == 0 and step.record["T"] > 0.1:
            raise RuntimeError("disk full")

    failed, gave_up, good = simulate_batch([first, hopeless, third], raise_once)
    assert failed == Failure("RuntimeError: disk full")
    assert isinstance(gave_up, Result) and gave_up.status is Status.STEP_TOO_SMALL
    assert isinstance(good, Result) and good.status.ok


@DENSITY_LAWS.register("table")
@dataclass(frozen=True)
class Table:
    """A density law with a table: its length is part of the step."""

    values: tuple[float, ...]
    reference: ClassVar[str] = "none"

    def density(self, P: Any) -> Any:
        return jnp.ones_like(P)


def with_density(case: Case, values: int) -> Case:
    return replace(case, oil=replace(case.oil, density=Table((1.0,) * values)))


@pytest.mark.parametrize(
    ("name", "first", "other"),
    [
        ("solver.nodes = 65 in case 1: must be that of case 0, 33", impact(20, 5, 33), impact(20, 5, 65)),
        ("solver.half_width", impact(20, 5, 33), impact(20, 5, 33, solver={"half_width": 3.0})),
        ("symmetry", impact(20, 5, 33), impact(20, 5, 33, solver={"fold": False})),
        ("lubricant.viscosity", impact(20, 5, 33), impact(20, 5, 33, lubricant={"viscosity": "barus"})),
        ("lubricant.density", with_density(impact(20, 5, 33), 3), with_density(impact(20, 5, 33), 4)),
        ("solver.method", impact(20, 5, 33), impact(20, 5, 33, solver={"method": "radial"})),
        (r"motion\.inertia", ROLLED, replace(ROLLED, drive=Drive(inertia=0.5))),
    ],
)
def test_cases_that_cannot_share_a_step_are_refused(name: str, first: Case, other: Case) -> None:
    with pytest.raises(ValueError, match=name):
        simulate_batch([first, other])


def test_no_cases_are_no_batch() -> None:
    with pytest.raises(ValueError, match="one or more"):
        simulate_batch([])


def test_the_batch_shrinks_rarely() -> None:
    assert [lanes_for(asking, 32) for asking in (32, 9, 8, 3, 2, 1)] == [32, 32, 8, 8, 2, 2]
    assert lanes_for(1, 3) == 3


def asks(number: int) -> Generator[int, int, list[int]]:
    found = []
    for turn in range(number + 1):
        found.append((yield 10 * number + turn))
    return found


def test_every_run_is_sent_its_own_solutions() -> None:
    sizes: list[tuple[int, int]] = []

    def solve(problems: Sequence[int], lanes: int) -> list[int]:
        sizes.append((len(problems), lanes))
        return [-problem for problem in problems]

    assert run_together([asks(number) for number in range(3)], solve) == [[0], [-10, -11], [-20, -21, -22]]
    assert sizes == [(3, 3), (2, 3), (1, 3)]


def test_what_solving_raises_reaches_every_run_that_asked() -> None:
    def no_memory(problems: Sequence[int], lanes: int) -> list[int]:
        if len(problems) == 2:
            raise MemoryError("too many lanes")
        return list(problems)

    outcomes = run_together([asks(number) for number in range(3)], no_memory)
    assert outcomes == [[0], *[Failure("MemoryError: too many lanes")] * 2]


def test_an_interrupt_ends_all_runs() -> None:
    def interrupt(problems: Sequence[int], lanes: int) -> list[int]:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_together([asks(2), asks(1)], interrupt)
