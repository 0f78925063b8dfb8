"""What ertel says of a case before it is run: at once whether it is one, and after two seconds all of `ertel check`.

The first is asked here; the second needs JAX and is a process of its own, which ends when the case changes again.  A
case with measured surfaces is left to the second: what reads their files is large.
"""

import asyncio
import json
import os
import tempfile
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import tomli_w

from ertel.apps.browser.folder import Folder
from ertel.apps.browser.processes import ERTEL
from ertel.inputs.case_files import parse_case
from ertel.results.parameters import parameter_summary


def at_once(data: Mapping[str, Any], folder: Folder) -> dict[str, Any] | None:
    """The parameters of the case in plain data, see `parameter_summary`; None where its files must be read first.

    Raises ConfigError with ertel's message, and Outside for files outside the folder.
    """
    files = [folder.inside(table["file"]) for table in _with_files(data)]
    return None if files else parameter_summary(parse_case(data))


def moved(data: Mapping[str, Any], before: Path, now: Path | None = None) -> dict[str, Any]:
    """The plain data of a case whose files were named relative to one folder: now relative to another, or absolute."""
    if not _with_files(data):
        return dict(data)
    tables = [dict(table) if isinstance(table, dict) else table for table in data["roughness"]]
    for table in _with_files({"roughness": tables}):
        path = os.path.realpath(before / table["file"])
        table["file"] = os.path.relpath(path, now) if now else path
    return {**data, "roughness": tables}


def _with_files(data: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The tables of a case that name a file."""
    tables = data.get("roughness", [])
    found = tables if isinstance(tables, list) else []
    return [table for table in found if isinstance(table, dict) and isinstance(table.get("file"), str)]


async def outlook(data: Mapping[str, Any], folder: Folder) -> dict[str, Any]:
    """What `ertel check --json` says of a case.  Raises ValueError with its message where it refuses the case.

    The process ends when the task that waits for it is cancelled.
    """
    text = tomli_w.dumps(moved(data, folder.root))
    with tempfile.TemporaryDirectory(prefix="ertel-") as place:
        file = Path(place) / "case.toml"
        file.write_text(text, encoding="utf-8")
        process = await asyncio.create_subprocess_exec(
            *ERTEL,
            "check",
            str(file),
            "--json",
            stdin=asyncio.subprocess.DEVNULL,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.PIPE,
            env={**os.environ, "JAX_PLATFORMS": "cpu"},
        )
        try:
            answer, said = await process.communicate()
        except asyncio.CancelledError:
            with suppress(ProcessLookupError):
                process.kill()
            await process.wait()
            raise
    if process.returncode:
        lines = said.decode(errors="replace").splitlines()
        raise ValueError(next((line.removeprefix("ertel: ") for line in lines if line.startswith("ertel: ")), "failed"))
    found: dict[str, Any] = json.loads(answer)
    return found
