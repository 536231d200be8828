"""While a burst is on: whether the force, and every channel with a limit, still says what the drive must make it say.

A chunk holds many looks where time is virtual, or where a device delivers late. Taken one by one they cost a third of
the time in which a sine test is recorded; together they are a few products of matrices. The tests are those of
`plausibility`, at the same thresholds: a look that is not normal is looked at there, with all that may excuse it.

A dead channel looks safe to a limit, and like too little force to a force control. So a burst goes on only as long as
each of these channels follows the drive as it did a moment ago (`tone_prediction`), does not repeat one value, and the
force is there at all and within what the last burst gave for this drive. A channel whose motion lies under its noise
cannot be compared with anything; it is judged by repetition alone until it moves.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.acquisition.monitor.burst_windows import HOP_S, WEAK_EARLIER_S, WEAK_LATER_S, BurstWindows, is_driven
from modallab.acquisition.monitor.expected_force import OTHERS_FROM, SEEN, ExpectedForce, implausible_channel_error
from modallab.acquisition.monitor.rest_noise import RestNoise
from modallab.acquisition.monitor.tone_prediction import (
    PredictedWindow,
    channel_faults,
    departs_from_drive,
    departs_from_prediction,
    is_dead,
    is_noise_alone,
    predict_later_window,
    rms_of_steady_share,
    tone_is_lost,
)
from modallab.bench.protocol import Burst, SampleChunk
from modallab.core.arrays import Complex128, Real
from modallab.storage.samples import Samples

FEW = 3
"""Fewer looks than these are taken one by one as quickly."""


@dataclass(frozen=True, eq=False, slots=True)
class NormalRanges:
    """Some looks one after another.

    Attributes:
        first: number of the first.
        normal: (looks,)
        tone: (looks, channels) as `BurstWindows.tone`.
        moments: (looks, channels, channels) what each adds to the moments of the motion.
        learned: samples of each that these hold.
    """

    first: int
    normal: NDArray[np.bool_]
    tone: NDArray[np.complex128]
    moments: Real
    learned: int

    def learn_if_normal(self, look: BurstWindows) -> bool:
        """Whether the look that has just been gone on to is normal; if so, what it teaches is taken in."""
        place = look.hop - self.first
        if not self.normal[place]:
            return False
        look.places.add_moments(self.moments[place], self.learned)
        look.tone = self.tone[place]
        look.gone = np.zeros_like(look.gone)
        return True


def normal_ranges_of_windows(look: BurstWindows, force: ExpectedForce) -> NormalRanges | None:
    """Of all looks for which the samples have come; None where there are few, or not all windows lie in the burst."""
    ends = look.ends_of_complete_windows()
    later, weak, learned = look.count(look.later_s), look.count(WEAK_LATER_S), look.count(HOP_S)
    if len(ends) < FEW or not look.holds_windows(ends, max(weak, later + look.gap + max(look.earlier, learned))):
        return None
    latest = look.windows(ends, later)
    before = ends - later - look.gap
    earlier, following = look.drive_columns(before, look.earlier), look.drive_columns(ends, later)
    foreseen = predict_later_window(look.windows(before, look.earlier), earlier, following)
    kept, moments = look.places.consistent_with_shapes(look.windows(before, learned), latest)
    size = np.sqrt(2) * foreseen.level / look.sigma_v
    suspect = (
        departs_from_prediction(latest, foreseen, look.noise_v)
        | is_dead(latest, foreseen, look.white_v)
        | is_noise_alone(look.windows(ends, weak), look.white_v)
        | ~(size > SEEN)
    )
    normal = kept & ~suspect.any(axis=1) & force.is_plausible_force(look, foreseen) & is_driven(earlier)
    return NormalRanges(look.hop + 1, normal, size * foreseen.phase, moments, learned)


GONE_LOOKS = 3
"""A tone is gone after so many looks in a row."""

KEPT_UP = 0.5
"""Where the other responses fall to this part of what was foreseen, the structure itself may beat."""

NODE = 0.02
"""Part of the largest response below which a channel stands near a node. While the drive rises or falls in a second, a
mode some ten Hz away lags its envelope by a few percent, each by another: what little is left at a node may vanish."""

MISSED = 25 * SEEN
"""A response that must be seen so clearly is not there."""
_MOST = 24
"""Shapes that are remembered, the latest."""

_KEPT_PART = 0.01
"""What is below this part of the largest direction of all shapes is noise."""

_SURE = 5.0
"""What a channel must read stands so many times above what the combination leaves of the others."""


class Plausibility:
    """Holds each channel of a burst against the drive; at rest it sees nothing."""

    def __init__(
        self, names: Sequence[str], si_per_count: Real, volts: Real, force: int, watched: Sequence[int], rate_hz: float
    ) -> None:
        """Watch channels.

        Args:
            names: of all channels.
            si_per_count: (channels,) SI units per delivered number.
            volts: (channels,) V, or whatever all share, per delivered number: a plug that is swapped swaps these.
            force: the force's channel.
            watched: channels of force and of limits.
            rate_hz: sampling rate of the device.
        """
        self._names, self._volts, self._force_row = tuple(names), np.abs(volts), force
        self._force = ExpectedForce(names[force], force, float(np.abs(si_per_count[force] / volts[force])))
        self._watched = np.isin(np.arange(len(names)), watched)
        self._rate_hz = rate_hz
        self._burst: BurstWindows | None = None
        self._responses = np.delete(np.arange(len(names)), force)
        self._shapes = KnownShapes()

    def begin(self, burst: Burst, start: int, rest: Samples, noise: RestNoise, unseen: int) -> None:
        """A burst begins.

        Args:
            burst: as it was asked for.
            start: sample its rise begins with.
            rest: (channels, n) delivered numbers just before it.
            noise: of the same.
            unseen: the next sample that a chunk will bring.
        """
        self._burst = BurstWindows(burst, start, self._rate_hz, rest, self._volts, noise, unseen)

    def end(self) -> None:
        """The burst has ended."""
        self._burst = None

    def check_settled_force(self, frequency_hz: float, force_n: float, volts: float) -> None:
        """Hold the force of a settled block against the last burst, and remember it.

        Raises:
            SafetyError: it is no force, or not what this drive gave before at this frequency.
        """
        self._force.check_settled_force(frequency_hz, force_n, volts)
        if self._burst is not None and self._burst.tone is not None:
            self._shapes.add_burst(self._burst.tone[self._responses])

    def __call__(self, chunk: SampleChunk) -> None:
        """Look at a chunk.

        Raises:
            SafetyError: names the channel and what has become of it.
        """
        look = self._burst
        if look is None:
            return
        run = look.repetition.longest_runs(chunk.samples)
        frozen = np.flatnonzero(self._watched & (run >= look.noise.longest_run))
        if frozen.size:
            first = int(frozen[0])
            raise implausible_channel_error(f"{self._names[first]} repeats one value for {run[first]} samples: frozen")
        cut = np.flatnonzero(self._watched & look.cut_off(chunk.samples))
        if cut.size:
            raise implausible_channel_error(f"{self._names[int(cut[0])]} is clipped: all its highest samples are equal")
        look.add(chunk.samples)
        normal = normal_ranges_of_windows(look, self._force)
        while look.next_hop():
            if normal is None or not normal.learn_if_normal(look):
                self._require_all(look)

    def _require_all(self, look: BurstWindows) -> None:
        places = look.exchanged_channels()
        if places is not None and self._watched[list(places)].any():
            one, other = (self._names[channel] for channel in places)
            raise implausible_channel_error(f"{one} and {other} are exchanged")
        pair = look.predicted_window(look.later_s)
        if pair is None:
            return
        for channel, reason in channel_faults(*pair, look.noise_v, look.white_v).items():
            if self._watched[channel]:
                raise implausible_channel_error(f"{self._names[channel]} {reason.format(*self._names)}")
        gone = self._unless_beats(is_dead(*pair, look.white_v), *pair)
        # The responses may beat; the force follows the drive directly.
        gone[self._force_row] |= departs_from_drive(*pair, look.noise_v)[self._force_row]
        # What stands above its noise is not lost, and needs no fit.
        if is_noise_alone(look.latest_samples(WEAK_LATER_S), look.white_v).any():
            weak = look.predicted_window(WEAK_LATER_S, WEAK_EARLIER_S)
            if weak is not None:
                gone |= self._unless_beats(tone_is_lost(*weak, look.white_v) & ~self._at_a_node(look, weak[1]), *weak)
        gone |= self._missing(look, pair[1])
        look.gone = np.where(gone, look.gone + 1, 0)
        for channel in np.flatnonzero((look.gone >= GONE_LOOKS) & self._watched):
            raise implausible_channel_error(
                f"{self._names[channel]} no longer follows the drive: dead, frozen or unplugged"
            )
        self._force.require_force(look, pair[1])

    def _at_a_node(self, look: BurstWindows, foreseen: PredictedWindow) -> NDArray[np.bool_]:
        """(channels,) whether a response may vanish near a node, since the drive rises or falls."""
        if look.are_steady(WEAK_LATER_S, WEAK_EARLIER_S):
            return np.zeros(foreseen.level.size, dtype=np.bool_)
        node = foreseen.level < NODE * foreseen.level[self._responses].max()
        node[self._force_row] = False
        return node

    def _missing(self, look: BurstWindows, foreseen: PredictedWindow) -> NDArray[np.bool_]:
        """(channels,) whether a response shows nothing that must be seen, by the others and the bursts before."""
        tone = look.tone = np.sqrt(2) * foreseen.level / look.sigma_v * foreseen.phase
        unseen = np.abs(tone) <= SEEN
        unseen[self._force_row] = False
        if look.envelope_earlier < OTHERS_FROM or not unseen.any():
            return np.zeros(unseen.size, dtype=np.bool_)
        responses = self._responses
        for place in np.flatnonzero(unseen[responses]):
            unseen[responses[place]] = self._shapes.must_read(int(place), tone[responses]) > MISSED
        return unseen

    def _unless_beats(self, gone: NDArray[np.bool_], seen: Real, foreseen: PredictedWindow) -> NDArray[np.bool_]:
        """(channels,) without those whose fall may be the structure's own beat: the other responses fall too."""
        follows = rms_of_steady_share(seen, foreseen) if gone.any() else np.zeros(0)
        for channel in np.flatnonzero(gone):
            others = np.delete(follows, np.array([self._force_row, int(channel)]))
            gone[channel] = channel == self._force_row or not others.size or np.median(others) >= KEPT_UP
        return gone


class KnownShapes:
    """Remembers the responses to the bursts that have settled, and says what a response must read of a tone.

    A channel that shows nothing may be dead, or stand in a node of this frequency's shape. Where the other responses
    are a combination of shapes that were seen before, the same combination says what the channel must read; where they
    are not, nothing follows.
    """

    def __init__(self) -> None:
        self._shapes: list[Complex128] = []
        self._sizes: list[float] = []

    def add_burst(self, tone: Complex128) -> None:
        """Remember the (responses,) complex amplitudes of a burst, over their noise."""
        size = float(np.linalg.norm(tone))
        if size > 0:
            self._shapes = [*self._shapes, tone / size][-_MOST:]
            self._sizes = [*self._sizes, size][-_MOST:]

    def must_read(self, channel: int, tone: Complex128) -> float:
        """The least that one of (responses,) must read, over its noise, by the others; 0 where nothing is known."""
        if not self._shapes or tone.size < 2:
            return 0.0
        shapes = np.array(self._shapes).T
        others = np.delete(np.arange(tone.size), channel)
        left, sizes, right = np.linalg.svd(shapes[others], full_matrices=False)
        kept = sizes > _KEPT_PART * sizes[0]
        parts = left[:, kept].conj().T @ tone[others]
        combination = right[kept].conj().T @ (parts / sizes[kept])
        left_over = np.linalg.norm(tone[others] - left[:, kept] @ parts)
        # The shapes themselves are known to their own noise only.
        unsure = np.linalg.norm(combination / np.array(self._sizes))
        return max(0.0, float(np.abs(shapes[channel] @ combination) - _SURE * (left_over + unsure)))
