"""Small runs that are killed, that run out of space, and whose files are damaged: a short form of validation/faults."""

import os
import subprocess
import sys
from pathlib import Path

import ertel

FAULTS = Path(__file__).parents[2] / "validation" / "faults" / "faults.py"


def test_nothing_is_silent_and_no_flushed_step_is_lost(tmp_path: Path):
    """In a process of its own, because it forks: 5 kills and more, 5 full disks, 5 damaged runs."""
    environment = {**os.environ, "PYTHONPATH": str(Path(ertel.__path__[0]).parent), "TMPDIR": str(tmp_path)}
    command = [sys.executable, str(FAULTS), "kills", "disk", "bits", "--count", "5", "--seed", "14"]
    kinds = ["--kinds", "radial", "steady"]
    done = subprocess.run([*command, *kinds], capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    ends = [line for line in done.stdout.splitlines() if " trials, " in line]
    assert [line.partition(",")[0] for line in ends] == ["kills: 5 trials", "disk: 5 trials", "bits: 5 trials"]
    assert "refused damage" in done.stdout
