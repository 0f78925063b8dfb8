"""A check for processes forked after a computation: JAX waits there for threads that only the parent has."""

import os

_computing: int | None = None  # the process that has computed first


class Forked(RuntimeError):
    """This process is a copy of one that has computed, in which JAX would wait for ever."""


def check() -> None:
    """Raise Forked where this process is a copy of one that has computed before."""
    global _computing
    if _computing is None:
        _computing = os.getpid()
    if _computing != os.getpid():
        raise Forked(
            "this process was forked from one in which JAX runs, and would hang; start processes with "
            'multiprocessing.get_context("spawn"), or run the cases with ertel.sweep'
        )
