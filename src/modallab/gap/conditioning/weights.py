"""What each number of the reduced data weighs: the noise of its row, and what else no model predicts."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from modallab.core.arrays import Real
from modallab.core.rig import Rig
from modallab.core.units import Test
from modallab.signals.conversion import volts_per_si


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
        total = self._si(rig, test)[rows][:, None] * self.rise(hz)[rows]
        if self.floor is None:
            return total
        at = np.minimum(np.rint(hz * self.floor_s).astype(int), self.floor.shape[1] - 1)
        # Noise of a band stands the higher above white noise of the same variance, the faster it is sampled.
        return np.sqrt(total**2 + self.floor[:, at] / dt)

    def rise(self, hz: Real) -> Real:
        """(rows, hz) factor on the white noise of each row at these frequencies."""
        return np.sqrt(1 + self.rising_v2 / self.noise_v[:, None] ** 2 / np.maximum(hz, 0.5))

    def hum(self, rig: Rig, test: Test, lines: Real, n: int, dt: float) -> Real:
        """(channels, lines) SI amplitude that hum of unknown phase leaves on the lines of a block, of n / 2."""
        if self.hum_v is None:
            return np.zeros((len(rig.responses), len(lines)))
        a = 2j * np.pi * (self.hum_hz * dt - np.abs(lines) / n)
        leaked = np.abs((1 - np.exp(a * n)) / np.where(np.abs(a) < 1e-9, 1, 1 - np.exp(a))) / n
        size = (self.hum_v / np.abs(volts_per_si(rig, test)))[[c.index for c in rig.responses]]
        return size[:, None] * np.where(np.abs(a) < 1e-9, 1.0, leaked)

    def force(self, rig: Rig, test: Test) -> float:
        """Noise of the force per sample in N."""
        return float(self._si(rig, test)[rig.force_channel.index])

    def _si(self, rig: Rig, test: Test) -> Real:
        return self.noise_v / np.abs(volts_per_si(rig, test))
