"""A command keeps the memory of the arrays that it frees: the kernel need not clear it for every time step."""

import os
import subprocess
import sys

import pytest

# how often the kernel hands out a page while arrays of 40 MB come and go
PAGES = """
import resource
import numpy as np
faults = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_minflt
for _ in range(3):
    np.ones(5_000_000)
before = faults()
for _ in range(10):
    np.ones(5_000_000)
print(faults() - before)
"""
KEEP = "from ertel.apps import process\nprocess.keep_freed_memory()\n"


def pages(code: str, **chosen: str) -> int:
    plain = {name: value for name, value in os.environ.items() if not name.startswith("MALLOC_")}
    env = plain | {"NUMPY_MADVISE_HUGEPAGE": "0"} | chosen
    done = subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, text=True, check=True)
    return int(done.stdout)


@pytest.mark.skipif(os.confstr("CS_GNU_LIBC_VERSION") is None, reason="another C library than glibc")
def test_arrays_that_come_and_go_keep_their_pages() -> None:
    assert pages(KEEP + PAGES) < 0.01 * pages(PAGES)


@pytest.mark.skipif(os.confstr("CS_GNU_LIBC_VERSION") is None, reason="another C library than glibc")
def test_what_the_user_has_set_wins() -> None:
    assert pages(KEEP + PAGES, MALLOC_MMAP_THRESHOLD_="1000000") > 0.9 * pages(PAGES)
