"""The stepping loop: modes driven by known forces and by forces that depend on the motion.

Between steps each mode is exact. The known forces run as the interpolation of `hold`; those that depend on the motion
run straight from one step to the next, and their value at the step's end is solved for together with the motion there:
u = u_free + B g(u).

Complex numbers stand as rows of real and imaginary parts, and arrays are indexed rather than cut into views: the
compiled loop is more than half as fast again for it.
"""

from collections.abc import Callable
from importlib.util import find_spec
from math import copysign
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real

_Function = TypeVar("_Function", bound=Callable[..., Any])

AVAILABLE = find_spec("numba") is not None
"""Whether loops are compiled."""


def machine_code(function: _Function) -> _Function:
    """The function as machine code, kept on disk for the next process."""
    if not AVAILABLE:
        return function
    # Some install no numba.
    import numba

    return numba.njit(cache=True)(function)  # pyrefly: ignore[bad-return]  # it is called as the function is


Integers = NDArray[np.int64]

CUBIC, FRICTION, PLAY, CRACK = 0, 1, 2, 3
"""Kinds of elements."""

_PASSES = 12
_CLOSE = 1e-10


@machine_code
def _cubic(free: float, b: float, k3: float) -> float:
    """The force -k3 u^3 where u + b k3 u^3 = free, by Newton from the side on which it never overshoots."""
    u = free
    for _ in range(60):
        step = (u + b * k3 * u**3 - free) / (1 + 3 * b * k3 * u * u)
        u -= step
        if abs(step) <= 1e-15 * abs(u):
            break
    return -k3 * u**3


@machine_code
def _friction(free: float, b: float, k: float, m: float, memory: Real, e: int) -> float:
    """What a slider of stiffness k and limit m leaves of k u; `memory` holds its last displacement and moment."""
    g = k * memory[e, 0] - memory[e, 1]
    u = free + b * g
    moment = memory[e, 1] + k * (u - memory[e, 0])
    if abs(moment) > m:
        moment = copysign(m, moment)
        u = (free - b * moment) / (1 - b * k)
        g = k * u - moment
    memory[e, 2], memory[e, 3] = u, moment
    return g


@machine_code
def _play(free: float, b: float, k: float, gap: float) -> float:
    """What a free play leaves out of k u: all of it within the gap."""
    u = free / (1 - b * k)
    return k * u if abs(u) <= gap else copysign(k * gap, free)


@machine_code
def _crack(own: Real, crack: Real, e: int, first: int, last: int, g: Real) -> None:
    """The bend that opens with a positive moment: what its compliance makes of the moment, or nothing."""
    moment = 0.0
    for i in range(first, last):
        moment += crack[e, -1, i - first] * own[i]
    for i in range(first, last):
        g[i] = 0.0
        if moment > 0:
            for j in range(first, last):
                g[i] += crack[e, i - first, j - first] * own[j]


@machine_code
def _solve(
    free: Real,
    own: Real,
    b: Real,
    g: Real,
    kinds: Integers,
    firsts: Integers,
    numbers: Real,
    memory: Real,
    crack: Real,
) -> None:
    """All elements' forces at the substep's end, one after the other until none changes."""
    for _ in range(_PASSES):
        change, size = 0.0, 0.0
        for e in range(len(kinds)):
            i, last = int(firsts[e]), int(firsts[e + 1])
            _others(own, free, b, g, i, last)
            before, one, two = g[i], numbers[e, 0], numbers[e, 1]
            if kinds[e] == CUBIC:
                g[i] = _cubic(own[i], b[i, i], one)
            elif kinds[e] == FRICTION:
                g[i] = _friction(own[i], b[i, i], one, two, memory, e)
            elif kinds[e] == PLAY:
                g[i] = _play(own[i], b[i, i], one, two)
            else:
                _crack(own, crack, e, i, last, g)
            change, size = max(change, abs(g[i] - before)), max(size, abs(g[i]))
        if len(kinds) == 1 or change <= _CLOSE * size:
            break
    for e in range(len(kinds)):
        memory[e, 0], memory[e, 1] = memory[e, 2], memory[e, 3]


@machine_code
def _others(own: Real, free: Real, b: Real, g: Real, first: int, last: int) -> None:
    """What an element's motions would be with the other elements' forces, but without its own."""
    for i in range(first, last):
        own[i] = free[i]
        for j in range(len(free)):
            if j < first or j >= last:
                own[i] += b[i, j] * g[j]


@machine_code
def _seen(row: int, seen: Real, z: Real) -> float:
    """Real part of a row of weights times z, or times as much of it as there are weights."""
    total = 0.0
    for r in range(seen.shape[2]):
        total += seen[row, 0, r] * z[0, r] - seen[row, 1, r] * z[1, r]
    return total


@machine_code
def _add(z: Real, weights: Real, g: Real) -> None:
    """What the fed-back forces put into each mode."""
    for c in range(len(g)):
        force = g[c]
        if force != 0.0:
            for r in range(z.shape[1]):
                z[0, r] += weights[c, 0, r] * force
                z[1, r] += weights[c, 1, r] * force


@machine_code
def _turn(z: Real, decay: Real) -> None:
    """One substep of free motion."""
    for r in range(z.shape[1]):
        real = decay[0, r] * z[0, r] - decay[1, r] * z[1, r]
        z[1, r] = decay[0, r] * z[1, r] + decay[1, r] * z[0, r]
        z[0, r] = real


@machine_code
def _drive(z: Real, taps: Real, s: int, forces: Real, k: int, into: Real, held: Real) -> None:
    """What the known forces, by their samples about a substep, put into each mode."""
    modes = z.shape[1]
    for d in range(len(forces)):
        idle = True
        for t in range(taps.shape[1]):
            idle = idle and forces[d, k + t] == 0.0
        if idle:
            continue
        for r in range(modes):
            held[0, r] = 0.0
            held[1, r] = 0.0
        for t in range(taps.shape[1]):
            f = forces[d, k + t]
            for r in range(modes):
                held[0, r] += taps[s, t, 0, r] * f
                held[1, r] += taps[s, t, 1, r] * f
        for r in range(modes):
            z[0, r] += into[d, 0, r] * held[0, r] - into[d, 1, r] * held[1, r]
            z[1, r] += into[d, 0, r] * held[1, r] + into[d, 1, r] * held[0, r]


@machine_code
def _drag(z: Real, seen: Real, put: Real, local: int, g: Real) -> None:
    """The forces g = -put |v| v on some modes, from the speeds v of some points."""
    for c in range(local, len(g)):
        g[c] = 0.0
    for q in range(len(seen)):
        v = _seen(q, seen, z)
        pull = abs(v) * v
        for c in range(local, len(g)):
            g[c] -= put[q, c - local] * pull


@machine_code
def step_in_time(
    z: Real,
    g: Real,
    memory: Real,
    forces: Real,
    into: Real,
    decay: Real,
    taps: Real,
    begin: Real,
    end: Real,
    seen: Real,
    b: Real,
    direct: Real,
    kinds: Integers,
    firsts: Integers,
    numbers: Real,
    crack: Real,
    drag_seen: Real,
    drag_put: Real,
    reach: int,
    out: Real,
) -> None:
    """Step z, g and the elements' memory through as many internal samples as `out` has columns.

    Args:
        z: (2, modes) state, changed in place.
        g: (channels,) forces of the elements and then of the drag at the state's time, changed in place.
        memory: (elements, 4) of sliders, changed in place.
        forces: (drives, samples + taps - 1) known forces, the first `reach` samples before the state's time.
        into: (drives, 2, modes) what a known force puts into each mode.
        decay: (2, modes) of one substep.
        taps: (substeps, taps, 2, modes) of the known forces.
        begin, end: (channels, 2, modes) what a channel's force at a substep's beginning and end puts into each mode.
        seen: (local channels, 2, modes) a channel's displacement is the real part of seen z, plus
        b: (local channels, local channels) times the forces at the same time, and
        direct: (local channels, drives) times the known forces.
        kinds, firsts, numbers, crack: the elements.
        drag_seen, drag_put: (points, 2, modes), (points, drag channels) of the drag.
        reach: see `forces`.
        out: (channels, samples) forces at each sample after the state's time.
    """
    substeps, local = taps.shape[0], len(seen)
    free, own, held = np.empty(local), np.empty(local), np.empty_like(z)
    for k in range(out.shape[1]):
        for s in range(substeps):
            _turn(z, decay)
            _drive(z, taps, s, forces, k, into, held)
            _add(z, begin, g)
            share = (s + 1) / substeps
            for c in range(local):
                free[c] = _seen(c, seen, z)
                for d in range(len(forces)):
                    at = (1 - share) * forces[d, k + reach] + share * forces[d, k + reach + 1]
                    free[c] += direct[c, d] * at
            _solve(free, own, b, g, kinds, firsts, numbers, memory, crack)
            _drag(z, drag_seen, drag_put, local, g)
            _add(z, end, g)
        for c in range(len(g)):
            out[c, k] = g[c]
