"""What the shaker plays in a broadband test: finite waves of known peak, each from 0 V to 0 V.

Source: Pintelon and Schoukens, System Identification: A Frequency Domain Approach, 2nd ed. (2012), chapter 5, on the
signals and their crest factors.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, floor, sqrt

import numpy as np

from modallab.bench.protocol import Waveform
from modallab.core.arrays import Real
from modallab.core.plan import BroadbandPlan

OVERSAMPLED = 10.0
LEAST_RATE_HZ = 5000.0
MARGIN_S = 0.1
"""Past the last block: a converter delays its samples by up to some 40 periods of its rate."""

BURST_BEGINS = 0.05
"""Of a block, before its burst: a block must hold all of it, whatever the converters delay."""

BURST_EDGE = 0.1
"""Of a burst, of the cosine taper at each end."""

GROUP = 4
"""Odd lines of which one is left out, and waves after which each has been."""


@dataclass(frozen=True, slots=True)
class WaveLayout:
    """How one wave is laid out in time.

    Attributes:
        lead_s: from its start to its first block.
        blocks: it holds.
        block_s: of one, as the device counts.
        end_s: when it has come to 0 V.
    """

    lead_s: float
    blocks: int
    block_s: float
    end_s: float


def wave_layout(plan: BroadbandPlan, blocks: int, block_s: float) -> WaveLayout:
    """The layout of a wave. Burst random needs neither lead nor taper: each of its blocks begins at rest."""
    if plan.signal == "burst-random":
        return WaveLayout(0.0, blocks, block_s, blocks * block_s + MARGIN_S)
    return WaveLayout(plan.settle_s, blocks, block_s, plan.settle_s + blocks * block_s + MARGIN_S + plan.ramp_s)


def blocks_per_wave(plan: BroadbandPlan, max_burst_s: float) -> int:
    """How many blocks fit into the longest wave that plan and rig allow; 0 if not one does."""
    around_s = wave_layout(plan, 0, plan.block_s).end_s
    most = min(plan.blocks, plan.blocks_per_wave or plan.blocks)
    return max(0, floor(min(most, (max_burst_s - around_s) / plan.block_s + 1e-9)))


def blocks_of_wave(plan: BroadbandPlan, number: int, missing: int, most: int, shakers: int) -> int:
    """How many blocks a wave holds: as many as it can, or its share of what several shakers' waves have to show.

    Args:
        plan: with its signal.
        number: of the wave at its level, from 0.
        missing: blocks still to be recorded.
        most: that a wave can hold.
        shakers: how many play at once.
    """
    waves = shakers - number % shakers if is_periodic(plan) else 1
    return min(most, ceil(missing / waves))


def is_periodic(plan: BroadbandPlan) -> bool:
    """Whether every block of a wave holds the same: then one wave shows what the forces do together, no more."""
    return plan.signal in ("pseudo-random", "chirp")


def make_waves(plan: BroadbandPlan, level: str, number: int, layout: WaveLayout, shakers: int) -> tuple[Waveform, ...]:
    """What each of several shakers plays at once, the first one's first.

    Random drive is another noise for each. Of a periodic drive, the wave of each shaker is turned by another angle in
    each of as many waves as there are shakers, after which its phases are drawn anew: the matrix of the angles is that
    of a Fourier transform, so that at every line the forces of these waves are orthogonal, with the least error of all
    FRFs that amplitudes of this size can give.
    Source: Pintelon and Schoukens, section 2.7, and Dobrowiecki, Schoukens, Guillaume, IEEE Trans. Instrum. Meas. 55
    (2006), 1744-1752, orthogonal multisines.

    Args:
        plan: signal, band, levels, seed.
        level: one of the plan's.
        number: of the wave at this level, from 0.
        layout: in time.
        shakers: how many play.
    """
    return tuple(make_wave(plan, level, number, layout, shaker, shakers) for shaker in range(shakers))


def make_wave(
    plan: BroadbandPlan, level: str, number: int, layout: WaveLayout, shaker: int = 0, shakers: int = 1
) -> Waveform:
    """One wave.

    Args:
        plan: signal, band, levels, seed.
        level: one of the plan's.
        number: of the wave at this level, from 0; each has phases of its own.
        layout: in time.
        shaker: whose it is, from 0.
        shakers: how many play at once.
    """
    periodic = is_periodic(plan)
    drawn = number // shakers if periodic else number
    seeds = [plan.seed, list(plan.levels_v).index(level), drawn]
    # As it always was for one shaker alone.
    rng = np.random.default_rng([*seeds, shaker] if shaker else seeds)
    turned = 2 * np.pi * (shaker * number % shakers) / shakers if periodic else 0.0
    if plan.signal == "chirp" and shaker:
        # All chirps have the phases of the sweep: these tell one round of waves from the next.
        turned += 2 * np.pi * rng.random()
    period = ceil(layout.block_s * max(LEAST_RATE_HZ, OVERSAMPLED * plan.band_hz[1]))
    rate_hz = period / layout.block_s
    count = ceil(layout.end_s * rate_hz) + 1
    undriven = detection_lines(plan, number, layout.block_s) if plan.detection_lines else ()
    samples = plan.levels_v[level] * _unit_rms_wave(plan, rng, turned, period, rate_hz, count, layout, undriven)
    if plan.signal != "burst-random":
        samples *= _tapered_envelope(np.arange(count) / rate_hz, layout.end_s, plan.ramp_s)
    samples[0] = samples[-1] = 0.0
    return Waveform(samples, rate_hz)


def detection_lines(plan: BroadbandPlan, number: int, block_s: float) -> list[int]:
    """Lines that a wave leaves out: all even ones, and of every four odd ones that follow each other one at random.

    Over four waves each odd line is left out once: what is seen there is what the others hold besides their answer.
    Source: Pintelon and Schoukens, section 4.3.2, random harmonic grids.
    """
    count = ceil(block_s * max(LEAST_RATE_HZ, OVERSAMPLED * plan.band_hz[1]))
    chosen = _lines_of_band(count, count / block_s, plan.band_hz)
    every = np.arange(chosen.start, chosen.stop)
    odd = every[every % 2 == 1]
    rng = np.random.default_rng([plan.seed, number // GROUP, 1, 1])
    turns = rng.permuted(np.tile(np.arange(GROUP), (ceil(odd.size / GROUP), 1)), axis=1).ravel()[: odd.size]
    return [*every[every % 2 == 0].tolist(), *odd[turns == number % GROUP].tolist()]


def peak_v(wave: Waveform) -> float:
    """Largest magnitude in V."""
    return float(np.abs(wave.samples).max())


def slew_v_per_s(wave: Waveform) -> float:
    """Steepest rise or fall in V/s."""
    return float(np.abs(np.diff(wave.samples)).max() * wave.rate_hz)


def _unit_rms_wave(
    plan: BroadbandPlan,
    rng: np.random.Generator,
    turned: float,
    period: int,
    rate_hz: float,
    count: int,
    layout: WaveLayout,
    undriven: Sequence[int],
) -> Real:
    """(count,) samples whose rms is 1 while the wave is on."""
    if plan.signal == "random":
        return _noise_wave(rng, count, rate_hz, plan.band_hz)
    if plan.signal == "burst-random":
        return _burst_wave(plan, rng, period, rate_hz, count, layout)
    if plan.signal == "chirp":
        one = _sweep_wave(period, rate_hz, plan.band_hz)
    else:
        one = _random_phase_wave(rng, period, rate_hz, plan.band_hz, undriven)
    if turned:
        one = np.fft.irfft(np.fft.rfft(one) * np.exp(1j * turned), period)
    # A block begins with a period, whatever came before it.
    return one[(np.arange(count) - round(layout.lead_s * rate_hz)) % period]


def _lines_of_band(count: int, rate_hz: float, band_hz: tuple[float, float]) -> slice:
    line_hz = rate_hz / count
    return slice(max(1, ceil(band_hz[0] / line_hz - 1e-9)), floor(band_hz[1] / line_hz + 1e-9) + 1)


def _noise_wave(rng: np.random.Generator, count: int, rate_hz: float, band_hz: tuple[float, float]) -> Real:
    spectrum = np.zeros(count // 2 + 1, complex)
    inside = spectrum[_lines_of_band(count, rate_hz, band_hz)]
    inside[:] = rng.standard_normal(inside.size) + 1j * rng.standard_normal(inside.size)
    return _of_unit_rms(np.fft.irfft(spectrum, count))


def _random_phase_wave(
    rng: np.random.Generator, period: int, rate_hz: float, band_hz: tuple[float, float], undriven: Sequence[int]
) -> Real:
    spectrum = np.zeros(period // 2 + 1, complex)
    inside = spectrum[_lines_of_band(period, rate_hz, band_hz)]
    inside[:] = np.exp(2j * np.pi * rng.random(inside.size))
    spectrum[list(undriven)] = 0
    return _of_unit_rms(np.fft.irfft(spectrum, period))


def _sweep_wave(period: int, rate_hz: float, band_hz: tuple[float, float]) -> Real:
    chosen = _lines_of_band(period, rate_hz, band_hz)
    first, last = chosen.start, chosen.stop - 1
    # A whole number of cycles in a period: it joins itself without a jump.
    last -= (first + last) % 2
    share = np.arange(period) / period
    return sqrt(2) * np.sin(2 * np.pi * (first * share + (last - first) * share**2 / 2))


def _burst_wave(
    plan: BroadbandPlan, rng: np.random.Generator, period: int, rate_hz: float, count: int, layout: WaveLayout
) -> Real:
    samples = np.zeros(count)
    on, begins = int(plan.burst_share * period), int(BURST_BEGINS * period)
    for block in range(layout.blocks):
        noise = _noise_wave(rng, period, rate_hz, plan.band_hz)[:on]
        first = block * period + begins
        samples[first : first + on] = noise * _tapered_envelope(np.arange(on) / on, 1.0, BURST_EDGE)
    return samples


STEP_S = 1e-9
"""What rises in less is a step, at any rate."""


def _tapered_envelope(at: Real, end: float, ramp: float) -> Real:
    return (1 - np.cos(np.pi * np.clip(np.minimum(at, end - at) / max(ramp, STEP_S), 0, 1))) / 2


def _of_unit_rms(values: Real) -> Real:
    return values / sqrt(float(np.mean(values**2)))
