"""JAX compilations: counts, cache on disk, and a check for versions that give wrong results."""

import hashlib
import os
import platform
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache as once
from importlib import import_module
from importlib.metadata import entry_points, version
from importlib.util import find_spec
from itertools import takewhile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ertel.version import own_sources

if TYPE_CHECKING:
    from ertel.case.case import Case

# JAX is imported inside the functions, so that its version can be read and judged without it.

EXCLUDED = ("0.10.2", "0.11.0")  # JAX issue 39103
REQUIREMENT = "jax" + ",".join(f"!={bad}" for bad in EXCLUDED)

QUIET = "TF_CPP_MIN_LOG_LEVEL", "3"  # XLA calls it an error when it loads code that it compiled itself
ENTRY_WARNINGS = tuple(f"Error {doing} persistent compilation cache entry" for doing in ("reading", "writing"))
_EVENT = "/jax/core/compile/backend_compile_duration"
_compiled = 0
_told = False


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


def check_jax(tell: Callable[[str], object] | None = None) -> None:
    """Warn, once per process, if the installed JAX gives wrong results.

    tell: what is called with the sentence; `warnings.warn` by default.
    """
    global _told
    message = wrong_version(version("jaxlib"))
    if message and not _told:
        _told = True
        if tell:
            tell(message)
        else:
            warnings.warn(message, RuntimeWarning, stacklevel=2)


# -- devices ----------------------------------------------------------------------------------------------------------


class NoDevice(RuntimeError):
    """JAX finds no device to compute on."""


def may_use_accelerator() -> bool:
    """Whether JAX may find another device than the CPU: a plugin for one is installed.  It does not import JAX."""
    return os.environ.get("JAX_PLATFORMS") != "cpu" and bool(entry_points(group="jax_plugins") or find_spec("libtpu"))


def jax_devices() -> list[Any]:
    """The devices that JAX computes on.  Raises NoDevice."""
    import jax

    try:
        return jax.devices()
    except Exception as error:  # of several kinds, an AssertionError among them
        chosen = os.environ.get("JAX_PLATFORMS")
        if not chosen:
            raise NoDevice(f"JAX finds no device to compute on: {error}") from error
        raise NoDevice(
            f"JAX_PLATFORMS={chosen}: JAX finds no such device here; unset it, or set JAX_PLATFORMS=cpu"
        ) from error


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

_chosen: Callable[[], object] | None = None


def chosen_cache() -> Callable[[], object] | None:
    """How this process keeps programs, so that its workers do the same: `cache`, `start_at_once`, or None."""
    return _chosen


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
    global _chosen
    os.environ.setdefault(*QUIET)
    import jax
    from jax.experimental.compilation_cache import compilation_cache

    _chosen = _chosen or cache
    known = _jax_directory()
    if known is not None:
        return Path(known) if known else None
    directory = cache_directory()
    if directory is None or not _is_safe(directory):
        return None
    jax.config.update("jax_compilation_cache_dir", str(directory))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)  # the many small ones add up
    compilation_cache.reset_cache()  # JAX looks for a directory once, at the first compilation
    return directory


def start_at_once() -> Path | None:
    """Do as `cache` does, and keep the large programs also so that a process loads them without tracing (`programs`).

    For commands: in Python, somebody may replace a constant or a function of ertel, which only tracing notices.
    """
    global _chosen
    from ertel.numerics import programs

    directory, _chosen = cache(), start_at_once
    if directory and "://" not in str(_jax_directory()) and _is_safe(directory / "ertel"):
        parts = own_sources(), version("jax"), version("jaxlib"), _processor(), os.environ.get("XLA_FLAGS", "")
        programs.keep(directory / "ertel", hashlib.sha256("\0".join(parts).encode()).hexdigest())
    return directory


def prepare_jax() -> Path | None:
    """Check that JAX computes here, and let it load what is compiled, from the directory named.  Raises NoDevice."""
    check_jax()
    jax_devices()
    return start_at_once()


@contextmanager
def jax_prepared(case: "Case") -> Iterator[None]:
    """In this block one case is run.  What a steady one needs is loaded, or compiled in a hurry, in the background.

    Raises NoDevice.
    """
    prepare_jax()
    if not case.is_steady:
        yield
        return
    from ertel.numerics.programs import in_a_hurry
    from ertel.solvers.steady import compile_ahead

    with in_a_hurry():
        compile_ahead(case)
        yield


def cache_directory() -> Path | None:
    """Where compiled programs are kept: JAX_COMPILATION_CACHE_DIR, or a folder per processor type and jaxlib version.

    XLA compiles for the instructions of one processor type, and a home directory may be shared between machines.
    None for a user without a home directory.
    """
    if chosen := os.environ.get("JAX_COMPILATION_CACHE_DIR"):
        return Path(chosen)
    try:
        base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    except RuntimeError:
        return None
    return base / "ertel" / "jax" / f"{_processor()}-jaxlib-{version('jaxlib')}"


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
    """Whether nobody but this user can put a program into a directory, which is made if need be; warns where not."""
    try:
        for folder in (*reversed(directory.parents[:2]), directory):
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        wrong = list(_open_to_others(directory))
    except OSError:  # it cannot be made, read, ...
        return False
    if wrong:
        warnings.warn(
            f"compiled programs are not kept: {wrong[0]} belongs to another user, or others may write to it; "
            "see to it that only you can, or set JAX_COMPILATION_CACHE_DIR to another directory",
            RuntimeWarning,
            stacklevel=3,
        )
    return not wrong


def _open_to_others(directory: Path) -> Iterator[Path]:
    """The directory, the one that it is in, and its files, as far as another user owns them or may write to them."""
    from ertel.numerics.programs import is_own

    yield from (folder for folder in (directory, directory.parent) if not is_own(folder.stat()))
    closed = not directory.stat().st_mode & 0o077
    for path in directory.iterdir():
        with suppress(FileNotFoundError):  # the draft of another process
            if not is_own(path.stat(), closed):
                yield path


# -- entries that cannot be read --------------------------------------------------------------------------------------

ZSTANDARD = b"\x28\xb5\x2f\xfd"  # how such data begin


def is_of_cache(message: str) -> bool:
    """Whether a warning is JAX's about an entry of its cache; entries that are cut short are then deleted.

    For commands, which do not pass it on: there may be hundreds.  JAX compiles the program again, and writes it only
    where there is no entry.
    """
    of_cache = message.startswith(ENTRY_WARNINGS)
    if of_cache and (directory := _jax_directory()):
        _delete_cut_short(Path(directory))
    return of_cache


def _delete_cut_short(directory: Path) -> None:
    """Delete the entries of JAX's cache that cannot be unpacked."""
    for path in directory.glob("*-cache"):
        with suppress(OSError):  # a cache that may only be read
            if not _unpacks(path.read_bytes()):
                path.unlink(missing_ok=True)


def _unpacks(content: bytes) -> bool:
    """Whether data are whole, packed in one of the ways that JAX uses."""
    module = "zlib" if content[:4] != ZSTANDARD else "zstandard" if sys.version_info < (3, 14) else "compression.zstd"
    try:
        import_module(module).decompress(content)
    except ImportError:  # whoever wrote it could read it
        return True
    except Exception:  # of zlib or zstandard
        return False
    return True
