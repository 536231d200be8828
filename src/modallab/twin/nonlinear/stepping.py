"""The beam in time, its modes driven by a known force and by that of one nonlinear element.

Each mode is stepped exactly under forces that run straight from one step to the next (first-order hold), and the
element's force is found at the end of each step from the motion it itself changes there (as Newmark's implicit rule, J.
Eng. Mech. Div. ASCE 85 (1959), 67, on exact modes). The motion that the known force alone makes and what the element
adds are kept apart: only the second is needed, the first the twin knows in closed form.

Complex numbers are pairs (2, ...) of real and imaginary parts, which compilers turn into vector instructions.
"""

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CUBIC, PLAY, CRACK = 0, 2, 3
YIELDS = 0.5
"""Share of the yielding that stops when the motion turns round: what turns back is as stiff as what never slipped."""

_Function = TypeVar("_Function", bound=Callable[..., Any])


def _compiled(function: _Function) -> _Function:
    # Sums may be taken in another order; nothing else of IEEE 754 is given up.
    return cast("_Function", numba.njit(cache=True, nogil=True, fastmath={"contract", "reassoc", "nsz"})(function))


@_compiled
def cubic(k3: float, free: float, d: float) -> float:
    """Force of a cubic spring where the motion without it is `free` and a unit of force adds `d` to it."""
    w = free
    for _ in range(30):
        step = (w + d * k3 * w * w * w - free) / (1.0 + 3.0 * d * k3 * w * w)
        w -= step
        if abs(step) <= 1e-14 * abs(w):
            break
    return -k3 * w * w * w


@_compiled
def play(stiffness: float, gap: float, free: float, d: float) -> float:
    """Force of a contact beyond a gap."""
    if abs(free) <= gap:
        return 0.0
    edge = gap if free > 0 else -gap
    return -stiffness * (free - edge) / (1.0 + d * stiffness)


@_compiled
def slider(stiffness: float, limit: float, free: float, d: float, stuck: float) -> tuple[float, float]:
    """Force of a spring in series with a slider that last stood at `stuck`, and where it stands then (Jenkins)."""
    pull = stiffness * (free - stuck) / (1.0 + d * stiffness)
    if abs(pull) <= limit:
        return -pull, stuck
    most = limit if pull > 0 else -limit
    return -most, free - d * most - most / stiffness


@_compiled
def hysteresis(
    stiffness: float, limit: float, sharpness: float, free: float, d: float, last: float, pull: float
) -> float:
    """Pull of a joint that yields little by little, from where it last stood and pulled (Bouc-Wen, midpoint rule)."""
    found = pull
    for _ in range(12):
        middle = 0.5 * (pull + found)
        moved = free - d * found - last
        share = 1.0 if middle * moved > 0 else 1.0 - 2.0 * YIELDS
        used = (abs(middle) / limit) ** sharpness
        slope = stiffness * (1.0 - share * used)
        steeper = 0.5 * sharpness * stiffness * share * used * moved / middle if used > 0 else 0.0
        new = found - (found - pull - slope * moved) / (1.0 + slope * d + steeper)
        new = min(max(new, -limit), limit)
        done = abs(new - found) <= 1e-8 * limit
        found = new
        if done:
            break
    return found


@_compiled
def weighted(weights: Array, shapes: Array) -> Array:
    """(2, p) product of two rows of complex numbers."""
    real = weights[0] * shapes[0] - weights[1] * shapes[1]
    imag = weights[0] * shapes[1] + weights[1] * shapes[0]
    both = np.empty((2, len(real)))
    both[0], both[1] = real, imag
    return both


@_compiled
def step_one(
    law: int,
    numbers: Array,
    decay: Array,
    alpha: Array,
    beta: Array,
    seen: Array,
    drive: Array,
    static: float,
    direct: float,
    force: Array,
    skip: int,
    out: Array,
    pushed: Array,
) -> None:
    """Step a law of one motion.

    Args:
        law: CUBIC, PLAY, or anything else for friction.
        numbers: (3,) of the law.
        decay: (2, p) exp(pole dt).
        alpha: (2, p) weight of the force at the start of a step.
        beta: (2, p) weight at its end.
        seen: (2, p) shape at the element.
        drive: (2, p) shape at the known force.
        static: m/N at the element of what follows at once.
        direct: m/N there of what follows the known force at once.
        force: (steps,) N.
        skip: steps before the first that is kept.
        out: (2, p, steps kept) of the modes' motion that the element adds.
        pushed: (steps kept,) force of the element.
    """
    p = decay.shape[1]
    x, z = np.zeros((2, p)), np.zeros((2, p))
    late, early = weighted(beta, seen), weighted(alpha, seen)
    late_f, early_f = weighted(beta, drive), weighted(alpha, drive)
    d = static
    for k in range(p):
        d += 2.0 * (seen[0, k] * late[0, k] - seen[1, k] * late[1, k])
    g, stuck, before = 0.0, 0.0, 0.0
    for n in range(force.shape[0]):
        f = force[n]
        free = 0.5 * direct * f
        for k in range(p):
            r, i = decay[0, k], decay[1, k]
            ar = r * x[0, k] - i * x[1, k] + early_f[0, k] * before + late_f[0, k] * f
            ai = r * x[1, k] + i * x[0, k] + early_f[1, k] * before + late_f[1, k] * f
            br = r * z[0, k] - i * z[1, k] + early[0, k] * g
            bi = r * z[1, k] + i * z[0, k] + early[1, k] * g
            x[0, k], x[1, k], z[0, k], z[1, k] = ar, ai, br, bi
            free += seen[0, k] * (ar + br) - seen[1, k] * (ai + bi)
        if law == CUBIC:
            g = cubic(numbers[0], 2.0 * free, d)
        elif law == PLAY:
            g = play(numbers[0], numbers[1], 2.0 * free, d)
        else:
            if numbers[2] == 0.0:
                g, stuck = slider(numbers[0], numbers[1], 2.0 * free, d, stuck)
            else:
                g = -hysteresis(numbers[0], numbers[1], numbers[2], 2.0 * free, d, stuck, -g)
                stuck = 2.0 * free + d * g
        for k in range(p):
            z[0, k] += late[0, k] * g
            z[1, k] += late[1, k] * g
        before = f
        if n >= skip:
            pushed[n - skip] = g
            out[:, :, n - skip] = z


@_compiled
def motions(felt: Array, direct: Array, f: float, x: Array, z: Array, found: Array) -> None:
    """What an element of several motions feels, into `found`."""
    for j in range(felt.shape[0]):
        total = 0.0
        for k in range(felt.shape[2]):
            total += felt[j, 0, k] * (x[0, k] + z[0, k]) - felt[j, 1, k] * (x[1, k] + z[1, k])
        found[j] = 2.0 * total + direct[j] * f


@_compiled
def answered(law: int, numbers: Array, opened: Array, found: Array, g: Array) -> None:
    """Forces of a crack that opens where the first motion is positive, or of a drag on the others, into `g`."""
    m = g.shape[0]
    for j in range(m):
        g[j] = 0.0
        if law != CRACK:
            g[j] = -numbers[j] * abs(found[1 + j]) * found[1 + j]
        elif found[0] > 0:
            for other in range(m):
                g[j] += opened[j, other] * found[1 + other]


@_compiled
def step_many(
    law: int,
    numbers: Array,
    opened: Array,
    decay: Array,
    alpha: Array,
    beta: Array,
    seen: Array,
    felt: Array,
    drive: Array,
    direct: Array,
    force: Array,
    skip: int,
    out: Array,
    pushed: Array,
) -> None:
    """Step a law of several motions: a crack, or a drag.

    Args:
        law: CRACK, or anything else for a drag.
        numbers: (m,) of a drag, N s^2/m^2 at each place.
        opened: (m, m) motion of an open crack per motion without its force.
        decay: (2, p) exp(pole dt).
        alpha: (2, p) weight of the force at the start of a step.
        beta: (2, p) weight at its end.
        seen: (m, 2, p) shapes at which the forces act.
        felt: (1 + m, 2, p) for a crack the motion that opens it, then those of its channels; for a drag velocities.
        drive: (2, p) shape at the known force.
        direct: (1 + m,) of what follows the known force at once, what is felt of it.
        force: (steps,) N.
        skip: steps before the first that is kept.
        out: (2, p, steps kept) of the modes' motion that the element adds.
        pushed: (steps kept, m) force of the element.
    """
    p, m = decay.shape[1], seen.shape[0]
    x, z, acting = np.zeros((2, p)), np.zeros((2, p)), np.zeros((2, p))
    late_f, early_f = weighted(beta, drive), weighted(alpha, drive)
    g, found = np.zeros(m), np.empty(m + 1)
    # A drag changes little in a step: its motion is felt as if the force stayed.
    ahead = 0.0 if law == CRACK else 1.0
    before = 0.0
    for n in range(force.shape[0]):
        f = force[n]
        for k in range(p):
            r, i, a, b = decay[0, k], decay[1, k], acting[0, k], acting[1, k]
            xr = r * x[0, k] - i * x[1, k] + early_f[0, k] * before + late_f[0, k] * f
            xi = r * x[1, k] + i * x[0, k] + early_f[1, k] * before + late_f[1, k] * f
            cr, ci = alpha[0, k] + ahead * beta[0, k], alpha[1, k] + ahead * beta[1, k]
            zr = r * z[0, k] - i * z[1, k] + cr * a - ci * b
            zi = r * z[1, k] + i * z[0, k] + cr * b + ci * a
            x[0, k], x[1, k], z[0, k], z[1, k] = xr, xi, zr, zi
        motions(felt, direct, f, x, z, found)
        answered(law, numbers, opened, found, g)
        # What was felt ahead of the new force is taken back.
        for k in range(p):
            br, bi = beta[0, k], beta[1, k]
            a, b = ahead * acting[0, k], ahead * acting[1, k]
            z[0, k] -= br * a - bi * b
            z[1, k] -= br * b + bi * a
            acting[0, k], acting[1, k] = 0.0, 0.0
        for j in range(m):
            push = g[j]
            if push != 0.0:
                for k in range(p):
                    acting[0, k] += push * seen[j, 0, k]
                    acting[1, k] += push * seen[j, 1, k]
        for k in range(p):
            br, bi = beta[0, k], beta[1, k]
            z[0, k] += br * acting[0, k] - bi * acting[1, k]
            z[1, k] += br * acting[1, k] + bi * acting[0, k]
        before = f
        if n >= skip:
            pushed[n - skip] = g
            out[:, :, n - skip] = z


@_compiled
def decimate(fine: Array, taps: Array, every: int, out: Array) -> None:
    """One in `every` samples of rows (r, steps), each the sum of the steps from there on by `taps`, into (r, n)."""
    for row in range(out.shape[0]):
        for k in range(out.shape[1]):
            total = 0.0
            for j in range(taps.shape[0]):
                total += taps[j] * fine[row, k * every + j]
            out[row, k] = total
