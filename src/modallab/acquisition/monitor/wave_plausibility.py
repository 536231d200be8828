"""While a wave plays: whether the force, and every channel with a limit, still says what the drive must make it say.

A wave has no period to carry on, so a channel is compared with the others and the drive (`others_say`), against its own
level of the last second, and against what no sound channel does: repeat a value, or end its tops at one value.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from modallab.acquisition.monitor.rest_noise import RestNoise
from modallab.acquisition.monitor.wave_samples import WaveSamples
from modallab.bench.protocol import SampleChunk, Waveform
from modallab.core.errors import SafetyError
from modallab.storage.samples import Samples

REMEDY = "check the channel's sensor, cable and input; blocks before this wave are kept, its own blocks do not count"


class WavePlausibility:
    """Holds each channel of a wave against the others and the drive; without a wave it sees nothing.

    Attributes:
        failed: whether a channel of the last wave could not be believed.
    """

    failed: bool

    def __init__(self, names: Sequence[str], forces: Sequence[int], watched: Sequence[int], rate_hz: float) -> None:
        """Watch channels.

        Args:
            names: of all channels.
            forces: force channel of each shaker that drives.
            watched: channels with limits.
            rate_hz: sampling rate of the device.
        """
        self._names, self._forces, self._rate_hz = tuple(names), tuple(forces), rate_hz
        self._watched = np.isin(np.arange(len(names)), [*forces, *watched])
        self._look: WaveSamples | None = None
        self.failed = False

    def begin(self, waves: Sequence[Waveform], start: int, rest: Samples, noise: RestNoise, period_s: float) -> None:
        """A wave begins on each shaker that drives.

        Args:
            waves: as they were asked for.
            start: their first sample.
            rest: (channels, n) delivered numbers just before it.
            noise: of the same.
            period_s: after which they repeat, or are like themselves.
        """
        self._look = WaveSamples(waves, start, rest, noise, self._rate_hz, period_s)
        self.failed = False

    def end(self) -> None:
        """The wave has ended."""
        self._look = None

    def __call__(self, chunk: SampleChunk) -> None:
        """Look at a chunk.

        Raises:
            SafetyError: names the channel and what has become of it.
        """
        look = self._look
        if look is None:
            return
        self._require(
            look.frozen_channels(chunk.samples), "is frozen: it repeats one value for longer than its noise would"
        )
        look.add(chunk)
        while look.next_hop():
            self._require(look.cut_off(), "is clipped: its highest samples are equal")
            self._require(
                look.motionless_channels(self._forces), "no longer follows the drive: dead, frozen or unplugged"
            )

    def _require(self, wrong: NDArray[np.bool_], what: str) -> None:
        found = np.flatnonzero(wrong & self._watched)
        if found.size:
            self.failed = True
            names = ", ".join(self._names[channel] for channel in found)
            raise SafetyError(f"{names} {what}; the output was brought to 0 V", remedy=REMEDY)
