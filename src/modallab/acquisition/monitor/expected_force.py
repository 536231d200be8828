"""Whether the force is there while the drive is on, and within what the last burst gave for this drive."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.acquisition.monitor.burst_windows import BurstWindows
from modallab.acquisition.monitor.tone_prediction import PredictedWindow
from modallab.core.errors import SafetyError

SEEN = 4.0
"""A tone so many times above what noise makes of it is seen."""

OTHERS_SEEN = 100.0
OTHERS_FROM = 0.1
"""Where another channel is seen so clearly, from this part of the drive on, the force must be seen."""

FORCE_BRACKET = 30.0
"""The force per volt may change so much from one frequency to another; at a resonance it drops."""

SAME_FREQUENCY = 0.002
SAME_BRACKET = 2.0
"""The same limit between two settled bursts at one frequency."""

REMEDY = "check the channel's sensor, cable and input; earlier blocks are kept, the current block is not"


@dataclass(frozen=True, slots=True)
class LastBurst:
    """What a settled burst gave: force in N per volt of the drive."""

    frequency_hz: float
    force_n_per_v: float


class ExpectedForce:
    """Remembers the force of the last settled burst, and holds the next one against it.

    Attributes:
        last: settled burst; None before the first.
    """

    last: LastBurst | None

    def __init__(self, name: str, channel: int, newton_per_volt: float) -> None:
        """For the force's channel.

        Args:
            name: of the channel.
            channel: its place.
            newton_per_volt: force in N per V of its signal.
        """
        self._name, self._channel, self._scale = name, channel, newton_per_volt
        self.last = None

    def check_settled_force(self, frequency_hz: float, force_n: float, volts: float) -> None:
        """Hold the force of a settled block against the last burst, and remember it.

        Raises:
            SafetyError: it is no force, or not what this drive gave before at this frequency.
        """
        if not np.isfinite(force_n) or force_n <= 0:
            raise implausible_channel_error(f"{self._name} reads {force_n:g} N at {volts:g} V of drive")
        found, last = force_n / volts, self.last
        if last is not None and abs(frequency_hz / last.frequency_hz - 1) <= SAME_FREQUENCY:
            change = found / last.force_n_per_v
            if not 1 / SAME_BRACKET <= change <= SAME_BRACKET:
                raise implausible_channel_error(
                    f"{self._name} reads {found:.4g} N per V of drive at {frequency_hz:g} Hz, where the"
                    f" previous burst gave {last.force_n_per_v:.4g} N per V"
                )
        self.last = LastBurst(frequency_hz, found)

    def is_plausible_force(self, look: BurstWindows, foreseen: PredictedWindow) -> NDArray[np.bool_]:
        """(looks,) whether the force is seen, and within the bracket or no clean tone; of many looks at once."""
        force = self._channel
        level, misfit = foreseen.level[:, force], foreseen.misfit[:, force]
        seen = np.sqrt(2) * level > SEEN * look.sigma_v[force]
        if self.last is None:
            return seen
        change = foreseen.amplitude[:, force] * self._scale / look.burst.amplitude_v / self.last.force_n_per_v
        return seen & ((misfit >= 0.1 * level) | ((change >= 1 / FORCE_BRACKET) & (change <= FORCE_BRACKET)))

    def require_force(self, look: BurstWindows, foreseen: PredictedWindow) -> None:
        """The force must be seen once another channel is, or the burst is at full level; and within the bracket."""
        least = SEEN * look.sigma_v
        tone = np.sqrt(2) * foreseen.level
        drive = look.envelope_earlier
        force = self._channel
        per_v = self._scale / look.burst.amplitude_v
        if tone[force] <= least[force]:
            others = np.delete(tone > OTHERS_SEEN * look.sigma_v, force)
            expected = self.last.force_n_per_v / FORCE_BRACKET / per_v * drive if self.last else 0.0
            if (others.any() and drive > OTHERS_FROM) or look.are_steady() or expected > least[force]:
                raise implausible_channel_error(
                    f"{self._name} shows no force at {look.burst.amplitude_v * drive:.3g} V of drive"
                )
        elif self.last is not None and foreseen.misfit[force] < 0.1 * foreseen.level[force]:
            change = foreseen.amplitude[force] * per_v / self.last.force_n_per_v
            if not 1 / FORCE_BRACKET <= change <= FORCE_BRACKET:
                raise implausible_channel_error(
                    f"{self._name} reads {change:.3g} times the force per volt of the previous burst, at"
                    f" {self.last.frequency_hz:g} Hz"
                )


def implausible_channel_error(what: str) -> SafetyError:
    """The error that says what a channel does, and that the output was brought to 0 V."""
    return SafetyError(f"{what}; the output was brought to 0 V", remedy=REMEDY)
