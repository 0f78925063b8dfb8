"""JAX compilations: counts, cache on disk, and a check for versions that give wrong results."""

import hashlib
import os
import platform
import warnings
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from importlib.metadata import version
from itertools import takewhile
from pathlib import Path
from typing import Any

from ertel.version import own_sources

# JAX is imported inside the functions, so that its version can be read and judged without it.

EXCLUDED = ("0.10.2", "0.11.0")  # JAX issue 39103
REQUIREMENT = "jax" + ",".join(f"!={bad}" for bad in EXCLUDED)

_EVENT = "/jax/core/compile/backend_compile_duration"
_compiled = 0
_told = False


# -- versions that compute wrongly ------------------------------------------------------------------------------------


def wrong_version(version: str) -> str:
    """A warning for a jaxlib version that gives wrong results; empty for other versions.

    jaxlib 0.10.2 and 0.11.0 miscompile a product of a matrix with many rows that is summed up, on the CPU and in
    double precision.  `tests/runs/test_compiling.py` shows it.
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


def devices() -> list[Any]:
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


def count() -> int:
    """Programs compiled, or fetched from the persistent cache, in this process since the first call."""
    _listen()
    return _compiled


@cache
def _listen() -> None:
    import jax

    def on_event(event: str, duration_secs: float, **_: str | int) -> None:
        global _compiled
        _compiled += event == _EVENT

    jax.monitoring.register_event_duration_secs_listener(on_event)


# -- the persistent cache ---------------------------------------------------------------------------------------------


def keep_on_disk() -> None:
    """Keep compiled programs in JAX's cache, in `cache_directory` unless the user chose a directory.

    Nothing is kept where there is no such directory or it cannot be written.
    """
    import jax
    from jax.experimental.compilation_cache import compilation_cache

    for doing in ("reading", "writing"):  # JAX warns of each of hundreds of programs
        warnings.filterwarnings("ignore", message=f"Error {doing} persistent compilation cache entry")
    directory = cache_directory()
    if directory and _jax_directory() is None and "JAX_COMPILATION_CACHE_DIR" not in os.environ:
        jax.config.update("jax_compilation_cache_dir", str(directory))
        jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)  # the many small ones add up
        compilation_cache.reset_cache()  # JAX looks for a directory once, at the first compilation
    _replace_unreadable()


def start_at_once() -> None:
    """Keep the large programs also so that a process loads them without tracing them (`programs`).

    For commands: in Python, somebody may replace a constant or a function of ertel, which only tracing notices.
    """
    from ertel.numerics import programs

    keep_on_disk()
    if directory := _jax_directory():
        parts = own_sources(), version("jax"), version("jaxlib"), _processor(), os.environ.get("XLA_FLAGS", "")
        programs.keep(Path(directory) / "ertel", hashlib.sha256("\0".join(parts).encode()).hexdigest())


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


@cache
def _replace_unreadable() -> None:
    """Make JAX delete an unreadable entry of its cache (such as a truncated file) and compile it again.

    JAX itself warns, compiles, and leaves the entry as it is: so in every process from then on.  It has no public hook
    for this; a version without the function that is wrapped here goes on as it is.
    """
    from jax._src import compilation_cache

    read = getattr(compilation_cache, "get_executable_and_time", None)
    if read is None:
        return

    def read_or_delete(cache_key: str, *arguments: Any, **named: Any) -> Any:
        try:
            return read(cache_key, *arguments, **named)
        except Exception:  # zlib.error, an error of XLA, ...
            with suppress(OSError):  # a cache that may only be read
                Path(_jax_directory() or "", f"{cache_key}-cache").unlink(missing_ok=True)
            return None, None

    compilation_cache.get_executable_and_time = read_or_delete  # type: ignore[assignment, unused-ignore]
