"""A campaign as few numbers in noise units, without loss for what the twin can say.

Hits at one point share one response: six hits are one set of lines. A sine block is its own line, its neighbours
and two harmonics. Noise of the converter is white; noise of the force is common to all channels of a line.

Lines of hits are the H1 estimate (Bendat and Piersol, Random Data, 2010) with the variance of its noise. Sines by the
three- and four-parameter fits of IEEE Std 1057, the frequency common to all blocks.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Complex, Real
from modallab.core.block import Block, Campaign
from modallab.core.rig import Rig
from modallab.gap.conditioning.drive_rows import group_drives, reduce_drive
from modallab.gap.conditioning.rows import DataPiece, ImpactData, Reduced, Rows, SineData, Weights, rows_of
from modallab.signals.hit import HitSamples
from modallab.signals.signals import Signals, to_signals
from modallab.signals.tone_fit import clock_ratio, fit_at
from modallab.twin.response import HISTORY_S, RAMP_S, HitsAtPoint, SineBlocks, SineStartUp, pulse_spectra

IMPACT_BAND = 0.2
"""Share of the rate up to which hits are used."""
BEFORE_S, AFTER_S = 0.012, 0.02
"""About the peak of a hit, at least: a steep anti-alias filter rings there, below the noise of one sample."""
NEIGHBOURS = 2
"""Lines on either side of a sine's own."""
LINES = 2 * NEIGHBOURS + 1
"""Lines about a sine, and about each overtone."""


def reduce_blocks(campaign: Campaign, blocks: Sequence[Block], weights: Weights) -> Reduced:
    """Reduce some blocks of a campaign."""
    rig = campaign.rig
    points = sorted({b.drive_point for b in blocks if b.test == "impact" and b.drive_point is not None})
    impacts = tuple(
        reduce_hits([b for b in blocks if b.test == "impact" and b.drive_point == p], rig, weights) for p in points
    )
    impacts += tuple(reduce_drive(records, rig, weights) for records in group_drives(blocks))
    sines = [b for b in blocks if b.test == "sine"]
    x = np.array([rig.x_of(c.point or 0) for c in rig.responses])
    last = float(max(1, *(b.order for b in campaign.blocks))) if campaign.blocks else 1.0
    channels = tuple(c.index for c in rig.responses)
    return Reduced(rig, impacts, reduce_sines(sines, rig, weights) if sines else None, channels, x, last)


def reduce_hits(blocks: Sequence[Block], rig: Rig, weights: Weights) -> ImpactData:
    """Hits at one point as one set of lines."""
    first = blocks[0]
    n, dt = first.n_samples, 1 / first.rate_hz
    lines = np.arange(1.0, int(IMPACT_BAND * n) + 1)
    signals = [to_signals(b, rig) for b in blocks]
    pulses, starts = hit_pulses(signals)
    F = pulse_spectra(pulses, starts, n)[:, 1 : len(lines) + 1]
    Y = np.array([np.fft.rfft(s.responses, axis=1)[:, 1 : len(lines) + 1] for s in signals])
    power = np.sum(np.abs(F) ** 2, axis=0)
    conj = F.conj() / power
    if _closest_frequencies(rig):
        # Each hit lands elsewhere: alike weights leave one mean place on all lines.
        conj = 1 / F / len(F)
        power = 1 / np.sum(np.abs(conj) ** 2, axis=0)
    sigma = weights.sigma(rig, "impact", lines, n, dt) * np.sqrt(n / 2 / power)
    # Half of the hum's power falls on either part, and its phase changes from hit to hit.
    sigma = np.hypot(sigma, weights.hum_amplitude(rig, "impact", lines, n, dt) * n / 2 / np.sqrt(2 * power))
    sigma[[any((b.name, c.index) in weights.masked for b in blocks) for c in rig.responses]] = np.inf
    force_noise = weights.force_noise(rig, "impact") * np.sqrt(pulses.shape[1] / 2 / power)
    piece = DataPiece(
        f"impact_p{first.drive_point:02d}",
        float(np.mean([b.order for b in blocks])),
        rig.x_of(first.drive_point or 0),
        None,
        tuple(b.name for b in blocks),
        tuple(float(b.order) for b in blocks),
    )
    source = HitsAtPoint(lines, n, dt, pulses, starts, conj)
    return ImpactData(piece, source, rows_of(np.einsum("hk,hck->ck", conj, Y), sigma, force_noise))


def _closest_frequencies(rig: Rig) -> bool:
    return bool(rig.tolerance.hit_position_m or rig.tolerance.hit_gain)


def hit_pulses(signals: Sequence[Signals]) -> tuple[Real, NDArray[np.int64]]:
    """(hits, m) force in N about each hit without its offset, and (hits,) the sample at which each begins."""
    windows = [hit_with_filter_ringing(s) for s in signals]
    pulses = np.zeros((len(signals), max(w.stop - w.first for w in windows)))
    for pulse, s, w in zip(pulses, signals, windows, strict=True):
        pulse[: w.stop - w.first] = s.force[w.first : w.stop] - w.offset
    return pulses, np.array([w.first for w in windows])


def hit_with_filter_ringing(signals: Signals) -> HitSamples:
    """The hit with the stretch about its peak in which an anti-alias filter still rings."""
    hit, rate = signals.hit, signals.rate_hz
    first = max(0, min(hit.first, hit.peak - round(BEFORE_S * rate)))
    stop = min(signals.force.size, max(hit.stop, hit.peak + round(AFTER_S * rate)))
    offset = float(signals.force[: max(1, first)].mean())
    return replace(hit, first=first, stop=stop, offset=offset)


def reduce_sines(blocks: Sequence[Block], rig: Rig, weights: Weights) -> SineData:
    """Sine blocks on the lines about their own."""
    first = blocks[0]
    n, dt = first.n_samples, 1 / first.rate_hz
    offsets = np.arange(-NEIGHBOURS, NEIGHBOURS + 1)
    signals = [to_signals(block, rig) for block in blocks]
    force_sigma = weights.force_noise(rig, "sine")
    ratio, ratio_sigma = measured_sine_ratio(signals, force_sigma)
    scale = _where_shown(ratio, ratio_sigma)
    lines, drive, forces, y, sigma, noise, pieces = [], [], [], [], [], [], []
    for block, signal in zip(blocks, signals, strict=True):
        f0 = frequency_on_line(block.frequency_hz or 0.0, n, dt) * scale
        line = round(f0 * n * dt)
        amplitude = force_amplitude(signal, f0)
        at = line + offsets
        spectrum = np.fft.rfft(signal.responses, axis=1)[:, np.abs(at)]
        spread = weights.sigma(rig, "sine", at.astype(float), n, dt) * np.sqrt(2 / n) / abs(amplitude)
        spread = np.hypot(
            spread, weights.hum_amplitude(rig, "sine", at.astype(float), n, dt) / np.sqrt(2) / abs(amplitude)
        )
        spread[[(block.name, c.index) in weights.masked for c in rig.responses]] = np.inf
        spread[:, at == 0] = np.inf
        lines.append(at.astype(float))
        drive.append(f0)
        forces.append(amplitude)
        y.append(np.where(at < 0, spectrum.conj(), spectrum) * 2 / n / amplitude)
        sigma.append(spread)
        louder = float(weights.noise_rise(np.array([f0]))[rig.force_channel.index, 0])
        noise.append(np.where(offsets == 0, louder * force_sigma * np.sqrt(2 / n) / abs(amplitude), 0.0))
        pieces.append(
            DataPiece(block.name, float(block.order), rig.x_of(block.drive_point or 0), block.level, (block.name,))
        )
    rows = rows_of(np.concatenate(y, axis=1), np.concatenate(sigma, axis=1), np.concatenate(noise))
    source = SineBlocks(np.array(lines), np.array(drive), n, dt, np.array(forces), start_up_of_sines(blocks))
    return SineData(tuple(pieces), source, rows, ratio, ratio_sigma)


def start_up_of_sines(blocks: Sequence[Block]) -> SineStartUp:
    """How the sines of blocks came about, the usual where a block does not say it."""
    return SineStartUp(
        np.array([HISTORY_S if b.history_s is None else b.history_s for b in blocks]),
        np.array([RAMP_S if b.ramp_s is None else b.ramp_s for b in blocks]),
        np.array([b.ramp == "cosine" for b in blocks]),
        np.array([b.history_s is not None for b in blocks]),
    )


def measured_sine_ratio(signals: Sequence[Signals], force_sigma: float) -> tuple[float, float]:
    """Frequency of the sines in the records over what the generator was set to, and its deviation."""
    rate, n = signals[0].rate_hz, signals[0].force.size
    set_hz = np.array([frequency_on_line(s.block.frequency_hz or 0.0, n, 1 / rate) for s in signals])
    return clock_ratio(np.array([s.force for s in signals]), rate, set_hz, force_sigma)


def sine_clock(data: Reduced) -> float:
    """Frequency of the sines over what the generator was set to; 1 where the records do not show that it differs."""
    return 1.0 if data.sines is None else _where_shown(data.sines.ratio, data.sines.ratio_sigma)


def sine_clock_of(blocks: Sequence[Block], rig: Rig, noise_v: Real) -> float:
    """The same from records as they came, of which only sines count, and (rows,) V of noise."""
    signals = [to_signals(b, rig) for b in blocks if b.test == "sine"]
    return _where_shown(*measured_sine_ratio(signals, Weights(noise_v).force_noise(rig, "sine"))) if signals else 1.0


def _where_shown(ratio: float, sigma: float) -> float:
    """A frequency over what the generator was set to; 1 where it differs by no more than chance."""
    return ratio if abs(ratio - 1) > 5 * sigma else 1.0


def force_amplitude(signals: Signals, frequency_hz: float) -> complex:
    """Complex amplitude of the force in N at a known frequency: f(t) = Re(amplitude exp(j omega t))."""
    return complex(fit_at(signals.force[None], signals.rate_hz, frequency_hz).amplitude[0])


def frequency_on_line(hz: float, n: int, dt: float) -> float:
    """A frequency that was rounded when it was written down, put back on its DFT line."""
    line = hz * n * dt
    return round(line) / (n * dt) if abs(line - round(line)) < 2e-3 else hz


def select_lines(data: Reduced, poles: Complex) -> Reduced:
    """The data with fewer lines, for a first look: all lines about the poles, few between them, three about a sine."""
    sines = _thin_sines(data.sines) if data.sines is not None else None
    return replace(data, impacts=tuple(_thin_part(d, poles) for d in data.impacts), sines=sines)


def _thin_sines(d: SineData) -> SineData:
    count = d.source.lines.shape[1]
    keep = np.abs(np.arange(count) - count // 2) <= 1
    rows = _keep_lines(d.rows, np.tile(keep, len(d.source.lines)))
    return replace(d, source=replace(d.source, lines=d.source.lines[:, keep]), rows=rows)


def _keep_lines(rows: Rows, keep: NDArray[np.bool_]) -> Rows:
    return Rows(rows.y[:, keep], rows.sigma[:, keep], rows.common[keep], rows.direction[:, keep])


def _thin_part(d: ImpactData, poles: Complex) -> ImpactData:
    df = 1 / (d.source.n * d.source.dt)
    hz = d.source.lines * df
    keep = (np.arange(len(hz)) % 12 == 0) | (hz < 8)
    for pole in np.abs(poles) / (2 * np.pi):
        keep |= np.abs(hz - pole) < np.maximum(3.5 * df, 0.025 * pole)
    return replace(d, source=d.source.on_lines(keep), rows=_keep_lines(d.rows, keep))
