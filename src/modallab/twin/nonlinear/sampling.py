"""A sine step by step, and steps as a converter samples them."""

import math
from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

from modallab.core.arrays import Real

_Function = TypeVar("_Function", bound=Callable[..., Any])


def machine_code(function: _Function) -> _Function:
    """The function as machine code, kept on the disk, which lets other threads run."""
    # Sums may be taken in another order; nothing else of IEEE 754 is given up.
    return cast("_Function", numba.njit(cache=True, nogil=True, fastmath={"contract", "reassoc", "nsz"})(function))


BLOCK = 512
"""Samples that are filtered at once."""


@machine_code
def rising_sine(
    amplitude: complex, step: float, ahead: float, since: float, ramp: float, cosine: bool, out: Real
) -> None:
    """A sine that rises from rest, into `out`.

    Args:
        amplitude: of Re(amplitude exp(j phase)), where the phase is 0 after `ahead` steps.
        step: rad of phase a step.
        ahead: steps before that.
        since: steps from its start to the first.
        ramp: steps for which it rises.
        cosine: whether along a cosine; else along a straight line.
        out: (steps,)
    """
    turn = complex(math.cos(step), math.sin(step))
    now = amplitude * complex(math.cos(step * ahead), -math.sin(step * ahead))
    for n in range(out.shape[0]):
        share = min(max((n + since) / ramp, 0.0), 1.0)
        out[n] = now.real * (0.5 - 0.5 * math.cos(math.pi * share) if cosine else share)
        # Rounding makes each turn longer or shorter by 1e-16 of it.
        now *= turn


@machine_code
def decimate_rows(fine: Real, taps: Real, every: int, out: Real) -> None:
    """One in `every` samples of rows (r, steps), each the sum of the steps from there on by `taps`, into (r, n)."""
    for row in range(out.shape[0]):
        for k in range(out.shape[1]):
            total = 0.0
            for j in range(taps.shape[0]):
                total += taps[j] * fine[row, k * every + j]
            out[row, k] = total


@machine_code
def filter_rows(fine: Real, taps: Real, out: Real) -> None:
    """Every sample of rows (r, steps), each the sum of the steps from there on by `taps`, into (r, n)."""
    count, odd = out.shape[1], taps.shape[0] % 4
    for row in range(out.shape[0]):
        # As many at once as stay near the processor.
        for begin in range(0, count, BLOCK):
            own = out[row, begin : begin + BLOCK]
            own[:] = 0.0
            for j in range(odd):
                f = fine[row, begin + j :]
                for i in range(len(own)):
                    own[i] += taps[j] * f[i]
            for j in range(odd, taps.shape[0], 4):
                a, b, c, d = taps[j], taps[j + 1], taps[j + 2], taps[j + 3]
                f = fine[row, begin + j :]
                for i in range(len(own)):
                    own[i] += a * f[i] + b * f[i + 1] + c * f[i + 2] + d * f[i + 3]
