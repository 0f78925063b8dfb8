"""Small runs that are killed, that run out of space, and whose files are damaged: a short form of validation/faults."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import ertel

ALL = ["radial", "2d", "rolling", "steady", "ellipse", "thinning", "thinning in time", "thermal", "measured", "study"]
FAULTS = Path(__file__).parents[2] / "validation" / "faults" / "faults.py"


@pytest.mark.slow
@pytest.mark.parametrize(("kinds", "count"), [(["radial", "study"], 8), (ALL, 4 * len(ALL))], ids=["radial", "all"])
def test_nothing_is_silent_and_no_flushed_step_is_lost(tmp_path: Path, kinds: list[str], count: int):
    """In a process of its own, because it forks: so many kills and more, full disks, damaged runs."""
    environment = {**os.environ, "PYTHONPATH": str(Path(ertel.__path__[0]).parent), "TMPDIR": str(tmp_path)}
    command = [sys.executable, str(FAULTS), "kills", "disk", "bits", "--count", str(count), "--seed", "14"]
    done = subprocess.run([*command, "--kinds", *kinds], capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    ends = [line for line in done.stdout.splitlines() if " trials, " in line]
    told = [f"{what}, seed 14: {count}" for what in ("kills", "disk", "bits")]
    assert [line.partition(" trials")[0] for line in ends] == told
    assert "refused damage" in done.stdout
