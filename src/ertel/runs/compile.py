"""JAX: a check for versions that compute wrongly, its devices, its compilations counted, and its cache on disk.

The only module that changes JAX's configuration.  JAX is imported inside the functions, so that its version can be
read and judged without it.
"""

import hashlib
import os
import platform
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache as once
from glob import escape
from importlib.metadata import entry_points, version
from importlib.util import find_spec
from itertools import takewhile
from pathlib import Path
from stat import S_ISVTX
from typing import TYPE_CHECKING, Any

from platformdirs import user_cache_path

from ertel.version import own_sources

if TYPE_CHECKING:
    from ertel.case.case import Case
    from ertel.runs.exported import ExportedPrograms

EXCLUDED = ("0.10.2", "0.11.0")  # JAX issue 39103
REQUIREMENT = "jax" + ",".join(f"!={bad}" for bad in EXCLUDED)

QUIET = "TF_CPP_MIN_LOG_LEVEL", "3"  # XLA calls it an error when it loads code that it compiled itself
ENTRY_WARNINGS = tuple(f"Error {doing} persistent compilation cache entry" for doing in ("reading", "writing"))
MINIMUM = "jax_persistent_cache_min_compile_time_secs"  # 0: the many small programs add up
_EVENT = "/jax/core/compile/backend_compile_duration"
_compiled = 0
_exports: "ExportedPrograms | None" = None


# -- versions that compute wrongly ------------------------------------------------------------------------------------


def wrong_version(version: str) -> str:
    """A warning for a jaxlib version that gives wrong results; empty for other versions.

    jaxlib 0.10.2 and 0.11.0 miscompile a product of a matrix with many rows that is summed up, on the CPU and in
    double precision.  `tests/runs/test_compile.py` shows it.
    Source: issue 39103 of JAX.
    """
    if version not in EXCLUDED:
        return ""
    return f'JAX {version} computes wrongly on the CPU (JAX issue 39103); install another: pip install "{REQUIREMENT}"'


@once
def check_jax() -> None:
    """Warn, once per process, if the installed JAX gives wrong results."""
    if message := wrong_version(version("jaxlib")):
        warnings.warn(message, RuntimeWarning, stacklevel=2)


# -- devices ----------------------------------------------------------------------------------------------------------


class NoDevice(RuntimeError):
    """JAX finds no device to compute on."""


def may_use_accelerator() -> bool:
    """Return whether JAX may find another device than the CPU: a plugin is installed.  JAX is not imported."""
    return os.environ.get("JAX_PLATFORMS") != "cpu" and bool(entry_points(group="jax_plugins") or find_spec("libtpu"))


def jax_devices() -> list[Any]:
    """The devices that JAX computes on.  Raises NoDevice."""
    import jax

    try:
        return jax.devices()
    except Exception as error:  # of several kinds, an AssertionError among them
        message = f"JAX finds no device to compute on: {error}"
        if wanted := os.environ.get("JAX_PLATFORMS"):
            message = f"JAX_PLATFORMS={wanted}: JAX finds no such device here; unset it, or set JAX_PLATFORMS=cpu"
        raise NoDevice(message) from error


def accelerator() -> str:
    """The kind of device that JAX computes on; empty for a CPU, which nobody needs to be told."""
    device = jax_devices()[0]
    return "" if device.platform == "cpu" else str(device.device_kind)


# -- counting ---------------------------------------------------------------------------------------------------------


def compilations() -> int:
    """Programs compiled, or fetched from the persistent cache, in this process since the first call."""
    _listen()
    return _compiled


@once
def _listen() -> None:
    import jax

    def on_event(event: str, duration_secs: float, **_: str | int) -> None:
        global _compiled
        _compiled += event == _EVENT

    jax.monitoring.register_event_duration_secs_listener(on_event)


# -- the persistent cache ---------------------------------------------------------------------------------------------

chosen: Callable[[], object] | None = None  # how this process keeps programs, for its workers too


def cache() -> Path | None:
    """Keep compiled programs on disk from now on, for all of this process, and load them in later ones.

    A program is then compiled once per machine, and not once per process.  This changes settings of JAX for the whole
    process, so ertel does it only where it is asked to; the commands do it.  A directory that JAX has already, from
    JAX_COMPILATION_CACHE_DIR or from its configuration, stays as it is.  Otherwise programs are kept in the directory
    that `ertel about` names, which is made for this user alone.

    Returns
    -------
    Path or None
        The directory; None where nothing is kept: there is no home directory, it cannot be written, or, with a
        RuntimeWarning, other users could plant programs there.

    Examples
    --------
    >>> import ertel
    >>> ertel.cache()  # doctest: +SKIP
    """
    global chosen
    os.environ.setdefault(*QUIET)
    import jax
    from jax.experimental.compilation_cache import compilation_cache

    chosen = chosen or cache
    present = _jax_directory()
    if present is not None:
        return Path(present) if present else None
    directory = cache_directory()
    if directory is None or not _is_safe(directory):
        return None
    jax.config.update("jax_compilation_cache_dir", str(directory))
    jax.config.update(MINIMUM, 0.0)
    compilation_cache.reset_cache()  # JAX looks for a directory once, at the first compilation
    return directory


def start_at_once() -> Path | None:
    """Do as `cache` does, and keep the programs also in exported form, which a process loads without tracing.

    For commands: in Python, somebody may replace a constant or a function of ertel, which only tracing notices.
    """
    global chosen, _exports
    import jax

    from ertel.numerics.programs import build_with
    from ertel.runs.exported import ExportedPrograms

    directory, chosen = cache(), start_at_once
    if directory is None or "://" in str(_jax_directory()):
        return directory
    if _is_safe(directory / "ertel"):
        if MINIMUM.upper() not in os.environ:
            jax.config.update(MINIMUM, 0.0)
        stamp = "\0".join((own_sources(), version("jax"), version("jaxlib")))
        _exports = ExportedPrograms(directory / "ertel", stamp)
        build_with(_exports.build)
    elif not _is_own(directory):
        jax.config.update("jax_enable_compilation_cache", False)
        return None
    return directory


def prepare_jax() -> Path | None:
    """Check that JAX computes here, and let it load what is compiled, from the directory named.  Raises NoDevice."""
    check_jax()
    jax_devices()
    return start_at_once()


@contextmanager
def jax_prepared(case: "Case", tell: Callable[[], object] = lambda: None) -> Iterator[None]:
    """In this block one case is run.  What a steady one needs is loaded, or compiled in a hurry, in the background.

    tell: what is called after the run where programs are then compiled for later ones.  Raises NoDevice.
    """
    prepare_jax()
    if not case.is_steady or _exports is None:
        yield
        return
    from ertel.solvers import SOLVERS

    solver: Any = SOLVERS[case.solver.method](case)
    with _exports.in_a_hurry(tell):
        solver.compile_ahead()
        yield


def cache_directory() -> Path | None:
    """The directory of compiled programs: JAX_COMPILATION_CACHE_DIR, or one per processor type and jaxlib version.

    XLA compiles for the instructions of one processor type, and a home directory may be shared between machines.
    It lies in the system's folder for caches, or in XDG_CACHE_HOME; None for a user without a home directory.
    """
    if wanted := os.environ.get("JAX_COMPILATION_CACHE_DIR"):
        return Path(wanted)
    base = user_cache_path("ertel", appauthor=False)
    return base / "jax" / f"{_processor()}-jaxlib-{version('jaxlib')}" if base.is_absolute() else None


def _jax_directory() -> str | None:
    """The directory that JAX uses now."""
    import jax

    return getattr(jax.config, "jax_compilation_cache_dir", None)


def _processor() -> str:
    """The machine's architecture and a digest of the processor's model and instruction set."""
    kind = [platform.processor()]
    with suppress(OSError), open("/proc/cpuinfo", encoding="utf-8") as file:  # Linux
        first = takewhile(str.strip, file)  # one block per core, with an empty line after it
        kind = [line for line in first if line.startswith(("model name", "flags", "CPU", "Features"))]
    return f"{platform.machine()}-{hashlib.sha256(''.join(kind).encode()).hexdigest()[:8]}"


# A program from the cache runs with the rights of this user, so nobody else may have written it.


def _is_safe(directory: Path) -> bool:
    """Return whether nobody but this user can put a program into a directory, made if need be; warn where not.

    Neither the directory nor the one that it is in may be another user's, and no file in it.  No other user may rename
    one of the directories above.
    """
    try:
        for folder in (*reversed(directory.parents[:2]), directory):
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        closed = not directory.stat().st_mode & 0o077  # nobody else may enter
        wrong = [folder for folder in (directory, directory.parent) if not _is_own(folder)]
        wrong += [folder for folder in _above(directory) if not _is_guarded(folder)]
        wrong += [path for path in directory.iterdir() if not _is_own(path, closed)]
    except OSError:  # it cannot be made, read, ...
        return False
    if wrong:
        why = f"{wrong[0]} belongs to another user, or others may write to it"
        advice = "make sure that only you can, or set JAX_COMPILATION_CACHE_DIR to another directory"
        warnings.warn(f"compiled programs are not kept: {why}; {advice}", RuntimeWarning, stacklevel=3)
    return not wrong


def _above(directory: Path) -> list[Path]:
    """The directories above one, as it is named and where links lead, up to the home of this user or the root."""
    home = Path(os.path.expanduser("~"))  # unlike Path.home() also without one
    ends = [home, home.resolve()]
    found: list[Path] = []
    for above in (directory.absolute().parents, directory.resolve().parents):
        found += above[: next((n + 1 for n, path in enumerate(above) if path in ends), None)]
    return found


def _is_guarded(path: Path) -> bool:
    """Return whether only this user and the system may rename what lies in a directory."""
    info = path.stat()
    return os.name == "nt" or (
        info.st_uid in (0, os.getuid()) and (not info.st_mode & 0o022 or info.st_mode & S_ISVTX > 0)
    )


def _is_own(path: Path, closed: bool = False) -> bool:
    """Return whether a file or directory belongs to this user and nobody else may write to it.

    closed: it lies in a directory that nobody else may enter.
    """
    if os.name == "nt":
        return True
    try:
        info = path.stat()
    except FileNotFoundError:  # the draft of another process
        return True
    return info.st_uid == os.getuid() and (closed or not info.st_mode & 0o022)


# -- entries that cannot be read --------------------------------------------------------------------------------------


def is_of_cache(message: str) -> bool:
    """Return whether a warning is JAX's about an entry of its cache; delete the entries of that name if one is damaged.

    For commands, which do not pass it on: there may be hundreds.  JAX compiles the program again, and writes it only
    where there is no entry.
    """
    if message.startswith(ENTRY_WARNINGS[0]) and (directory := _jax_directory()):
        name = message.split("'")[1]
        for path in Path(directory).glob(f"{escape(name)}-*-cache"):
            with suppress(OSError):  # a cache that may only be read
                path.unlink()
    return message.startswith(ENTRY_WARNINGS)
