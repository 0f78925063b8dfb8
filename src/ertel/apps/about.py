"""The content of `ertel about`: versions, devices, cache, citation; the origin and the end of a run."""

import json
import os
import platform
import re
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import ertel
from ertel.apps.terminal import shown
from ertel.case.status import Status
from ertel.inputs.oils import own_file
from ertel.runs.compile import NoDevice, cache_directory, jax_devices, wrong_version
from ertel.runs.directory import read_progress
from ertel.runs.store import RunStore

PACKAGES = {"JAX": "jax", "jaxlib": "jaxlib", "NumPy": "numpy", "SciPy": "scipy", "xarray": "xarray", "zarr": "zarr"}


def bibtex(version: str = ertel.__version__) -> str:
    """BibTeX entries of ertel, of this version, and of the paper whose equations it solves."""
    return Path(__file__).with_name("citation.bib").read_text(encoding="utf-8").replace("VERSION", version)


def _citation() -> str:
    """The same in a line."""
    entries = bibtex(f"Version {ertel.__version__}").split("\n\n")
    fields = (dict(re.findall(r"(\w+) += {(.*)}", entry)) for entry in entries)
    software, paper = (re.sub(r"[{}]|\.(?=\. )", "", ". ".join(each.values())) for each in fields)
    return f"{software}. Cite with it: {paper}."


def about() -> dict[str, str]:
    """Versions, devices and directories by name; helpful in a report of a problem."""
    return {
        "ertel": ertel.__version__,
        "Python": f"{platform.python_version()} on {platform.system()} {platform.machine()}",
        **{name: _version(package) for name, package in PACKAGES.items()},
        "known faults": wrong_version(_version("jaxlib")) or "none in this version of JAX",
        "devices": _devices(),
        "compile cache": str(cache_directory() or "none: there is no home directory"),
        "own oils": str(own_file()),
        "citation": _citation(),
    }


def of_run(run: RunStore) -> dict[str, str]:
    """The case, versions and machine of a run, and its end, by name.  Raises StoreError where the run is damaged."""
    attributes = run.dataset().attrs
    versions = json.loads(attributes["versions"])
    return {
        "run": shown(run.directory),
        "case": attributes["title"],
        "digest": run.case.digest,
        "ertel": versions.pop("ertel"),
        **{name: versions[package] for name, package in {"Python": "python", **PACKAGES}.items()},
        "machine": attributes["platform"],
        "begun": attributes["date_created"],
        "end": _end(run),
    }


def _end(run: RunStore) -> str:
    """The end of a run, or its progress."""
    summary: dict[str, Any] | None = run.summary()
    if summary is None:
        progress = read_progress(run.directory)
        far = f", {progress['done']:.0%} done at {progress['written']}" if progress else ""
        return f"not yet{far}"
    status = Status(summary["status"])
    advice = f"; {status.advice}" if status.advice else ""
    return f"{status.value}, after {summary['wall_s']:.1f} s{advice}"


def _devices() -> str:
    """The devices that JAX computes on."""
    try:
        kinds = [device.device_kind for device in jax_devices()]
    except (ImportError, NoDevice) as error:
        return f"none: {error}"
    return ", ".join(f"{kind} ({os.cpu_count()} cores)" if kind == "cpu" else kind for kind in kinds)


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"
