"""Memory that is freed stays with the process, where the C library is glibc.

On grids from about 513 x 513 nodes on, glibc returns the arrays of each time step to the kernel, and the kernel clears
them page by page before the next step gets them back: a quarter of the time of a step.
"""

import ctypes
import os
from contextlib import suppress

# what mallopt(3) calls each setting, its number there, and its value: one arena, and no limit on what is kept
SETTINGS = (("ARENA_MAX", -8, 1), ("MMAP_THRESHOLD_", -3, 2**30), ("TRIM_THRESHOLD_", -1, 2**31 - 1))


def keep() -> None:
    """Keep freed memory in this process and in those that it starts; what the user has set in the environment wins."""
    with suppress(OSError, AttributeError):  # another C library
        mallopt = ctypes.CDLL("libc.so.6").mallopt
        for name, number, value in SETTINGS:
            if f"MALLOC_{name}" not in os.environ:
                mallopt(number, value)
                os.environ[f"MALLOC_{name}"] = str(value)
