"""One thread of linear algebra where the matrices are small.

NumPy's and SciPy's libraries start a thread for each core, and these wait for each other in a loop: on matrices of a
few hundred rows that costs several times the processor time and gains nothing, and on a busy machine it takes longer. A
command says so in its environment before NumPy is loaded. In somebody else's process, a script or a notebook, NumPy may
be there already and its threads are theirs: they are limited while a model or a diagnosis is computed, then given back.
"""

import os
from collections.abc import Generator
from contextlib import contextmanager
from threading import Lock

from threadpoolctl import threadpool_limits

VARIABLES = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")
"""Whoever sets one of them has decided; nothing is limited then."""

_lock = Lock()
_limits: list[threadpool_limits] = []
_within = 0


def limit_to_one_thread() -> None:
    """In a process of our own, before it loads NumPy: one thread, unless the user says otherwise."""
    for name in VARIABLES:
        os.environ.setdefault(name, "1")


@contextmanager
def one_thread() -> Generator[None]:
    """Limit linear algebra to one thread within; also a decorator. Elsewhere in the process it has as many as before.

    Several threads may be within: the first limits, the last gives back.
    """
    if any(os.environ.get(name) for name in VARIABLES):
        yield
        return
    _enter_one_thread()
    try:
        yield
    finally:
        _leave_one_thread()


def _enter_one_thread() -> None:
    global _within  # noqa: PLW0603
    with _lock:
        _within += 1
        if _within == 1:
            _limits.append(threadpool_limits(limits=1, user_api="blas"))


def _leave_one_thread() -> None:
    global _within  # noqa: PLW0603
    with _lock:
        _within -= 1
        if _within == 0:
            _limits.pop().restore_original_limits()
