"""How an attempt ended, with a sentence of advice: failure is a value, not an exception."""

from enum import Enum


class Status(Enum):
    """Outcome of a solve, a step or a run."""

    CONVERGED = "converged"
    RUNNING = "running"
    INTERRUPTED = "interrupted"
    NEWTON_STALLED = "Newton stalled"
    STEP_TOO_SMALL = "the time step became too small"

    @property
    def advice(self) -> str:
        """What to try next."""
        return _ADVICE[self]

    @property
    def ok(self) -> bool:
        return self is Status.CONVERGED


_ADVICE = {
    Status.CONVERGED: "",
    Status.RUNNING: "the run has not come to its end yet; `ertel resume` takes it up from the last checkpoint",
    Status.INTERRUPTED: "`ertel resume` takes the run up from the last checkpoint",
    Status.NEWTON_STALLED: "take a smaller time step, or more nodes where the film is thin",
    Status.STEP_TOO_SMALL: "refine the grid (solver.nodes), check the lubricant, or loosen time.tolerance",
}
