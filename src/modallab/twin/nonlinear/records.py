"""What an element adds to the motion of the modes in a record: a hit, or a sine from its start on."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import firwin

from modallab.twin.elements import shape_rows
from modallab.twin.nonlinear.element import Coupling, Law
from modallab.twin.structure import Modes

Array = NDArray[np.float64]
Complex = NDArray[np.complexfloating[Any, Any]]

PER_PERIOD = 36
"""Steps a period of a sine, where there may be as many."""
HIT_STEPS = 8
"""Steps a sample of a hit."""
LEAST = {Law.CUBIC: 2, Law.DRAG: 1}
"""Steps a sample of a sine at least, where a law is smooth; 4 otherwise."""
MOST = 8
"""Steps a sample of a sine at most."""
REACH = 12
"""Samples to either side of the filter that keeps what rings above the band from folding back into it."""
SWIFT = 1.25
"""Radians in a step from which a mode follows the forces at once: an element that is stiff beside it would not settle
where its own oscillation is stepped over."""


@dataclass(frozen=True, eq=False, slots=True)
class Added:
    """What an element adds to a record, before the chain.

    Attributes:
        modes: (kept, n) complex motion of the first modes; those beyond follow the force at once.
        force: (n, m) of its channels, N.
    """

    modes: Complex
    force: Array


def in_hit(modes: Modes, own: Coupling, pulse: Array, first: int, n: int, dt: float, x_m: float) -> Added:
    """What it adds to a hit.

    Args:
        modes: of the linear beam.
        own: the element on these modes.
        pulse: (m,) force in N about the hit.
        first: sample at which the pulse begins.
        n: samples of the record.
        dt: s between them.
        x_m: place of the hit.
    """
    begin = max(0, first - 32)
    record = np.zeros(n)
    record[first : first + len(pulse)] = pulse[: n - first]
    spectrum = np.fft.rfft(record)
    fine = np.asarray(np.fft.irfft(spectrum, n * HIT_STEPS) * HIT_STEPS, dtype=np.float64)
    still_after = np.zeros(REACH * HIT_STEPS)
    force = np.concatenate([fine[begin * HIT_STEPS :], still_after])
    stepped = _stepped(modes, own, force, HIT_STEPS, 0, n - begin, dt, x_m)
    before = np.zeros((len(stepped.modes), begin), dtype=np.complex128)
    still = np.zeros((begin, stepped.force.shape[1]))
    return Added(np.concatenate([before, stepped.modes], axis=1), np.concatenate([still, stepped.force]))


def in_sine(
    modes: Modes,
    own: Coupling,
    amplitude_n: complex,
    frequency_hz: float,
    n: int,
    dt: float,
    x_m: float,
    history_s: float,
    ramp_s: float,
    cosine: bool,
) -> Added:
    """What it adds to a sine block that began `history_s` before, rising for `ramp_s` from rest."""
    every = int(np.clip(np.ceil(PER_PERIOD * frequency_hz * dt), LEAST.get(own.law, 4), MOST))
    h = dt / every
    skip = round(history_s / h)
    t = (np.arange(skip + (n - 1 + REACH) * every + 1) - skip) * h
    rise = np.clip((t + history_s) / max(ramp_s, 1e-6), 0.0, 1.0)
    if cosine:
        rise = (1 - np.cos(np.pi * rise)) / 2
    force = rise * np.cos(2 * np.pi * frequency_hz * t + np.angle(amplitude_n))
    # Straight lines between the steps of a sine are that much smaller than the sine.
    force *= abs(amplitude_n) / np.sinc(frequency_hz * h) ** 2
    return _stepped(modes, own, np.asarray(force, dtype=np.float64), every, skip, n, dt, x_m)


def acceleration(modes: Modes, own: Coupling, psi: Complex, added: Added, dt: float) -> Array:
    """(points, n) m/s^2 that it adds where the modes' shapes are `psi` (points, p)."""
    p = len(added.modes)
    straight = 2 * np.real((psi[:, :p] * modes.poles[:p]) @ own.shapes[:, :p].T)
    total = 2 * np.real((psi[:, :p] * modes.poles[:p] ** 2) @ added.modes) + straight @ added.force.T
    # What follows at once: its static motion, twice differentiated.
    static = -2 * np.real((psi[:, p:] / modes.poles[p:]) @ own.shapes[:, p:].T)
    bent = np.gradient(np.gradient(added.force, dt, axis=0), dt, axis=0)
    return total + static @ bent.T


def _stepped(modes: Modes, own: Coupling, force: Array, every: int, skip: int, n: int, dt: float, x_m: float) -> Added:
    # Loaded where it is needed: what is linear needs no compiled loop.
    from modallab.twin.nonlinear import stepping

    h, kept = dt / every, int(np.count_nonzero(np.abs(modes.poles) * dt / every < SWIFT))
    poles, shapes, columns = modes.poles[:kept], own.shapes[:, :kept], modes.columns[:, :kept]
    x = poles * h
    first = np.expm1(x) / x
    second = (np.expm1(x) - x) / x**2
    decay, alpha, beta = _split(np.exp(x)), _split(h * (first - second)), _split(h * second)
    load = shape_rows(x_m, modes.length_m)[0]
    drive = _split(load @ columns)
    swift = np.real(-2 * modes.columns[:, kept:] / modes.poles[kept:] @ modes.columns[:, kept:].T)
    static = own.rows[1:] @ (modes.out_of_band + swift) @ own.rows[1:].T
    direct = own.rows @ ((modes.out_of_band + swift) @ load)
    # Every step about the record is kept, and what rings above its band taken out as a converter does.
    before = min(skip, REACH * every)
    count, kept_steps = len(shapes), len(force) - skip + before
    out, pushed = np.zeros((2, len(poles), kept_steps)), np.zeros((kept_steps, count))
    if own.law in (Law.CUBIC, Law.FRICTION, Law.PLAY):
        numbers, row = np.array((*own.numbers, 0.0, 0.0)[:3]), pushed[:, 0].copy()
        seen, stiff, straight = _split(shapes[0]), float(static[0, 0]), float(direct[1])
        stepping.step_one(
            int(own.law), numbers, decay, alpha, beta, seen, drive, stiff, straight, force, skip - before, out, row
        )
        pushed[:, 0] = row
    else:
        felt = np.concatenate([own.switch[None, :kept], shapes * (poles if own.law is Law.DRAG else 1.0)])
        whole = np.eye(count) - static - 2 * np.real((shapes * (h * second)) @ shapes.T)
        opened = np.asarray(np.linalg.inv(whole) if own.law is Law.CRACK else whole, dtype=np.float64)
        direct = direct if own.law is Law.CRACK else np.zeros_like(direct)
        numbers = np.array(own.numbers)
        stepping.step_many(
            int(own.law),
            numbers,
            opened,
            decay,
            alpha,
            beta,
            np.ascontiguousarray(_split(shapes).transpose(1, 0, 2)),
            np.ascontiguousarray(_split(felt).transpose(1, 0, 2)),
            drive,
            direct,
            force,
            skip - before,
            out,
            pushed,
        )
    # Motion that grew without bound stays infinite: no product with 1j may make it undefined.
    motion = _in_band(out, every, before, n)
    added = motion[0].astype(complex)
    added.imag = motion[1]
    return Added(added, np.ascontiguousarray(_in_band(pushed.T, every, before, n).T))


def _in_band(fine: Array, every: int, before: int, n: int) -> Array:
    """(..., n) of (..., steps) every so many steps, `before` steps on, without what would fold back."""
    if every == 1:
        return fine[..., before : before + n]
    from modallab.twin.nonlinear import stepping

    first, needed = REACH * every - before, (n - 1 + 2 * REACH) * every + 1
    some = min(fine.shape[-1], needed - first)
    padded = np.zeros((*fine.shape[:-1], needed))
    padded[..., first : first + some] = fine[..., :some]
    found = np.empty((padded[..., 0].size, n))
    stepping.decimate(padded.reshape(-1, needed), _taps(every), every, found)
    return found.reshape(*fine.shape[:-1], n)


@lru_cache(maxsize=16)
def _taps(every: int) -> Array:
    return np.asarray(firwin(2 * REACH * every + 1, 1 / every, window=("kaiser", 8.0)), dtype=np.float64)


def _split(values: Complex) -> Array:
    """(2, ...) real and imaginary part."""
    return np.stack([np.real(values), np.imag(values)]).astype(np.float64)
