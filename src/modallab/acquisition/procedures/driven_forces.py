"""The forces of the shakers that drive: whether each is there, and follows its own drive."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modallab.acquisition.monitor.own_drive import drive_followed_by_each_force
from modallab.bench.protocol import Waveform
from modallab.core.arrays import Real
from modallab.core.errors import SafetyError
from modallab.signals.conversion import Conversion
from modallab.storage.samples import Samples

SEEN = 3.0
"""A force is one if it is so many times what its channel shows at rest."""


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

    def require_own(self, samples: Samples, waves: Sequence[Waveform], first_s: float, rate_hz: float) -> None:
        """Reject a block in which forces follow each other's drives.

        A weak shaker may feel the others more than its own drive; but where each follows one of its own, and not its
        own, plugs have changed places.

        Args:
            samples: (channels, n) as delivered.
            waves: what each shaker plays.
            first_s: of the samples, since the waves began.
            rate_hz: of the samples.

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
