"""Where a run comes from: the case, the versions and the machine, as attributes of its Dataset."""

import json
import platform
from dataclasses import asdict, is_dataclass
from datetime import UTC, datetime
from importlib.metadata import version
from math import inf
from typing import Any

import ertel
from ertel.model.case import Case
from ertel.results.parameters import parameters_of, scales_of


def provenance(case: Case) -> dict[str, object]:
    """Attributes that make a run self-describing: case, versions, platform, time, references."""
    laws = (case.lubricant.viscosity_law, case.lubricant.density_law)
    return {
        "Conventions": "CF-1.11",
        "title": case.name or f"{case.kind}, M = {case.parameters.M:.4g}, L = {case.parameters.L:.4g}",
        "source": f"ertel {ertel.__version__}",
        "references": "; ".join(getattr(law, "reference", type(law).__name__) for law in laws),
        "date_created": datetime.now(UTC).isoformat(timespec="seconds"),
        "platform": f"{platform.system()} {platform.machine()}, {platform.processor() or 'unknown processor'}",
        "versions": json.dumps(versions()),
        "case": json.dumps(describe(case), default=repr),
        "kind": case.kind,
        "method": case.solver.method,
        **parameters_of(case),
        **scales_of(case),
    }


def versions() -> dict[str, str]:
    """Versions of what a result may depend on."""
    packages = ("jax", "jaxlib", "numpy", "scipy", "xarray", "zarr")
    ours = {"ertel": ertel.__version__, "python": platform.python_version()}
    return ours | {name: version(name) for name in packages}


def describe(case: Case) -> dict[str, object]:
    """A case as plain data: the records that it is made of, the names of its laws, and its input."""
    oil = case.lubricant
    return {
        "name": case.name,
        "kind": case.kind,
        "parameters": asdict(case.parameters),
        "lubricant": {"viscosity": _describe_law(oil.viscosity_law), "density": _describe_law(oil.density_law)},
        "motion": {name: _describe_law(value) for name, value in vars(case.motion).items()},
        "roughness": [{"surface": f.surface, **_describe_law(f.shape)} for f in case.roughness],
        "solver": asdict(case.solver),
        "time": asdict(case.time),
        "output": asdict(case.output),
        "scales": asdict(case.scales) if case.scales else None,
        "source": case.source,
    }


def _describe_law(law: Any) -> Any:
    """A record as its name and what is in it; infinite means that there is none.  A number as it is."""
    if isinstance(law, int | float):
        return law
    values = asdict(law) if is_dataclass(law) and not isinstance(law, type) else {}
    return {"law": type(law).__name__, **{name: value for name, value in values.items() if value != inf}}
