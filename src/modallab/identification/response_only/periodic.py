"""Periodic excitation in responses alone: a machine's speed and its orders, mains.

What a mode answers to a random force is a complex Gaussian process. Its phase jumps at will over stretches longer than
its decay. From one stretch to the next its amplitude moves as far along its phase as across it. A line's phase goes
on; where the speed wanders, the amplitude moves across only.
Both are tested at the line, stretch by stretch. A mode that rings as long as the whole record
cannot be distinguished from a line.
For the phase, the coherent share of N complex Gaussian numbers exceeds c by chance (1 - c)^(N - 1). For the amplitude,
given that of the stretch before, both parts of it have one variance: their ratio is distributed as F.
"""

import cmath
from collections.abc import Sequence

import numpy as np
from scipy.special import fdtr

from modallab.core.arrays import Complex128, Real

STRETCHES = 16
"""Of a record, at whose lines a steady phase is looked for."""
LEAST_STRETCHES, MOST_STRETCHES = 6, 256
FINE_STRETCHES, IN_A_DECAY = 64, 4.0
"""So short is a stretch, in a record and in a decay, that a wandering phase hardly turns within it."""
DECAYS = 2.0
"""Time constants of a mode's decay in a stretch, after which it has forgotten its phase."""
UNDAMPED = 1e-4
"""No structure's damping ratio is less: a pole of less is a line where the record is too short to ask."""
CHANCE = 1e-4
"""Of a line by chance, in one record."""
FINER = 8
"""Of the frequency, as a part of a line."""
LOBE, TAPER = 4, 12.0
"""Lines to either side that a line leaks into, and the parameter of the Kaiser window that keeps it there."""
AT_ONCE = 2_000_000


def steady_lines(record: Real, rate_hz: float, band_hz: tuple[float, float]) -> Real:
    """(lines,) Hz where the phase goes on over the whole record.

    Args:
        record: (outputs, samples)
        rate_hz: its rate.
        band_hz: where to look.
    """
    spectra = _spectra_of_stretches(record, STRETCHES)
    spacing = rate_hz / (record.shape[1] // STRETCHES)
    first, last = (int(np.clip(round(f / spacing), 1, spectra.shape[-1] - 1)) for f in band_hz)
    share, offset = np.zeros(spectra.shape[-1]), np.zeros(spectra.shape[-1])
    step = max(1, AT_ONCE // (STRETCHES * FINER * len(record)))
    for k in range(first, last + 1, step):
        lines = slice(k, min(k + step, last + 1))
        share[lines], offset[lines] = _coherent_share(spectra[..., lines])
    chance = (last + 1 - first) * STRETCHES * (1 - share) ** (STRETCHES - 1)
    found: list[int] = []
    for k in np.argsort(chance):
        if chance[k] > CHANCE:
            break
        if share[k] and all(abs(k - other) > LOBE for other in found):
            found.append(int(k))
    return np.array([_refine_line(spectra[..., k], k, float(offset[k])) * spacing for k in sorted(found)])


def line_at(record: Real, rate_hz: float, frequency_hz: float, damping_ratio: float) -> float | None:
    """The frequency of the line that a pole stands for; None if it may be a mode.

    Args:
        record: (outputs, samples)
        rate_hz: its rate.
        frequency_hz: of the pole.
        damping_ratio: of the pole: stretches are so long that a mode of it would forget its phase.
    """
    seconds, decay = record.shape[1] / rate_hz, 2 * np.pi * frequency_hz * damping_ratio
    count = min(int(seconds * decay / DECAYS), MOST_STRETCHES)
    steady = damping_ratio < UNDAMPED
    if count >= LEAST_STRETCHES:
        share, _ = _coherent_share(_demodulate(record, rate_hz, frequency_hz, count)[..., None])
        steady = count * (1 - share[0]) ** (count - 1) < CHANCE
    if steady or _amplitude_wanders(record, rate_hz, frequency_hz, seconds * decay):
        return _peak_frequency(record, rate_hz, frequency_hz, count / seconds)
    return None


def _amplitude_wanders(record: Real, rate_hz: float, frequency_hz: float, decays: float) -> bool:
    """Whether the amplitude at a pole moves across its phase only, in a record of so many time constants."""
    cycles = record.shape[1] / rate_hz * frequency_hz
    count = int(min(np.clip(IN_A_DECAY * decays, FINE_STRETCHES, MOST_STRETCHES), cycles / LOBE))
    return count >= LEAST_STRETCHES and _phase_likelihood(_demodulate(record, rate_hz, frequency_hz, count)) < CHANCE


def without_line(record: Real, rate_hz: float, frequency_hz: float) -> Real:
    """The record less a line whose amplitude and phase may wander from stretch to stretch."""
    length, samples = record.shape[1] // STRETCHES // 2 * 2, record.shape[1]
    window = np.hanning(length + 1)[:-1]
    turn = np.exp(-2j * np.pi * frequency_hz / rate_hz * np.arange(samples))
    left = record.copy()
    for first in range(-length // 2, samples, length // 2):
        # At the ends a stretch is cut, and so is what it is divided by.
        inside = slice(max(first, 0), min(first + length, samples))
        weight = window[inside.start - first : inside.stop - first]
        if weight.sum() == 0:
            continue
        amplitude = record[:, inside] @ (weight * turn[inside]) / weight.sum()
        left[:, inside] -= 2 * weight * (amplitude[:, None] * turn[inside].conj()).real
    return left


def lines_in_words(lines_hz: Sequence[float] | Real) -> str:
    """What is said of lines that were found."""
    listed = ", ".join(f"{f:.5g}" for f in lines_hz)
    base = float(min(lines_hz))
    orders = [round(f / base) for f in lines_hz]
    whole = len(lines_hz) > 1 and all(abs(f / base - k) < 2e-3 * k for f, k in zip(lines_hz, orders, strict=True))
    said = f" (orders {', '.join(map(str, orders))} of {base:.5g} Hz)" if whole else ""
    return (
        f"Periodic excitation, not modes: harmonics at {listed} Hz{said}. Their phase or amplitude is steadier than "
        "that of any response to a random force. They were taken out of the records before the modes were identified."
    )


def _peak_frequency(record: Real, rate_hz: float, frequency_hz: float, reach_hz: float) -> float:
    """Where a spectrum is highest, so far about a frequency."""
    power = np.sum(np.abs(_spectra_of_stretches(record, STRETCHES)) ** 2, axis=(0, 1))
    line = np.arange(power.size) * rate_hz / (record.shape[1] // STRETCHES)
    near = np.abs(line - frequency_hz) <= max(reach_hz, line[1])
    return float(line[near][np.argmax(power[near])])


def _spectra_of_stretches(record: Real, count: int) -> Complex128:
    """(count, outputs, lines) spectra of stretches that follow each other."""
    length = record.shape[1] // count
    parts = record[:, : count * length].reshape(len(record), count, length).transpose(1, 0, 2)
    return np.fft.rfft(parts * np.kaiser(length, TAPER), axis=-1)


def _demodulate(record: Real, rate_hz: float, frequency_hz: float, count: int) -> Complex128:
    """(count, outputs) of stretches that follow each other, at one frequency, phases against its own course."""
    length = record.shape[1] // count
    turn = np.exp(-2j * np.pi * frequency_hz / rate_hz * np.arange(count * length))
    return np.einsum("ocl,cl->co", record[:, : count * length].reshape(len(record), count, length),
                     turn.reshape(count, length) * np.hanning(length + 1)[:-1])  # fmt: skip


def _coherent_share(parts: Complex128) -> tuple[Real, Real]:
    """(lines,) share of the power of (stretches, outputs, lines) that goes on steadily, and at which part of a line."""
    count = len(parts)
    power = count * np.sum(np.abs(parts) ** 2, axis=(0, 1))
    together = np.sum(np.abs(np.fft.fft(parts, count * FINER, axis=0)) ** 2, axis=1)
    best = np.argmax(together, axis=0)
    share = np.max(together, axis=0) / np.where(power > 0, power, 1.0)
    cycles = best / (count * FINER)
    return np.minimum(share, 1.0), np.where(cycles > 0.5, cycles - 1, cycles)


def _refine_line(parts: Complex128, line: int, offset: float) -> float:
    """The line (with its decimals) by what is left of the phase's course over (stretches, outputs)."""
    turned = parts * np.exp(-2j * np.pi * offset * np.arange(len(parts)))[:, None]
    return line + offset + cmath.phase(complex(np.vdot(turned[:-1], turned[1:]))) / (2 * np.pi)


def _phase_likelihood(parts: Complex128) -> float:
    """How likely amplitudes of (stretches, outputs) move by chance so little along their phase, against across it."""
    amplitude = parts @ np.linalg.svd(parts, full_matrices=False)[2][0].conj()
    before, size = amplitude[:-1], np.abs(amplitude[:-1])
    moved = amplitude[1:] * before.conj() / np.maximum(size, 1e-300)
    # What the frequency is off turns all alike.
    moved *= np.exp(-1j * np.angle(np.vdot(before, amplitude[1:])))
    along = moved.real - (moved.real @ size) / (size @ size) * size
    free = len(size) - 1
    return float(fdtr(free, free, (along @ along) / (moved.imag @ moved.imag)))
