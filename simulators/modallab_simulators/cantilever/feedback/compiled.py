"""Compiles the stepping loop where numba is installed; else the same code runs as it is, some 100 times slower."""

from collections.abc import Callable
from importlib.util import find_spec
from typing import Any, TypeVar

_Function = TypeVar("_Function", bound=Callable[..., Any])

AVAILABLE = find_spec("numba") is not None
"""Whether loops are compiled."""


def compiled(function: _Function) -> _Function:
    """The function as machine code, kept on disk for the next process."""
    if not AVAILABLE:
        return function
    # Some install no numba.
    import numba

    return numba.njit(cache=True)(function)  # pyrefly: ignore[bad-return]  # it is called as the function is
