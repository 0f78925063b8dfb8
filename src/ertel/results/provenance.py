"""Provenance of a run: the case, the versions and the machine, as attributes of its Dataset."""

import json
import platform
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import version

from ertel.case.case import Case
from ertel.results.parameters import parameters_of, scales_of
from ertel.version import installed_version


def provenance(case: Case) -> dict[str, object]:
    """Attributes that make a run self-describing: case, versions, platform, time, references."""
    laws: list[object] = [case.lubricant.viscosity_law, case.lubricant.density_law]
    if not case.oil.is_newtonian:
        laws.append(case.oil.fluidity_law)
    return {
        "Conventions": "CF-1.11",
        "title": case.name or f"{case.kind}, M = {case.parameters.M:.4g}, L = {case.parameters.L:.4g}",
        "source": f"ertel {installed_version()}",
        "references": "; ".join(getattr(law, "reference", type(law).__name__) for law in laws),
        "date_created": datetime.now(UTC).isoformat(timespec="seconds"),
        "platform": f"{platform.system()} {platform.machine()}, {platform.processor() or 'unknown processor'}",
        "versions": json.dumps(versions()),
        **_written(case),
        "kind": case.kind,
        "method": case.solver.method,
        **parameters_of(case),
        **scales_of(case),
    }


@cache  # reading them takes longer than writing a coarse grid
def versions() -> dict[str, str]:
    """Versions of the software on which a result may depend."""
    packages = ("jax", "jaxlib", "numpy", "scipy", "xarray", "zarr")
    ours = {"ertel": installed_version(), "python": platform.python_version()}
    return ours | {name: version(name) for name in packages}


def _written(case: Case) -> dict[str, str]:
    """The case as it is written and its digest; for one that cannot be written the reason."""
    try:
        return {"case": json.dumps(case.to_data()), "digest": case.digest}
    except ValueError as error:
        return {"case_not_written": str(error)}
