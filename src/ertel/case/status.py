"""Status of a solve, a step or a run, with advice.  A failure is a value, not an exception."""

from enum import Enum


class Status(Enum):
    """Outcome of a solve, a step or a run."""

    CONVERGED = "converged"
    RUNNING = "running"
    INTERRUPTED = "interrupted"
    NEWTON_STALLED = "Newton iteration stalled"
    FILM_VANISHED = "the film vanishes on this grid"
    NO_AGREEMENT = "film and temperatures do not agree"
    STEP_TOO_SMALL = "the time step became too small"

    @property
    def advice(self) -> str:
        """The advice for the next attempt."""
        return _ADVICE.get(self, "")

    @property
    def ok(self) -> bool:
        return self is Status.CONVERGED

    @property
    def is_solved(self) -> bool:
        """Whether the equations are solved, be the film above zero or not."""
        return self in (Status.CONVERGED, Status.FILM_VANISHED)

    @property
    def failed(self) -> bool:
        return self not in (Status.CONVERGED, Status.RUNNING, Status.INTERRUPTED)

    def of_film(self, thinnest: float) -> "Status":
        """This status; `FILM_VANISHED` where a solution has converged to a minimum film of zero or below."""
        return Status.FILM_VANISHED if self.ok and thinnest <= 0.0 else self


_ADVICE = {
    Status.NEWTON_STALLED: "use more nodes where the film is thin, or shorter steps in time",
    Status.FILM_VANISHED: "use as many nodes as the warning says (solver.nodes)",
    Status.NO_AGREEMENT: (
        'give the law by which the oil thins (lubricant.rheology) if it has none, or use thermal.inlet = "gupta"'
    ),
    Status.STEP_TOO_SMALL: "refine the grid (solver.nodes), check the lubricant, or loosen time.tolerance",
}
