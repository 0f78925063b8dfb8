"""Status of a solve, a step or a run, with advice.  A failure is a value, not an exception."""

from enum import Enum


class Status(Enum):
    """Outcome of a solve, a step or a run."""

    CONVERGED = "converged"
    RUNNING = "running"
    INTERRUPTED = "interrupted"
    NEWTON_STALLED = "Newton iteration stalled"
    STEP_TOO_SMALL = "the time step became too small"

    @property
    def advice(self) -> str:
        """What to try next."""
        return _ADVICE.get(self, "")

    @property
    def ok(self) -> bool:
        return self is Status.CONVERGED


_ADVICE = {
    Status.NEWTON_STALLED: "use more nodes where the film is thin, or shorter steps in time",
    Status.STEP_TOO_SMALL: "refine the grid (solver.nodes), check the lubricant, or loosen time.tolerance",
}
