"""The forces of the shakers that drive: whether each is there and follows its own drive, or two plugs are exchanged."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modallab.bench.protocol import Waveform
from modallab.core.arrays import Complex128, Real
from modallab.core.errors import SafetyError
from modallab.signals.conversion import Conversion
from modallab.storage.samples import Samples

SEEN = 3.0
"""A force is one if it is so many times what its channel shows at rest."""
_TOGETHER = 9
"""Lines over which a force and its drive are one factor: whatever a converter delays turns them by little."""

_MUCH_MORE = 2.0
"""Times its own drive's coherence. Drives without relation have 1 / _TOGETHER, bursts, whose lines go together, 0.4."""


@dataclass(frozen=True, slots=True)
class DrivenForces:
    """The force channels of some shakers.

    Attributes:
        conversion: of the samples.
        count: shakers that drive, the first ones of the rig.
    """

    conversion: Conversion
    count: int

    def rms(self, samples: Samples) -> Real:
        """(driven,) in N, of (channels, n) as delivered."""
        return np.std(self._of(samples), axis=1)

    def require(self, samples: Samples, rest_n: Real, drive_v: float) -> None:
        """Reject a block in which a force is not above what its channel shows at rest.

        Args:
            samples: (channels, n) as delivered.
            rest_n: (driven,) rms at rest.
            drive_v: rms of the drive.

        Raises:
            SafetyError: names the channel.
        """
        for name, force_n, before_n in zip(self._names, self.rms(samples), rest_n, strict=True):
            if force_n <= SEEN * before_n:
                raise SafetyError(
                    f"the force of {name} is {force_n:.3g} N rms while {drive_v:g} V rms drive, and {before_n:.3g} N at"
                    " rest; the output was brought to 0 V",
                    remedy="check the force sensor, the amplifier and the stinger, or drive harder",
                )

    def require_own_drive(self, samples: Samples, waves: Sequence[Waveform], first_s: float, rate_hz: float) -> None:
        """Reject a block in which forces follow each other's drives.

        A weak shaker may feel the others more than its own drive; but where each follows one of its own, and not its
        own, plugs are exchanged.

        Args:
            samples: (channels, n) as delivered.
            waves: what each shaker plays.
            first_s: of the samples, since the waves began.
            rate_hz: sampling rate.

        Raises:
            SafetyError: names the channel and whose drive it follows.
        """
        if self.count < 2:
            return
        found = drive_followed_by_each_force(self._of(samples), waves, first_s, rate_hz)
        wrong = [(name, other) for n, (name, other) in enumerate(zip(self._names, found, strict=True)) if other != n]
        if wrong and sorted(found) == list(range(self.count)):
            listed = ", ".join(f"{name} follows the drive of {self._names[other]}'s shaker" for name, other in wrong)
            raise SafetyError(
                f"{listed}; the output was brought to 0 V",
                remedy="exchange the plugs of the force sensors or of the amplifiers, or correct the rig file",
            )

    @property
    def _names(self) -> list[str]:
        return [self.conversion.names[channel] for channel in self.conversion.forces[: self.count]]

    def _of(self, samples: Samples) -> Real:
        return self.conversion.forces_n(samples)[: self.count]


def drive_followed_by_each_force(forces: Real, waves: Sequence[Waveform], first_s: float, rate_hz: float) -> list[int]:
    """Which of the drives each force follows: its own, unless it follows another much more.

    Chirps are alike in one wave, whichever shaker plays them: of these each force follows its own.

    Args:
        forces: (shakers, n) in N, in the order of the waves.
        waves: what each shaker plays.
        first_s: of the samples, since the waves began.
        rate_hz: sampling rate.
    """
    window = np.hanning(forces.shape[1])
    times = first_s + np.arange(forces.shape[1]) / rate_hz
    drives = np.stack([wave.at(times) for wave in waves])
    f, d = (np.fft.rfft((rows - rows.mean(axis=1, keepdims=True)) * window) for rows in (forces, drives))
    driven = np.flatnonzero(np.sum(np.abs(d) ** 2, axis=0) > 0.01 * np.max(np.sum(np.abs(d) ** 2, axis=0)))
    alike = _coherence(f[:, driven], d[:, driven])
    most = alike.argmax(axis=1)
    own = np.diagonal(alike)
    clear = alike.max(axis=1) > _MUCH_MORE * own
    return [int(other) if sure else n for n, (other, sure) in enumerate(zip(most, clear, strict=True))]


def _coherence(forces: Complex128, drives: Complex128) -> Real:
    """(forces, drives) mean over the lines of what each drive explains of each force in _TOGETHER lines."""
    count = forces.shape[1] // _TOGETHER
    f, d = (rows[:, : count * _TOGETHER].reshape(len(rows), count, _TOGETHER) for rows in (forces, drives))
    cross = np.abs(np.einsum("fct,dct->fdc", f, d.conj())) ** 2
    powers = np.sum(np.abs(f) ** 2, axis=2)[:, None] * np.sum(np.abs(d) ** 2, axis=2)[None]
    return np.mean(cross / np.maximum(powers, np.finfo(float).tiny), axis=2)
