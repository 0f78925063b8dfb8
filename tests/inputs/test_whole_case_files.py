"""Whole case files, valid and spoiled: each is a case that reads back as the same, or is refused in one short line."""

from pathlib import Path

from case_file_strategies import case_files, outcome
from hypothesis import HealthCheck, given, settings


@settings(max_examples=300, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(content=case_files())
def test_any_file_is_a_case_or_refused_in_one_line(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "case.toml"
    path.write_bytes(content)
    outcome(path)
