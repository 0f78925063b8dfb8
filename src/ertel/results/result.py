"""What a run gave."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import xarray as xr

from ertel.model.case import Case
from ertel.model.status import Status


@dataclass(frozen=True)
class Result:
    """What a run gave: its Dataset, its summary (see `results.summary`) and how it ended."""

    case: Case
    dataset: xr.Dataset
    summary: Mapping[str, Any]
    status: Status
    directory: Path | None = None

    @property
    def warnings(self) -> list[str]:
        """What a careful colleague would warn of."""
        return list(self.summary.get("warnings", ()))
