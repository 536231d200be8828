"""The beam in time, its modes driven by a known force and by that of one nonlinear element.

Each mode is stepped exactly under forces that run straight from one step to the next (first-order hold), and the
element's force is found at the end of each step from the motion it itself changes there (as Newmark's implicit rule, J.
Eng. Mech. Div. ASCE 85 (1959), 67, on exact modes). What the forces of a step do at its end is taken out of the state
of the modes, so that nothing but the law itself stands between one force and the next: a processor steps the modes
while it solves the law.

The force of a spring that bends, or of an open crack, does not run straight within a step: by its curvature over the
last steps it has more than its straight line, which is added as an impulse, half at each end of the step. A stiff
contact must do without: an impulse that lags by a step would make it swing.

Complex numbers are pairs (2, p) of real and imaginary parts with p a multiple of LANES, which compilers turn into
vector instructions. The laws stand in this file as well: compiled code is kept on the disk by the file it stands in,
and would not notice that a law in another one has changed.
"""

import numpy as np

from modallab.core.arrays import Real
from modallab.twin.nonlinear.sampling import machine_code

CUBIC, PLAY, CRACK = 0, 2, 3
CURVED = 12.0
"""Mean of a parabola over its straight line on a step, of its second difference."""
STRAIGHT = 3
"""Steps for which a crack must be open to have a curvature."""
LANES = 8
"""Modes come in so many: the widest vectors of today's processors."""
NEARBY = 0.02
"""Relative change of a power up to which four terms give it to a part in a hundred million."""
THIRD = 1.0 / 3.0
YIELDS = 0.5
"""Share of the yielding that stops when the motion turns round: what turns back is as stiff as what never slipped."""


@machine_code
def cubic_spring_motion(k3: float, free: float, d: float, guess: float) -> float:
    """Motion at a cubic spring, where without it it is `free` and a unit of force adds `d` to it; from a guess."""
    w = guess
    for _ in range(30):
        step = (w + d * k3 * w * w * w - free) / (1.0 + 3.0 * d * k3 * w * w)
        w -= step
        # The next step would be as small as the square of this one.
        if abs(step) <= 1e-8 * abs(w):
            break
    return w


@machine_code
def clearance_force(stiffness: float, gap: float, free: float, d: float) -> float:
    """Force of a contact beyond a gap."""
    if abs(free) <= gap:
        return 0.0
    edge = gap if free > 0 else -gap
    return -stiffness * (free - edge) / (1.0 + d * stiffness)


@machine_code
def slider_force(stiffness: float, limit: float, free: float, d: float, stuck: float) -> tuple[float, float]:
    """Force of a spring in series with a slider that last stood at `stuck`, and where it stands then (Jenkins)."""
    pull = stiffness * (free - stuck) / (1.0 + d * stiffness)
    if abs(pull) <= limit:
        return -pull, stuck
    most = limit if pull > 0 else -limit
    return -most, free - d * most - most / stiffness


@machine_code
def hysteresis_force(
    stiffness: float, limit: float, sharpness: float, free: float, d: float, last: float, pull: float, guess: float
) -> float:
    """Pull of a joint that yields little by little, from where it last stood and pulled (Bouc-Wen, midpoint rule)."""
    found, near, power = guess, 0.0, 0.0
    for _ in range(12):
        middle = 0.5 * (pull + found)
        moved = free - d * found - last
        slope, steeper = stiffness, 0.0
        share = 1.0 if middle * moved > 0 else 1.0 - 2.0 * YIELDS
        if share != 0.0:
            off = middle / near - 1.0 if near != 0.0 else 1.0
            if abs(off) * sharpness > NEARBY:
                near, off = middle, 0.0
                power = (abs(middle) / limit) ** sharpness
            # A power is dear; about one that is known the first terms of its binomial series do.
            used = (
                share
                * power
                * (
                    1.0
                    + sharpness * off * (1.0 + 0.5 * (sharpness - 1.0) * off * (1.0 + THIRD * (sharpness - 2.0) * off))
                )
            )
            slope = stiffness * (1.0 - used)
            steeper = 0.5 * sharpness * stiffness * used * moved / middle
        new = found - (found - pull - slope * moved) / (1.0 + slope * d + steeper)
        new = min(max(new, -limit), limit)
        # The next step would be as small as the square of this one.
        done = abs(new - found) <= 1e-5 * limit
        found = new
        if done:
            break
    return found


@machine_code
def force_of_law(
    law: int, a: float, b: float, c: float, free: float, d: float, m0: float, m1: float, m2: float
) -> tuple[float, float, float, float]:
    """Force of a law of one motion, and what it remembers of the last two steps."""
    if law == CUBIC:
        w = cubic_spring_motion(a, free, d, 2.0 * m0 - m1)
        return -a * w * w * w, w, m0, 0.0
    if law == PLAY:
        g = clearance_force(a, b, free, d)
        return g, free + d * g, 0.0, 0.0
    if c == 0.0:
        g, stuck = slider_force(a, b, free, d, m0)
        return g, stuck, 0.0, 0.0
    pull = hysteresis_force(a, b, c, free, d, m0, m1, min(max(2.0 * m1 - m2, -b), b))
    return -pull, free - d * pull, pull, m1


@machine_code
def step_one(
    law: int,
    numbers: Real,
    decay: Real,
    push: Real,
    drive: Real,
    ahead: Real,
    kick: Real,
    own: Real,
    known: Real,
    force: Real,
    skip: int,
    begun: Real,
    pushed: Real,
    excess: Real,
) -> None:
    """Step a law of one motion.

    The state of the modes is what the forces up to a step leave at the end of the next one.

    Args:
        law: CUBIC, PLAY, or anything else for friction.
        numbers: (3,) of the law.
        decay: (2, p) exp(pole dt).
        push: (2, p) what a unit of the element's force adds to the state.
        drive: (2, p) what a unit of the known force adds to it.
        ahead: (2, p) weights by which the motion at the element after a further step follows from the state.
        kick: (2, p) what a force of 1 N over a step, as impulses at both of its ends, adds to the state one step on.
        own: (3,) m/N at the element of its own force at the same time and one step after, and of such impulses one
            step after.
        known: (2,) m/N there of the known force at the same time and one step after.
        force: (steps,) N.
        skip: steps before the first that is kept.
        begun: (2, p) state before the first step that is kept.
        pushed: (steps kept,) force of the element.
        excess: (steps kept,) mean force that it has more than its straight line over each step.
    """
    decay_r, decay_i, push_r, push_i = decay[0], decay[1], push[0], push[1]
    drive_r, drive_i, ahead_r, ahead_i = drive[0], drive[1], ahead[0], ahead[1]
    kick_r, kick_i = kick[0], kick[1]
    p = len(decay_r)
    real, imag = np.zeros(p), np.zeros(p)
    a, b, c = numbers[0], numbers[1], numbers[2]
    d, after, later, now, before = own[0], own[1], own[2], known[0], known[1]
    m0, m1, m2 = 0.0, 0.0, 0.0
    g, f, rest = 0.0, 0.0, 0.0
    g0, bend = 0.0, 0.0
    for n in range(force.shape[0]):
        last, f = f, force[n]
        free = rest + now * f + before * last + after * g + later * bend
        new, m0, m1, m2 = force_of_law(law, a, b, c, free, d, m0, m1, m2)
        rest = 0.0
        for k in range(p):
            r, i = decay_r[k], decay_i[k]
            xr = r * real[k] - i * imag[k] + push_r[k] * g + drive_r[k] * last + kick_r[k] * bend
            xi = r * imag[k] + i * real[k] + push_i[k] * g + drive_i[k] * last + kick_i[k] * bend
            real[k], imag[k] = xr, xi
            rest += ahead_r[k] * xr - ahead_i[k] * xi
        if n == skip:
            begun[0], begun[1] = real, imag
        bend = -(new - 2.0 * g + g0) / CURVED if law == CUBIC else 0.0
        if n >= skip:
            pushed[n - skip] = new
            excess[n - skip] = bend
        g0 = g
        g = new


@machine_code
def element_motion(felt: Real, real: Real, imag: Real) -> float:
    """What an element feels of the modes by one of its motions."""
    felt_r, felt_i = felt[0], felt[1]
    total = 0.0
    for k in range(len(real)):
        total += felt_r[k] * real[k] - felt_i[k] * imag[k]
    return total


@machine_code
def crack_opening(opened: Real, felt: Real, real: Real, imag: Real, now: Real, f: float, found: Real, g: Real) -> bool:
    """Whether a crack is open, which it is where the first motion is positive; its forces into `g`, zero if closed."""
    open_now = element_motion(felt[0], real, imag) + now[0] * f > 0
    if open_now:
        for j in range(len(g)):
            found[j] = element_motion(felt[1 + j], real, imag) + now[1 + j] * f
    for j in range(len(g)):
        g[j] = 0.0
        if open_now:
            for other in range(len(g)):
                g[j] += opened[j, other] * found[other]
    return open_now


@machine_code
def drag_forces(
    numbers: Real, stays: Real, felt: Real, real: Real, imag: Real, now: Real, f: float, found: Real, g: Real
) -> None:
    """Forces of a drag, which change so little in a step that it feels those before, into `g`."""
    for j in range(len(found)):
        found[j] = element_motion(felt[1 + j], real, imag) + now[1 + j] * f
        for other in range(len(found)):
            found[j] += stays[1 + j, other] * g[other]
    for j in range(len(found)):
        g[j] = -numbers[j] * abs(found[j]) * found[j]


@machine_code
def add_shapes(shapes: Real, weights: Real, real: Real, imag: Real) -> None:
    """Add shapes (m, 2, p), each by its weight (m,), to real and imaginary parts (p,)."""
    for j in range(len(weights)):
        shape_r, shape_i, own = shapes[j, 0], shapes[j, 1], weights[j]
        if own != 0.0:
            for k in range(len(real)):
                real[k] += shape_r[k] * own
                imag[k] += shape_i[k] * own


@machine_code
def step_modes(decay: Real, push: Real, g: Real, real: Real, imag: Real) -> None:
    """Take a state of the modes one step on, under the forces of that step."""
    decay_r, decay_i = decay[0], decay[1]
    for k in range(len(real)):
        xr = decay_r[k] * real[k] - decay_i[k] * imag[k]
        imag[k] = decay_r[k] * imag[k] + decay_i[k] * real[k]
        real[k] = xr
    add_shapes(push, g, real, imag)


@machine_code
def step_many(
    law: int,
    numbers: Real,
    opened: Real,
    decay: Real,
    push: Real,
    felt: Real,
    now: Real,
    stays: Real,
    force: Real,
    skip: int,
    begun: Real,
    pushed: Real,
    excess: Real,
) -> None:
    """Step a law of several motions: a crack, or a drag.

    Args:
        law: CRACK, or anything else for a drag.
        numbers: (m,) of a drag, N s^2/m^2 at each place.
        opened: (m, m) motion of an open crack per motion without its force.
        decay: (2, p) exp(pole dt).
        push: (2 m + 1, 2, p) what a unit of each force, of the known force, and of what each has more than its
            straight line, adds to the state; as in `step_one`.
        felt: (1 + m, 2, p) for a crack the motion that opens it, then those of its channels; for a drag velocities.
        now: (1 + m,) what is felt of the known force at the same time.
        stays: (1 + m, m) what a drag feels of its forces if they stay: they change little in a step.
        force: (steps,) N.
        skip: steps before the first that is kept.
        begun: (2, p) state before the first step that is kept.
        pushed: (steps kept, m) force of the element.
        excess: (steps kept, m) mean force that it has more than its straight line over each step.
    """
    p, m = decay.shape[1], pushed.shape[1]
    real, imag = np.zeros(p), np.zeros(p)
    acting, found = np.zeros(2 * m + 1), np.zeros(m)
    g0, g1, g2, since = np.zeros(m), np.zeros(m), np.zeros(m), 0
    for n in range(force.shape[0]):
        step_modes(decay, push, acting, real, imag)
        if n == skip:
            begun[0], begun[1] = real, imag
        if law == CRACK:
            since = since + 1 if crack_opening(opened, felt, real, imag, now, force[n], found, g2) else 0
            for j in range(m):
                acting[j] = g2[j]
                acting[m + 1 + j] = -(g2[j] - 2.0 * g1[j] + g0[j]) / CURVED if since >= STRAIGHT else 0.0
            g0, g1, g2 = g1, g2, g0
        else:
            drag_forces(numbers, stays, felt, real, imag, now, force[n], found, acting)
        acting[m] = force[n]
        if n >= skip:
            for j in range(m):
                pushed[n - skip, j], excess[n - skip, j] = acting[j], acting[m + 1 + j]


@machine_code
def modes_under_forces(decay: Real, push: Real, late: Real, begun: Real, forces: Real, out: Real) -> None:
    """The modes under known forces.

    Args:
        decay: (2, p) exp(pole dt).
        push: (m, 2, p) what a unit of each force adds to the state, as in `step_one`.
        late: (m, 2, p) what it adds to the modes at once.
        begun: (2, p) state before the first step.
        forces: (steps, m) N.
        out: (steps, 2, p) of the modes' motion.
    """
    real, imag = begun[0].copy(), begun[1].copy()
    for n in range(forces.shape[0]):
        now_r, now_i, own = out[n, 0], out[n, 1], forces[n]
        for k in range(len(real)):
            now_r[k], now_i[k] = real[k], imag[k]
        add_shapes(late, own, now_r, now_i)
        step_modes(decay, push, own, real, imag)
