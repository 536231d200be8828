"""The reduced data of a campaign: responses per unit force on lines, in noise units, whatever drove them.

The force's noise is a rank-one part c d d^H of each line's covariance: I - (1 - 1 / sqrt(1 + c)) d d^H whitens
I + c d d^H for a unit vector d.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.core.rig import Rig
from modallab.core.units import Test
from modallab.signals.conversion import volts_per_si
from modallab.twin.response import AveragedFrfs, HitsAtPoint, SineBlocks


@dataclass(frozen=True, eq=False, slots=True)
class Rows:
    """One kind of data: responses per unit force on lines.

    Attributes:
        y: (channels, rows) measured, SI units of each channel's quantity per N.
        sigma: (channels, rows) noise of each part, real and imaginary; inf where not to be used.
        common: (rows,) variance of the force's noise along the response, in units of sigma.
        direction: (channels, rows) unit vectors of that response, whitened.
    """

    y: Complex
    sigma: Real
    common: Real
    direction: Complex

    def in_noise_units(self, residual: Complex) -> Complex:
        """Residuals (..., channels, rows) in noise units, the force's noise taken out."""
        # A complex number is divided ten times as slowly as it is multiplied.
        r = residual * (1 / self.sigma)
        if not np.any(self.common):
            return r
        along = np.einsum("cr,...cr->...r", self.direction.conj(), r)
        shrink = 1 - 1 / np.sqrt(1 + self.common)
        r -= self.direction * (shrink * along)[..., None, :]
        return r


@dataclass(frozen=True, eq=False, slots=True)
class DataPiece:
    """A piece of data with one drive point and one place in time.

    Attributes:
        name: of the hits at a point, or of the record.
        order: mean place of its records in the campaign, in records.
        drive_x_m: place of the force from the clamp, m.
        level: of the drive; None for hits.
        records: names of its records.
        orders: place in time of each; empty where they are taken together.
        test: they belong to.
    """

    name: str
    order: float
    drive_x_m: float
    level: str | None
    records: tuple[str, ...]
    orders: tuple[float, ...] = ()
    test: Test = "impact"

    @property
    def by_shaker(self) -> bool:
        """Whether a shaker hangs on the structure."""
        return self.test != "impact"


@dataclass(frozen=True, eq=False, slots=True)
class ImpactData:
    """All hits at one point that are taken together, or all records of a broadband drive."""

    piece: DataPiece
    source: HitsAtPoint | AveragedFrfs
    rows: Rows


@dataclass(frozen=True, eq=False, slots=True)
class SineData:
    """All sine blocks; rows are blocks x lines, flattened. `ratio` is the seen frequency over the one that was set."""

    pieces: tuple[DataPiece, ...]
    source: SineBlocks
    rows: Rows
    ratio: float
    ratio_sigma: float


@dataclass(frozen=True, eq=False, slots=True)
class Reduced:
    """What the fits see.

    Attributes:
        rig: the bench as believed.
        impacts: a set of lines for each drive point of hits, then for each broadband drive.
        sines: the sine test, None if there is none.
        channels: numbers of the accelerometers, 1 is the first after the force.
        x_m: (channels,) their places.
        last_order: place in time of the campaign's last record.
    """

    rig: Rig
    impacts: tuple[ImpactData, ...]
    sines: SineData | None
    channels: tuple[int, ...]
    x_m: Real
    last_order: float

    @property
    def shaker_x_m(self) -> float | None:
        """Place of the shaker from the clamp; None where none drove."""
        driven = [d.piece for d in self.impacts if d.piece.by_shaker]
        pieces = [*(() if self.sines is None else self.sines.pieces[:1]), *driven]
        return pieces[0].drive_x_m if pieces else None


def rows_of(y: Complex, sigma: Real, force_noise: Real) -> Rows:
    """Rows of (channels, rows) responses with their noise, and (rows,) noise of the force over the force."""
    whitened = y / sigma
    length = np.maximum(np.linalg.norm(whitened, axis=0), 1e-300)
    return Rows(y, sigma, (force_noise * length) ** 2, whitened / length)


@dataclass(frozen=True, eq=False, slots=True)
class Weights:
    """What each number weighs.

    Attributes:
        noise_v: (rows,) V rms of each row.
        masked: (record, row) that must not be used: cut or overloaded.
        floor: (channels, lines) two-sided density in (m/s^2)^2/Hz of what a shaking base adds; or None.
        floor_s: length of the blocks whose lines these are.
        rising_v2: power at 1 Hz, in V^2 per sample, of noise that rises as 1 / f; 0 for white noise.
        hum_v: (rows,) V amplitude of hum too weak to be taken out.
        hum_hz: its frequency.
        doubt: record -> (lines,) variance on each DFT line beside that of noise, over it.
    """

    noise_v: Real
    masked: frozenset[tuple[str, int]] = frozenset()
    floor: Real | None = None
    floor_s: float = 1.0
    rising_v2: float = 0.0
    hum_v: Real | None = None
    hum_hz: float = 50.0
    doubt: Mapping[str, Real] = field(default_factory=dict[str, Real])

    def sigma(self, rig: Rig, test: Test, lines: Real, n: int, dt: float) -> Real:
        """(channels, lines) noise per sample in SI units, on the lines of a block of n samples, dt s apart."""
        rows, hz = [c.index for c in rig.responses], np.abs(lines) / (n * dt)
        total = self._si(rig, test)[rows][:, None] * self.noise_rise(hz)[rows]
        if self.floor is None:
            return total
        at = np.minimum(np.rint(hz * self.floor_s).astype(int), self.floor.shape[1] - 1)
        # Noise of a band stands the higher above white noise of the same variance, the faster it is sampled.
        return np.sqrt(total**2 + self.floor[:, at] / dt)

    def noise_rise(self, hz: Real) -> Real:
        """(rows, hz) factor on the white noise of each row at these frequencies."""
        return np.sqrt(1 + self.rising_v2 / self.noise_v[:, None] ** 2 / np.maximum(hz, 0.5))

    def hum_amplitude(self, rig: Rig, test: Test, lines: Real, n: int, dt: float) -> Real:
        """(channels, lines) SI amplitude that hum of unknown phase leaves on the lines of a block, of n / 2."""
        if self.hum_v is None:
            return np.zeros((len(rig.responses), len(lines)))
        a = 2j * np.pi * (self.hum_hz * dt - np.abs(lines) / n)
        leaked = np.abs((1 - np.exp(a * n)) / np.where(np.abs(a) < 1e-9, 1, 1 - np.exp(a))) / n
        size = (self.hum_v / np.abs(volts_per_si(rig, test)))[[c.index for c in rig.responses]]
        return size[:, None] * np.where(np.abs(a) < 1e-9, 1.0, leaked)

    def force_noise(self, rig: Rig, test: Test) -> float:
        """Noise of the force per sample in N."""
        return float(self._si(rig, test)[rig.force_channel.index])

    def _si(self, rig: Rig, test: Test) -> Real:
        return self.noise_v / np.abs(volts_per_si(rig, test))
