"""One thread of linear algebra where the matrices are small.

NumPy's and SciPy's OpenBLAS start a thread for each core, and these wait for each other in a loop: on matrices of a few
hundred rows that costs several times the processor time and gains nothing, and on a busy machine it takes longer. A
command says so in its environment before NumPy is loaded. In somebody else's process, a script or a notebook, NumPy may
be there already and its threads are theirs: they are limited while a model or a diagnosis is computed, then given back.
"""

import ctypes
import os
from collections.abc import Callable, Generator
from contextlib import contextmanager
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from threading import Lock

VARIABLES = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")
"""Whoever sets one of them has decided; nothing is limited then."""

_PREFIXES, _SUFFIXES = ("scipy_", ""), ("64_", "")

_lock = Lock()
_within = 0
_given_back: list[tuple[Callable[[int], None], int]] = []


def say_one_thread() -> None:
    """In a process of our own, before it loads NumPy: one thread, unless the user says otherwise."""
    for name in VARIABLES:
        os.environ.setdefault(name, "1")


@contextmanager
def one_thread() -> Generator[None]:
    """Limit OpenBLAS to one thread within; also a decorator. Elsewhere in the process it has as many as before."""
    if any(os.environ.get(name) for name in VARIABLES):
        yield
        return
    _enter()
    try:
        yield
    finally:
        _leave()


def thread_counts() -> tuple[int, ...]:
    """Threads of each OpenBLAS that NumPy and SciPy bring, now."""
    return tuple(read() for read, _ in _libraries())


def _enter() -> None:
    global _within  # noqa: PLW0603
    with _lock:
        _within += 1
        if _within == 1:
            for read, write in _libraries():
                _given_back.append((write, read()))
                write(1)


def _leave() -> None:
    global _within  # noqa: PLW0603
    with _lock:
        _within -= 1
        if _within == 0:
            while _given_back:
                write, threads = _given_back.pop()
                write(threads)


@cache
def _libraries() -> tuple[tuple[Callable[[], int], Callable[[int], None]], ...]:
    """How to read and how to set the number of threads, of each OpenBLAS that the packages bring; others stay."""
    found: list[tuple[Callable[[], int], Callable[[int], None]]] = []
    for package in ("numpy", "scipy"):
        spec = find_spec(package)
        if spec is None or spec.origin is None:
            continue
        folder = Path(spec.origin).parent
        for file in [*folder.parent.glob(f"{package}.libs/*openblas*"), *folder.glob(".dylibs/*openblas*")]:
            pair = _functions(file)
            found += [pair] if pair is not None else []
    return tuple(found)


def _functions(file: Path) -> tuple[Callable[[], int], Callable[[int], None]] | None:
    try:
        library = ctypes.CDLL(str(file))
    except OSError:
        return None
    for name in (f"{prefix}openblas_{{}}_num_threads{suffix}" for prefix in _PREFIXES for suffix in _SUFFIXES):
        read, write = (getattr(library, name.format(verb), None) for verb in ("get", "set"))
        if read is not None and write is not None:
            return read, write
    return None
