"""Damage to the files of finished and of interrupted runs: all commands answer as before, or refuse in one sentence."""

import json
import random
import shutil
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from children import OWN, Ended, Fault, called, fingerprint, in_child, plain, run_watched, terminate
from kills import Known, Outcome, Trial, judged
from kinds import Kind

from ertel.apps.browser.folder import Folder, fault_of, summary_of
from ertel.apps.browser.processes import Processes
from ertel.apps.looking import listed
from ertel.runs.arrays import ROOT

SUMMARY = "summary.json"
WAYS = {"bit flipped": 0.8, "cut short": 0.05, "deleted": 0.05, "replaced": 0.1}
OTHERS = (b"", b"null", b"[]", b"{}", b'"text"', b"[{}]", b"1e999", b"\xff\xfe\x00", b"[" * 50_000, b"{" * 50_000)
FEW = (".json", ".toml", ".npz", ".npy", ".csv")  # files outside the many of the arrays, as often as all of those


@dataclass(frozen=True)
class Stored:
    """A stored run, or a study.

    shown: its summary as `ertel show` prints it; looked: what the app and `ertel ls` say; found: its fingerprint.
    """

    name: str
    run: Path
    known: Known
    shown: Any
    looked: dict[str, str]
    found: dict[str, str]


def prepared(known: Known, place: Path) -> list[Stored]:
    """The finished run, and one that was interrupted halfway."""
    half, name = Trial(known, place), known.kind.name
    half.go(Fault(terminate, known.operations // 2))
    return [_stored(f"{name}, finished", known.run, known), _stored(f"{name}, half", half.run, known)]


def _stored(name: str, run: Path, known: Known) -> Stored:
    shown, looked, opened = in_child(lambda tell: _read(tell, run, known.kind))
    if shown.code or looked.failure or opened.failure or opened.code:
        raise RuntimeError(f"{name}: {shown.said} {looked.failure} {opened.failure} {opened.said}")
    return Stored(name, run, known, _summary(shown), looked.found, opened.found)


def _read(tell: Callable[..., None], run: Path, kind: Kind) -> None:
    """`ertel show`, of a study `ertel ls`; what the app and `ertel ls` read of a folder; then what Python reads."""
    code, text, said = called(["ls" if kind.is_study else "show", str(run), "--json"])
    tell(code=code, said=said, text=text)
    try:
        tell(found=looked(run.parent), text="")
    except Exception:
        tell(said=traceback.format_exc(), text="")
    try:
        tell(found=fingerprint(run), text="")
    except (ValueError, OSError) as error:  # what a user expects of a function that is given a directory
        tell(said=f"ertel: {error}", code=2, text="")


def looked(place: Path) -> dict[str, str]:
    """What programs that list runs say of each run in a folder: its numbers, "" where they know none."""
    folder = Folder.at(place)
    processes, found = Processes(folder), {}
    for path in folder.runs():
        _ = processes.status(path), fault_of(path)
        about, summary = f"app, {folder.name_of(path)}", summary_of(path)
        found[about] = json.dumps(plain(summary)) if summary else ""
    for run in listed(place):
        numbers = {name: number["value"] for name, number in run["numbers"].items() if name not in OWN}
        found[f"ls, {run['directory']}"] = json.dumps(numbers) if numbers else ""
    return found


def _summary(shown: Ended) -> Any:
    return plain(json.loads(shown.text))


def way(dice: random.Random) -> str:
    """Mostly a flipped bit."""
    return dice.choices(list(WAYS), list(WAYS.values()))[0]


def tried(stored: Stored, how: str, place: Path, dice: random.Random) -> Outcome:
    """One kind of damage to a copy of a stored run."""
    place.mkdir(parents=True)
    copy = place / "run"
    shutil.copytree(stored.run, copy)
    what = damage(copy, how, dice)
    outcome = _worst(_judged(stored, copy))
    if outcome.word in ("unchanged", "refused damage"):
        shutil.rmtree(place)
    return Outcome(outcome.word, f"{what}: {outcome.why}")


def damage(run: Path, how: str, dice: random.Random) -> str:
    """Damage one file; what was done, in words."""
    files = sorted(path for path in run.rglob("*") if path.is_file() and path.stat().st_size)
    if how == "deleted":
        # without its summary a run is one that was killed before its end
        files = [file for file in files if file.name != SUMMARY]
    few = [file for file in files if file.suffix in FEW and file.name != ROOT]
    file = dice.choice(few if how == "replaced" or dice.random() < 0.5 else files)
    name, content = file.relative_to(run), bytearray(file.read_bytes())
    bit = dice.randrange(8 * len(content))
    if how == "deleted":
        file.unlink()
        return f"{name} deleted"
    if how == "replaced":
        other = dice.choice(OTHERS)
        file.write_bytes(other)
        return f"{name} replaced by {other[:20]!r}"
    if how == "cut short":
        file.write_bytes(content[: bit // 8])
        return f"{name} cut to {bit // 8} of {len(content)} bytes"
    before = bytes(content)
    content[bit // 8] ^= 1 << bit % 8
    file.write_bytes(content)
    around = slice(max(bit // 8 - 20, 0), bit // 8 + 20)
    return f"{name}, bit {bit} of {8 * len(content)}: {before[around]!r} became {bytes(content)[around]!r}"


def _judged(stored: Stored, copy: Path) -> list[Outcome]:
    """What became of `ertel show`, of lists of runs, of reading in Python, and of `ertel resume`."""
    kind = stored.known.kind

    def work(tell: Callable[..., None]) -> None:
        _read(tell, copy, kind)
        run_watched(tell, kind.command(copy), copy.parent, Fault(), copy)

    told = in_child(work)
    shown, seen, opened, resumed = [*told, *[told[-1]] * 3][:4]  # a child that hangs or crashes tells less
    outcomes = [_answer("show", shown, lambda: kind.is_study or _summary(shown) == stored.shown)]
    outcomes.append(_answer("lists", seen, lambda: all(seen.found[k] in ("", stored.looked[k]) for k in seen.found)))
    outcomes.append(_answer("open", opened, lambda: opened.found == stored.found))
    word, why = judged(resumed, stored.known)
    if word == "refused" and resumed.one_sentence:
        return [*outcomes, Outcome("refused damage", f"resume: {resumed.said}")]
    return [*outcomes, Outcome({"equal": "unchanged", "differs": "silent"}.get(word, word), f"resume: {why}")]


def _answer(what: str, ended: Ended, same: Callable[[], bool]) -> Outcome:
    if ended.failure or ended.traceback:
        return Outcome(
            "hung" if ended.failure.startswith("hung") else "traceback", f"{what}: {ended.failure}{ended.said}"[-2000:]
        )
    if ended.code:
        word = "refused damage" if ended.code in (1, 2) and ended.one_sentence else "no sentence"
        return Outcome(word, f"{what}: exit code {ended.code}: {ended.said}")
    return Outcome("unchanged") if same() else Outcome("silent", f"{what}: another answer")


def _worst(outcomes: list[Outcome]) -> Outcome:
    order = ("unchanged", "refused damage")
    return max(outcomes, key=lambda outcome: order.index(outcome.word) if outcome.word in order else len(order))
