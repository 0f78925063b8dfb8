"""JAX compilations: counted, and kept on disk so that each is done once per machine and grid shape."""

import os
from pathlib import Path

import jax

_EVENT = "/jax/core/compile/backend_compile_duration"
_count = 0


def _listen(event: str, duration_secs: float, **_: str | int) -> None:
    global _count
    _count += event == _EVENT


jax.monitoring.register_event_duration_secs_listener(_listen)


def count() -> int:
    """Programs compiled (or fetched from the persistent cache) in this process so far."""
    return _count


def keep_on_disk() -> None:
    """Use a persistent compilation cache, unless the user has chosen one (JAX_COMPILATION_CACHE_DIR) or none."""
    chosen = getattr(jax.config, "jax_compilation_cache_dir", None)
    if chosen is None and "JAX_COMPILATION_CACHE_DIR" not in os.environ:
        base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
        jax.config.update("jax_compilation_cache_dir", str(base / "ertel" / "jax"))
        jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)  # the many small ones add up
