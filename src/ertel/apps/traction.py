"""`ertel traction`: a traction curve from its new directory to the printed table."""

from collections.abc import Mapping
from pathlib import Path

from ertel.apps import running, tables
from ertel.apps.process import interruptible
from ertel.apps.terminal import FAILED, bad_input, leave, print_json, reason_of, shown
from ertel.case.case import Case
from ertel.case.derived import newtonian_stress
from ertel.results.traction_curve import TractionCurve
from ertel.runs.compile import prepare_jax
from ertel.runs.curves import Curve, curve_of
from ertel.runs.drive import bars
from ertel.runs.files import StoreError
from ertel.runs.traction import run, watched
from ertel.runs.traction_store import PICTURE, TABLE, CurveStore

GOES_ON = "the same command continues"


def traction(
    case: Case, given: Mapping[str, str | None], film: str | None, directory: Path | None, as_json: bool, quiet: bool
) -> None:
    """Compute and store a traction curve, or go on with it, and print it.  directory: None: traction/NAME."""
    with bad_input():
        curve = curve_of(case, given, film)
    if not quiet:
        running.say_before([max(curve.cases, key=newtonian_stress)])
    prepare_jax()
    with running.within_memory(case), interruptible() as stop:
        store = _store(curve, directory)
        try:
            with bars(not quiet) as shown_bars:
                found = run(curve, store, watched(shown_bars, curve), stop)
        except OSError as error:
            leave(FAILED, f"cannot write to {shown(store.directory)}: {reason_of(error)}; {GOES_ON}")
    _report(found, as_json, quiet)
    if not found.complete:
        leave(stop.code, f"interrupted; {GOES_ON}")
    if found.failed:
        places = ", ".join(f"{value:.4g}" for value in found.failed)
        leave(FAILED, f"failed: the film did not converge at {found.axis} = {places}; the other points are there")


def _store(curve: Curve, directory: Path | None) -> CurveStore:
    """The directory of the curve.  Raises StoreError with advice where it cannot be used."""
    if directory is None:
        return CurveStore.in_turn(Path("traction").absolute(), curve)
    try:
        return CurveStore.of(directory, curve)
    except StoreError as error:
        raise StoreError(f"{error}; choose another --out") from error


def _report(found: TractionCurve, as_json: bool, quiet: bool) -> None:
    """Print the curve in the form that the user asked for."""
    if as_json:
        print_json(found.as_data())
    elif not quiet:
        out = tables.console()
        out.print(found.heading, style="bold")
        for line in found.table_lines():
            out.print(line)
        for remark in found.remarks:
            out.print(f"{remark[0].upper()}{remark[1:]}", style="yellow" if remark.startswith("warning") else None)
        if found.directory:
            out.print(f"Stored in {shown(found.directory)}, with {TABLE} and {PICTURE}")
