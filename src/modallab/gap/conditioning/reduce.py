"""A campaign as few numbers in noise units, without loss for what the twin can say.

Hits at one point share one response: six hits are one set of lines. A sine block is its own line, its neighbours
and two harmonics. Noise of the converter is white; noise of the force is common to all channels of a line.

Lines of hits are the H1 estimate (Bendat and Piersol, Random Data, 2010) with the variance of its noise. The force's
noise is a rank-one part c d d^H of each line's covariance: I - (1 - 1 / sqrt(1 + c)) d d^H whitens I + c d d^H for a
unit vector d. Sines by the three- and four-parameter fits of IEEE Std 1057, the frequency common to all blocks.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.block import Block, Campaign
from modallab.core.rig import Rig
from modallab.core.units import Test
from modallab.twin.response import HISTORY_S, RAMP_S, Hits, Rise, Sines

Array = NDArray[np.float64]
Complex = NDArray[np.complexfloating[Any, Any]]

IMPACT_BAND = 0.2
"""Share of the rate up to which hits are used."""
BEFORE, AFTER = 24, 40
"""Samples about the peak of a hit that hold all of it."""
NEIGHBOURS = 2
"""Lines on either side of a sine's own."""


@dataclass(frozen=True, eq=False, slots=True)
class Rows:
    """One kind of data: responses per unit force on lines.

    Attributes:
        y: (channels, rows) measured, m/s^2 per N.
        sigma: (channels, rows) noise of each part, real and imaginary; inf where not to be used.
        common: (rows,) variance of the force's noise along the response, in units of sigma.
        direction: (channels, rows) unit vectors of that response, whitened.
    """

    y: Complex
    sigma: Array
    common: Array
    direction: Complex

    def whiten(self, residual: Complex) -> Complex:
        """Residuals (..., channels, rows) in noise units, the force's noise taken out."""
        r = residual / self.sigma
        along = np.einsum("cr,...cr->...r", self.direction.conj(), r)
        shrink = 1 - 1 / np.sqrt(1 + self.common)
        return r - self.direction * (shrink * along)[..., None, :]


@dataclass(frozen=True, eq=False, slots=True)
class Piece:
    """A piece of data with one drive point and one place in time.

    Attributes:
        name: of the hits at a point, or of the record.
        order: mean place of its records in the campaign, in records.
        drive_x_m: place of the force from the clamp, m.
        level: of the drive; None for hits.
        records: names of its records.
    """

    name: str
    order: float
    drive_x_m: float
    level: str | None
    records: tuple[str, ...]


@dataclass(frozen=True, eq=False, slots=True)
class ImpactData:
    """All hits at one point that are taken together."""

    piece: Piece
    source: Hits
    rows: Rows


@dataclass(frozen=True, eq=False, slots=True)
class SineData:
    """All sine blocks; rows are blocks x lines, flattened. `ratio` is the seen frequency over the one that was set."""

    pieces: tuple[Piece, ...]
    source: Sines
    rows: Rows
    ratio: float
    ratio_sigma: float


@dataclass(frozen=True, eq=False, slots=True)
class Reduced:
    """What the fits see.

    Attributes:
        rig: the bench as believed.
        impacts: a set of lines for each drive point.
        sines: the sine test, None if there is none.
        channels: numbers of the accelerometers, 1 is the first after the force.
        x_m: (channels,) their places.
        last_order: place in time of the campaign's last record.
    """

    rig: Rig
    impacts: tuple[ImpactData, ...]
    sines: SineData | None
    channels: tuple[int, ...]
    x_m: Array
    last_order: float


@dataclass(frozen=True, eq=False, slots=True)
class Weights:
    """What each number weighs.

    Attributes:
        noise_v: (rows,) V rms of each row.
        masked: (record, row) that must not be used: cut or overloaded.
        floor: (channels, lines) variance per sample that a shaking base adds on each line of a sine block; or None.
    """

    noise_v: Array
    masked: frozenset[tuple[str, int]] = frozenset()
    floor: Array | None = None

    def sigma(self, rig: Rig, test: Test, lines: Array) -> Array:
        """(channels, lines) noise per sample in m/s^2."""
        white = np.array([self.noise_v[c.index] / abs(c.sensitivity(test)) for c in rig.responses])
        total = np.repeat(white[:, None], len(lines), axis=1)
        if self.floor is None:
            return total
        at = np.minimum(np.abs(lines).astype(int), self.floor.shape[1] - 1)
        return np.sqrt(total**2 + self.floor[:, at])

    def force(self, rig: Rig, test: Test) -> float:
        """Noise of the force per sample in N."""
        return float(self.noise_v[rig.force_channel.index] / abs(rig.force_channel.sensitivity(test)))


def reduce(campaign: Campaign, blocks: Sequence[Block], weights: Weights) -> Reduced:
    """Reduce some blocks of a campaign."""
    rig = campaign.rig
    points = sorted({b.drive_point for b in blocks if b.test == "impact" and b.drive_point is not None})
    impacts = tuple(
        reduce_hits([b for b in blocks if b.test == "impact" and b.drive_point == p], rig, weights) for p in points
    )
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
    pulses, starts, spectra, responses = [], [], [], []
    for block in blocks:
        force, acceleration = scaled(block, rig)
        pulse, start = hit(force)
        windowed = np.zeros(n)
        windowed[start : start + len(pulse)] = pulse[: n - start]
        pulses.append(pulse)
        starts.append(start)
        spectra.append(np.fft.rfft(windowed)[1 : len(lines) + 1])
        responses.append(np.fft.rfft(acceleration, axis=1)[:, 1 : len(lines) + 1])
    F, Y = np.array(spectra), np.array(responses)
    power = np.sum(np.abs(F) ** 2, axis=0)
    sigma = weights.sigma(rig, "impact", lines) * np.sqrt(n / 2 / power)
    sigma[[any((b.name, c.index) in weights.masked for b in blocks) for c in rig.responses]] = np.inf
    force_noise = weights.force(rig, "impact") * np.sqrt((BEFORE + AFTER) / 2 / power)
    conj = F.conj() / power
    piece = Piece(
        f"impact_p{first.drive_point:02d}",
        float(np.mean([b.order for b in blocks])),
        rig.x_of(first.drive_point or 0),
        None,
        tuple(b.name for b in blocks),
    )
    source = Hits(lines, n, dt, np.array(pulses), np.array(starts), conj)
    return ImpactData(piece, source, _rows(np.einsum("hk,hck->ck", conj, Y), sigma, force_noise))


def hit(force: Array) -> tuple[Array, int]:
    """The stretch of the force that holds the hit, its mean before taken off, and where it begins."""
    start = max(0, int(np.argmax(np.abs(force))) - BEFORE)
    pulse = np.zeros(BEFORE + AFTER)
    piece = force[start : start + BEFORE + AFTER]
    pulse[: len(piece)] = piece - force[: max(1, start)].mean()
    return pulse, start


def reduce_sines(blocks: Sequence[Block], rig: Rig, weights: Weights) -> SineData:
    """Sine blocks on the lines about their own."""
    first = blocks[0]
    n, dt = first.n_samples, 1 / first.rate_hz
    offsets = np.arange(-NEIGHBOURS, NEIGHBOURS + 1)
    signals = [scaled(block, rig) for block in blocks]
    force_sigma = weights.force(rig, "sine")
    ratio, ratio_sigma = sine_ratio(blocks, rig, force_sigma)
    scale = ratio if abs(ratio - 1) > 5 * ratio_sigma else 1.0
    lines, drive, forces, y, sigma, noise, pieces = [], [], [], [], [], [], []
    for block, (force, acceleration) in zip(blocks, signals, strict=True):
        f0 = on_line(block.frequency_hz or 0.0, n, dt) * scale
        line = round(f0 * n * dt)
        amplitude = harmonic(force, f0, dt)
        at = line + offsets
        spectrum = np.fft.rfft(acceleration, axis=1)[:, np.abs(at)]
        spread = weights.sigma(rig, "sine", at.astype(float)) * np.sqrt(2 / n) / abs(amplitude)
        spread[[(block.name, c.index) in weights.masked for c in rig.responses]] = np.inf
        spread[:, at == 0] = np.inf
        lines.append(at.astype(float))
        drive.append(f0)
        forces.append(amplitude)
        y.append(np.where(at < 0, spectrum.conj(), spectrum) * 2 / n / amplitude)
        sigma.append(spread)
        noise.append(np.where(offsets == 0, force_sigma * np.sqrt(2 / n) / abs(amplitude), 0.0))
        pieces.append(
            Piece(block.name, float(block.order), rig.x_of(block.drive_point or 0), block.level, (block.name,))
        )
    rows = _rows(np.concatenate(y, axis=1), np.concatenate(sigma, axis=1), np.concatenate(noise))
    source = Sines(np.array(lines), np.array(drive), n, dt, np.array(forces), rise_of(blocks))
    return SineData(tuple(pieces), source, rows, ratio, ratio_sigma)


def rise_of(blocks: Sequence[Block]) -> Rise:
    """How the sines of blocks came about, the usual where a block does not say it."""
    return Rise(
        np.array([HISTORY_S if b.history_s is None else b.history_s for b in blocks]),
        np.array([RAMP_S if b.ramp_s is None else b.ramp_s for b in blocks]),
        np.array([b.ramp == "cosine" for b in blocks]),
        np.array([b.history_s is not None for b in blocks]),
    )


def sine_ratio(blocks: Sequence[Block], rig: Rig, force_sigma: float) -> tuple[float, float]:
    """Frequency of the sines in the records over what the generator was set to, and its deviation."""
    first = blocks[0]
    n, dt = first.n_samples, 1 / first.rate_hz
    set_hz = np.array([on_line(b.frequency_hz or 0.0, n, dt) for b in blocks])
    return frequency_ratio(np.array([scaled(b, rig)[0] for b in blocks]), set_hz, dt, force_sigma)


def scaled(block: Block, rig: Rig) -> tuple[Array, Array]:
    """Force (n,) in N and accelerations (channels, n) in m/s^2 at the rig's sensitivities."""
    volts = block.samples * block.scale[:, None]
    sensitivity = np.array([c.sensitivity(block.test) for c in rig.channels])
    values = volts / sensitivity[:, None]
    return values[rig.force_channel.index], values[[c.index for c in rig.responses]]


def on_line(hz: float, n: int, dt: float) -> float:
    """A frequency that was rounded when it was written down, put back on its DFT line."""
    line = hz * n * dt
    return round(line) / (n * dt) if abs(line - round(line)) < 2e-3 else hz


def harmonic(force: Array, f0: float, dt: float) -> complex:
    """Complex amplitude of a sine of known frequency, beside a mean."""
    t = np.arange(len(force)) * dt
    basis = np.column_stack([np.cos(2 * np.pi * f0 * t), -np.sin(2 * np.pi * f0 * t), np.ones(len(t))])
    a, b, _ = np.linalg.lstsq(basis, force, rcond=None)[0]
    return complex(a, b)


def frequency_ratio(forces: Array, set_hz: Array, dt: float, sigma: float) -> tuple[float, float]:
    """Frequency of the force over what the generator was set to, with its deviation: one number for all blocks.

    The four-parameter sine fit of IEEE Std 1057 by Gauss-Newton steps, amplitudes and means projected out of the slope.

    Args:
        forces: (blocks, n) in N.
        set_hz: (blocks,) what the generator was set to.
        dt: time between samples, s.
        sigma: noise of a force sample, N.
    """
    ratio = _coarse_ratio(forces, set_hz, dt)
    spread = np.inf
    for _ in range(6):
        num, den = 0.0, 0.0
        t = np.arange(forces.shape[1]) * dt
        for force, f0 in zip(forces, set_hz * ratio, strict=True):
            c, s = np.cos(2 * np.pi * f0 * t), np.sin(2 * np.pi * f0 * t)
            basis = np.column_stack([c, s, np.ones(len(t))])
            a, b, _ = np.linalg.lstsq(basis, force, rcond=None)[0]
            slope = 2 * np.pi * f0 * t * (b * c - a * s)
            slope = slope - basis @ np.linalg.lstsq(basis, slope, rcond=None)[0]
            num += float(slope @ force)
            den += float(slope @ slope)
        ratio *= 1 + num / den
        spread = sigma / np.sqrt(den)
        if abs(num / den) < 1e-9:
            break
    return ratio, float(spread)


def _coarse_ratio(forces: Array, set_hz: Array, dt: float) -> float:
    grid = np.arange(-0.1, 0.1001, 0.002)
    t = np.arange(forces.shape[1]) * dt
    top = np.argsort(set_hz)[-6:]
    window = np.hanning(len(t))
    power = [
        sum(
            abs(np.sum(window * f * np.exp(-2j * np.pi * h * (1 + g) * t))) ** 2 / np.sum(f**2)
            for f, h in zip(forces[top], set_hz[top], strict=True)
        )
        for g in grid
    ]
    return 1 + float(grid[int(np.argmax(power))])


def _rows(y: Complex, sigma: Array, force_noise: Array) -> Rows:
    whitened = y / sigma
    length = np.maximum(np.linalg.norm(whitened, axis=0), 1e-300)
    return Rows(y, sigma, (force_noise * length) ** 2, whitened / length)


def thinned(data: Reduced, poles: Complex) -> Reduced:
    """The data with fewer lines, for a first look: all lines about the poles, few between them, three about a sine."""
    sines = _thin_sines(data.sines) if data.sines is not None else None
    return replace(data, impacts=tuple(_thin(d, poles) for d in data.impacts), sines=sines)


def _thin_sines(d: SineData) -> SineData:
    count = d.source.lines.shape[1]
    keep = np.abs(np.arange(count) - count // 2) <= 1
    rows = _kept(d.rows, np.tile(keep, len(d.source.lines)))
    return replace(d, source=replace(d.source, lines=d.source.lines[:, keep]), rows=rows)


def _kept(rows: Rows, keep: NDArray[np.bool_]) -> Rows:
    return Rows(rows.y[:, keep], rows.sigma[:, keep], rows.common[keep], rows.direction[:, keep])


def _thin(d: ImpactData, poles: Complex) -> ImpactData:
    df = 1 / (d.source.n * d.source.dt)
    hz = d.source.lines * df
    keep = (np.arange(len(hz)) % 12 == 0) | (hz < 8)
    for pole in np.abs(poles) / (2 * np.pi):
        keep |= np.abs(hz - pole) < np.maximum(3.5 * df, 0.025 * pole)
    source = replace(d.source, lines=d.source.lines[keep], weights=d.source.weights[:, keep])
    return replace(d, source=source, rows=_kept(d.rows, keep))
