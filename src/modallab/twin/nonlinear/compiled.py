"""How the loops of this folder are compiled."""

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

_Function = TypeVar("_Function", bound=Callable[..., Any])


def machine_code(function: _Function) -> _Function:
    """The function as machine code, kept on the disk, which lets other threads run."""
    # Sums may be taken in another order; nothing else of IEEE 754 is given up.
    return cast("_Function", numba.njit(cache=True, nogil=True, fastmath={"contract", "reassoc", "nsz"})(function))
