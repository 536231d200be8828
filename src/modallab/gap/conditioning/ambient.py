"""What the accelerometers read without a force: ringing from before a hit, and a floor that shakes.

A line's power of Gaussian noise is exponentially distributed, so its median is ln 2 times its mean; Hann-windowed
spectra as in Welch, IEEE Trans. Audio Electroacoust. 15 (1967), 70. Decays are linear least squares of exponentials at
known poles, and their shapes the first left singular vector over the hits (Golub and Van Loan, Matrix Computations,
2013).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.core.block import Block
from modallab.core.rig import Rig
from modallab.gap.conditioning.hum import NO_DECAYS
from modallab.gap.conditioning.reduce import frequency_on_line, hit_with_filter_ringing
from modallab.signals.alignment import lags_s
from modallab.signals.conversion import volts_per_si
from modallab.signals.signals import to_signals

FLOOR_TOP_HZ = 60.0
"""A floor's shaking is looked for below this."""
MANY = 16
"""Blocks of which a median is known to a fifth."""
MOVES = 1.3
"""Rms before the hits, over the noise, from which the beam moves."""
LEADS = 1.024
"""Time by which a hit of the same kind came earlier, s: one block."""


@dataclass(frozen=True, eq=False, slots=True)
class RingingOfHits:
    """Free decay at the start of the hits.

    Attributes:
        fraction: size of the decay over that which the hit itself leaves, as if an equal hit had come a block before.
        z: rms before the hit over the noise.
        states: record -> (channels, modes) complex amplitude of each decay at the record's start.
        poles: (modes,) the decays.
    """

    fraction: float
    z: float
    states: dict[str, Complex]
    poles: Complex


@dataclass(frozen=True, eq=False, slots=True)
class BaseMotion:
    """Base motion.

    Attributes:
        rms_acc: m/s^2 of the base.
        z: how far its spectrum stands above the noise.
        spectrum: (channels, lines) two-sided density in (m/s^2)^2/Hz of the response, resonances with all that they
            leak into other lines.
        density: (channels, lines) the same under a Hann window, where they do not.
        block_s: length of the blocks whose lines these are.
    """

    rms_acc: float
    z: float
    spectrum: Real
    density: Real
    block_s: float


def before_hit(blocks: Sequence[Block], rig: Rig, noise_v: Real) -> float:
    """Rms of the accelerometers before the hits, over their noise; 1 is noise alone."""
    ratios: list[float] = []
    for b in blocks:
        signals = to_signals(b, rig)
        before = signals.responses[:, : max(1, hit_with_filter_ringing(signals).first)]
        if before.shape[1] > 20:
            ratios.append(float(np.median(np.sqrt(np.mean(before**2, axis=1)) / _ringing_sigma(b, rig, noise_v))))
    return float(np.median(ratios)) if ratios else 1.0


def is_moving_before_hits(blocks: Sequence[Block], rig: Rig, noise_v: Real) -> bool:
    """Whether the accelerometers read more than their noise before the hits."""
    return before_hit([b for b in blocks if b.test == "impact"], rig, noise_v) >= MOVES


def find_base_motion(
    blocks: Sequence[Block], rig: Rig, noise_v: Real, poles: Complex, ratio: float = 1.0
) -> BaseMotion | None:
    """Base motion that stands in most sine blocks beside the drive and the decays; None if there is none."""
    sines = [b for b in blocks if b.test == "sine"]
    if len(sines) < 4:
        return None
    residuals = [_beside_drive(b, rig, noise_v, poles, ratio) for b in sines]
    stack = np.ma.masked_invalid(np.array(residuals))
    n, rate = sines[0].n_samples, sines[0].rate_hz
    low = slice(2, int(FLOOR_TOP_HZ * n / rate))
    # Median over lines and channels of each block: a few lines of a decay or a harmonic cannot raise it.
    excess = np.ma.median(stack[:, :, low], axis=(1, 2)).filled(1.0) / np.log(2)
    z = float(np.quantile(excess, 0.25))
    hits = [b for b in blocks if b.test == "impact"]
    if z < 2.0 or (hits and before_hit(hits, rig, noise_v) < 1.15):
        return None
    # What the base excites rings at the resonances as what the drive has left does: neither is taken out here.
    per_hz = _ringing_sigma(sines[0], rig, noise_v)[:, None] ** 2 / rate
    spectrum, density = (
        per_hz * _above_noise([_beside_drive(b, rig, noise_v, NO_DECAYS, ratio, w) for b in sines])
        for w in (np.ones, np.hanning)
    )
    # Near the clamp an accelerometer moves with the base: the one with the least motion shows it best.
    base = float(np.sqrt(np.min(np.sum(spectrum, axis=1)) * 2 * rate / n))
    return BaseMotion(base, float(np.sqrt(z)), spectrum, density, n / rate)


def _above_noise(powers: Sequence[Real]) -> Real:
    """(channels, lines) mean over the blocks less the noise, by the median, which a drive's own transient moves little.

    Of a few blocks it is smoothed over five lines, which widens the resonances; many say each line by itself.
    """
    stack = np.ma.masked_invalid(np.array(powers))
    above = np.maximum(np.ma.median(stack, axis=0).filled(np.log(2)) / np.log(2) - 1, 0)
    if len(powers) >= MANY:
        return above
    return np.apply_along_axis(lambda row: np.convolve(row, np.ones(5) / 5, mode="same"), 1, above)


def _beside_drive(
    block: Block,
    rig: Rig,
    noise_v: Real,
    poles: Complex,
    ratio: float,
    window: Callable[[int], Real] = np.ones,
) -> Real:
    """(channels, lines) |residual|^2 over the noise after the drive and the decays are taken out; NaN at harmonics."""
    a = to_signals(block, rig).responses
    n, dt = block.n_samples, 1 / block.rate_hz
    t = np.arange(n) * dt
    drive = frequency_on_line(block.frequency_hz or 0.0, n, dt) * ratio * n * dt
    columns = [np.ones(n), np.cos(2 * np.pi * drive * t / (n * dt)), np.sin(2 * np.pi * drive * t / (n * dt))]
    for pole in poles[:3]:
        wave = np.exp(pole * t)
        columns += [wave.real, wave.imag]
    basis = np.column_stack(columns)
    residual = a.T - basis @ np.linalg.lstsq(basis, a.T, rcond=None)[0]
    w = window(n)
    power = np.abs(np.fft.rfft(residual.T * w)) ** 2 / np.sum(w**2) / _ringing_sigma(block, rig, noise_v)[:, None] ** 2
    lines = np.arange(power.shape[1])
    for k in range(1, 8):
        power[:, np.abs(lines - k * drive) < 3.5] = np.nan
    return power


def find_ringing(blocks: Sequence[Block], rig: Rig, noise_v: Real, poles: Complex) -> RingingOfHits | None:
    """Decays before the hits; None if the beam is at rest, or if what stands there is no decay."""
    hits = [b for b in blocks if b.test == "impact"]
    z = before_hit(hits, rig, noise_v)
    if z < MOVES or not len(poles) or not hits:
        return None
    poles = poles[: min(5, len(poles))]
    shapes = _shapes_of_decays(hits, rig, poles)
    states: dict[str, Complex] = {}
    left, fractions = [], []
    for b in hits:
        state, residual, fraction = _ringing_state(b, rig, noise_v, poles, shapes)
        states[b.name] = state
        left.append(residual)
        fractions.append(fraction)
    explained = 1 - (np.median(left) ** 2 - 1) / max(z**2 - 1, 1e-9)
    if explained < 0.5:
        return None
    return RingingOfHits(float(np.median(fractions)), z, states, poles)


def without_ringing(block: Block, rig: Rig, ringing: RingingOfHits) -> Block:
    """The record less its decay from before."""
    if block.name not in ringing.states:
        return block
    samples = np.array(block.samples, dtype=np.float64)
    per_si, lags = volts_per_si(rig, block.test) / block.scale, lags_s(rig)
    for state, channel in zip(ringing.states[block.name], rig.responses, strict=True):
        t = np.arange(block.n_samples) / block.rate_hz - lags[channel.index]
        decay = 2 * np.real(state @ np.exp(ringing.poles[:, None] * t))
        samples[channel.index] -= decay * per_si[channel.index]
    return replace(block, samples=samples)


def _shapes_of_decays(hits: Sequence[Block], rig: Rig, poles: Complex) -> Complex:
    """(channels, modes) shapes of the decays after the hits, each of unit length."""
    stacks: list[Complex] = []
    for b in hits:
        signals = to_signals(b, rig)
        stacks.append(_fit_decays(signals.responses[:, hit_with_filter_ringing(signals).stop :], poles, b.rate_hz))
    residues = np.array(stacks)
    shapes = np.zeros(residues.shape[1:], dtype=np.complex128)
    for r in range(len(poles)):
        shapes[:, r] = np.linalg.svd(residues[:, :, r].T, full_matrices=False)[0][:, 0]
    return shapes


def _fit_decays(a: Real, poles: Complex, rate_hz: float) -> Complex:
    """(channels, modes) complex amplitudes at the start of a stretch of free decay."""
    t = np.arange(a.shape[1]) / rate_hz
    # Modes without a pole here are as large at first: under a window they do not leak into the others.
    window = np.hanning(a.shape[1])
    wave = np.exp(poles[:, None] * t) * window
    basis = np.concatenate([2 * wave.real, -2 * wave.imag]).T
    found = np.linalg.lstsq(basis, (a * window).T, rcond=None)[0]
    return (found[: len(poles)] + 1j * found[len(poles) :]).T


def _ringing_state(
    block: Block, rig: Rig, noise_v: Real, poles: Complex, shapes: Complex
) -> tuple[Complex, float, float]:
    signals = to_signals(block, rig)
    a, hit = signals.responses, hit_with_filter_ringing(signals)
    before, stop = max(24, hit.first), max(24, hit.first) + hit.stop - hit.first
    sigma = _ringing_sigma(block, rig, noise_v)
    t = np.arange(before) / block.rate_hz
    wave = shapes[:, :, None] * np.exp(poles[:, None] * t) / sigma[:, None, None]
    basis = np.concatenate([2 * wave.real, -2 * wave.imag], axis=1).transpose(0, 2, 1).reshape(-1, 2 * len(poles))
    y = (a[:, :before] / sigma[:, None]).ravel()
    found = np.linalg.lstsq(basis, y, rcond=1e-6)[0]
    left = float(np.sqrt(np.mean((y - basis @ found) ** 2)))
    amplitude = found[: len(poles)] + 1j * found[len(poles) :]
    after = _fit_decays(a[:, stop:], poles, block.rate_hz)
    later = np.exp(poles * stop / block.rate_hz)
    # What the hit itself leaves, referred to the start of the record, less what rang before.
    own = np.linalg.norm(after / later - shapes * amplitude, axis=0)
    shares = np.abs(amplitude) / np.maximum(np.abs(np.exp(poles * LEADS)) * own, 1e-300)
    return shapes * amplitude, left, float(shares[0])


def _ringing_sigma(block: Block, rig: Rig, noise_v: Real) -> Real:
    return (noise_v / np.abs(volts_per_si(rig, block.test)))[[c.index for c in rig.responses]]
