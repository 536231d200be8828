"""Mains hum: a sine of the mains on every row, with the same amplitudes in every record.

Amplitudes by the three-parameter sine fit of IEEE Std 1057, all sines of a record at once, under a Hann window where a
drive stands beside it (Harris, Proc. IEEE 66, 1978, 51).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from scipy.optimize import minimize_scalar

from modallab.core.arrays import Complex, Real
from modallab.core.block import Block

MAINS_HZ = (50.0, 60.0)
NO_DECAYS: Complex = np.zeros(0, dtype=np.complex128)
CLEAR = 6.0
"""Deviations of the noise from which an amplitude counts."""
STEADY = 0.1
"""Median deviation from record to record, over the amplitude, that hum stays below."""
SCATTER = 1.3
"""The same that noise may add, in deviations of its part: half of all lie within 0.67 of them."""

OFF = 0.035
"""Relative error of a converter's clock within which the mains is looked for."""
BESIDE_HZ = 8.0
"""So near the mains, a drive must be known better than by its line."""
WEAK = 2.0
"""Median power over the noise's, over the rows, from which weak hum is weighed."""
PLAINLY = 1.02
"""How much more power another frequency must hold."""


@dataclass(frozen=True, eq=False, slots=True)
class Hum:
    """What was found.

    Attributes:
        hz: the mains.
        seen_hz: where it stands in the records, whose clock may be off.
        volts: (rows,) amplitude.
        z: how many deviations of its noise the force row's amplitude has.
        force: number of the row of the force.
        ratio: frequency of the drives in the records over their lines'.
        weight: (rows,) how much a row's amplitude says of the phase of all.
    """

    hz: float
    seen_hz: float
    volts: Real
    z: float
    force: int
    ratio: float
    weight: Real


def find_hum(blocks: Sequence[Block], noise_v: Real, force: int) -> Hum | None:
    """Hum that stands in most records on most rows, clear of noise; None if there is none.

    It comes with the wiring and is on the row of the force too, where a floor that shakes at the mains' frequency, as
    below a transformer, is not; and its amplitude is the same in every record.

    Args:
        blocks: the records.
        noise_v: (rows,) V rms of each row.
        force: number of the row of the force.
    """
    best: Hum | None = None
    # Of less than a period in a record nothing says where it stands.
    sines = [b for b in blocks if b.test == "sine" and (b.frequency_hz or 0.0) * b.n_samples >= b.rate_hz]
    off = [(b.frequency_hz or 0.0, _drive_off(b, force)) for b in sines]
    for hz in MAINS_HZ:
        ratio = _drive_ratio(off, hz)
        with_hum = [b for b in blocks if b.test == "sine" and _is_hum_clear(b, hz)]
        if len(with_hum) < 4:
            with_hum = [b for b in blocks if b.test == "impact"]
        if len(with_hum) < 3:
            continue
        records = [_Record.of(b, hz, force, ratio) for b in with_hum]
        seen_hz = _mains_frequency(records, hz, noise_v) if with_hum[0].test == "sine" else hz
        size = np.abs(np.array([r.amplitudes(seen_hz) for r in records]))
        volts = np.median(size, axis=0)
        n = int(np.median([_samples_with_hum(b, force) for b in with_hum]))
        sigma = noise_v * np.sqrt(2 / n)
        z = volts / sigma
        # Steady: a response to the drive would change from record to record; hum does not.
        steady = np.median(np.abs(size - volts), axis=0) < STEADY * volts + SCATTER * sigma
        stands = (z > CLEAR) & steady
        clear = stands[force] and np.count_nonzero(stands) >= max(3, 0.6 * len(volts))
        if clear and (best is None or float(z[force]) > best.z):
            best = Hum(hz, seen_hz, volts, float(z[force]), force, ratio, volts / noise_v**2)
    return best


def without_hum(block: Block, hum: Hum, decays: Complex | None = None) -> Block:
    """The record less its hum; the phase is the record's own.

    Few periods of the mains before a hit do not tell hum from what still rings there. A hammer that nothing touches
    does not ring: its row alone says the phase, or says it beside the others where it is known how they move.

    Args:
        block: the record.
        hum: what was found.
        decays: (modes,) poles in rad/s of what rings before a hit, empty for a beam at rest; None if nobody knows.
    """
    volts = block.samples * block.scale[:, None]
    t = np.arange(block.n_samples) / block.rate_hz
    phases, weight = _amplitudes(block, hum.seen_hz, hum.force, hum.ratio), hum.weight
    if block.test == "impact" and decays is None:
        weight = weight * (np.arange(len(weight)) == hum.force)
    elif block.test == "impact" and decays is not None:
        alone = phases[hum.force]
        phases = _amplitudes(block, hum.seen_hz, hum.force, hum.ratio, decays)
        phases[hum.force] = alone
    # One phase for all rows, weighed by how far each stands out of its noise.
    phase = np.angle(np.sum(phases * weight))
    cleaned = volts - hum.volts[:, None] * np.cos(2 * np.pi * hum.seen_hz * t + phase)
    return replace(block, samples=cleaned / block.scale[:, None])


def _mains_frequency(records: Sequence["_Record"], hz: float, noise_v: Real) -> float:
    """Where the mains stands in the records: at its own frequency, unless another one nearby holds plainly more.

    Each row counts by its noise: a channel a thousand times as noisy as the others would decide it by chance.
    """

    def power(f: float) -> float:
        return float(np.median([np.sum(np.abs(r.amplitudes(f) / noise_v) ** 2) for r in records]))

    found, most = _strongest_nearby(power, hz, 15)
    return found if most > PLAINLY * power(hz) else hz


def _strongest_nearby(power: Callable[[float], float], hz: float, points: int) -> tuple[float, float]:
    """The frequency around `hz`, within what a clock may be off, that holds most, and its power."""
    grid = hz * (1 + np.linspace(-OFF, OFF, points))
    start = float(grid[int(np.argmax([power(float(f)) for f in grid]))])
    step = float(grid[1] - grid[0])
    found = minimize_scalar(lambda f: -power(float(f)), bounds=(start - step, start + step), method="bounded")
    return float(found.x), -float(found.fun)


def _is_hum_clear(block: Block, hz: float) -> bool:
    return abs((block.frequency_hz or 0.0) - hz) > 3.0


@dataclass(frozen=True, eq=False, slots=True)
class _Record:
    """A record made ready to be asked for the amplitudes of the mains at many frequencies.

    Attributes:
        t: (n,) s.
        window: (n,).
        volts: (rows, n) under the window.
        beside: (fixed, n) what stands beside the mains, under the window: a mean, the drive, decays.
        mixed: (fixed, fixed) products of these with each other.
        held: (fixed, rows) products of these with the volts.
    """

    t: Real
    window: Real
    volts: Real
    beside: Real
    mixed: Real
    held: Real

    @classmethod
    def of(cls, block: Block, near_hz: float, force: int, ratio: float, decays: Complex = NO_DECAYS) -> Self:
        """Of a block, for frequencies near one, beside decays of some poles."""
        volts = block.samples[:, : _samples_with_hum(block, force)] * block.scale[:, None]
        t = np.arange(volts.shape[1]) / block.rate_hz
        window = np.hanning(len(t)) if block.test == "sine" else np.ones(len(t))
        beside = [np.ones(len(t))]
        if block.test == "sine" and block.frequency_hz:
            drive = _sine_columns(block.frequency_hz, t, block.rate_hz)
            if abs(block.frequency_hz - near_hz) < BESIDE_HZ:
                drive *= ratio
            beside += [np.cos(2 * np.pi * drive * t), np.sin(2 * np.pi * drive * t)]
        waves = np.exp(decays[:, None] * t)
        rows = np.array([*beside, *waves.real, *waves.imag]) * window
        weighed = volts * window
        return cls(t, window, weighed, rows, rows @ rows.T, rows @ weighed.T)

    def amplitudes(self, hz: float) -> Complex:
        """(rows,) complex amplitude of a sine, by least squares with all that stands beside it."""
        phase = 2 * np.pi * hz * self.t
        mains = np.array([np.cos(phase), -np.sin(phase)]) * self.window
        products = np.empty((2 + len(self.beside),) * 2)
        products[:2, :2], products[2:, 2:] = mains @ mains.T, self.mixed
        products[:2, 2:] = mains @ self.beside.T
        products[2:, :2] = products[:2, 2:].T
        # Least squares, not a plain solution: a drive on the mains itself leaves no unique one.
        a = np.linalg.lstsq(products, np.concatenate([mains @ self.volts.T, self.held]), rcond=None)[0]
        return a[0] + 1j * a[1]


def _amplitudes(block: Block, hz: float, force: int, ratio: float, decays: Complex = NO_DECAYS) -> Complex:
    """(rows,) complex amplitude of the mains beside the drive, a mean and decays."""
    return _Record.of(block, hz, force, ratio, decays).amplitudes(hz)


def _sine_columns(hz: float, t: Real, rate_hz: float) -> float:
    return round(hz * len(t) / rate_hz) * rate_hz / len(t)


def _drive_ratio(off: Sequence[tuple[float, float]], hz: float) -> float:
    """Frequency of the drives in the records over their lines', by those (Hz, ratio) that have no mains beside them.

    Beside the mains a hundredth of a line counts: what a drive leaves of itself there would be taken for hum, and turn
    what is taken out.
    """
    found = [ratio for drive_hz, ratio in off if abs(drive_hz - hz) > BESIDE_HZ]
    return float(np.median(found)) if found else 1.0


def _drive_off(block: Block, force: int) -> float:
    """Where the drive stands in the row of the force, over its line."""
    t = np.arange(block.n_samples) / block.rate_hz
    row = block.samples[force] * block.scale[force]
    weighed = (row - np.mean(row)) * np.hanning(len(t))

    def power(f: float) -> float:
        return float(np.abs(np.exp(-2j * np.pi * f * t) @ weighed))

    line = _sine_columns(block.frequency_hz or 0.0, t, block.rate_hz)
    return _strongest_nearby(power, line, 29)[0] / line


def _samples_with_hum(block: Block, force: int) -> int:
    """Samples that show the hum: of a hit those before it, where they suffice."""
    before = int(np.argmax(np.abs(block.samples[force]))) - 30
    return before if block.test == "impact" and before > 60 else block.n_samples


def remaining_hum(blocks: Sequence[Block], noise_v: Real, force: int) -> tuple[float, Real]:
    """Frequency and (rows,) V amplitude of hum too weak to be taken out, its noise subtracted; amplitudes 0 if none."""
    best, strongest = (MAINS_HZ[0], np.zeros(len(noise_v))), WEAK
    for hz in MAINS_HZ:
        with_hum = [b for b in blocks if b.test == "sine" and abs((b.frequency_hz or 0.0) - hz) > 2 * BESIDE_HZ]
        if len(with_hum) < 4:
            continue
        power = np.median(np.abs(np.array([_amplitudes(b, hz, force, 1.0) for b in with_hum])) ** 2, axis=0)
        # Under a Hann window noise scatters by 1.5 times as much; of an exponential variable the median is ln 2.
        noise = 3 * np.log(2) * noise_v**2 * 2 / with_hum[0].n_samples
        z = float(np.median(power / noise))
        if z > strongest:
            best, strongest = (hz, np.sqrt(np.maximum(power - noise, 0.0))), z
    return best
