"""What ertel says of a case before it is run: at once whether it is one, and after two seconds all of `ertel check`.

The first is asked here; the second needs JAX and is a process of its own, which ends when the case changes again.
"""

import asyncio
import json
import os
import tempfile
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from ertel.apps.browser.folder import Folder
from ertel.apps.browser.form import files_of
from ertel.apps.browser.processes import ERTEL
from ertel.inputs.case_files import parse_case
from ertel.model.case import Case


def case_in(data: Mapping[str, Any], folder: Folder) -> Case:
    """The case in plain data.  Raises ConfigError with ertel's message, and Outside for files outside the folder."""
    for file in files_of(data):
        folder.inside(str(file))
    return parse_case(data)


async def outlook(text: str) -> dict[str, Any]:
    """What `ertel check --json` says of a case file.  Raises ValueError with its message where it refuses the case.

    The process ends when the task that waits for it is cancelled.
    """
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
