"""A channel that fails at a moment, on any bench: dead, frozen, unplugged, clipped, or in another's place."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from modallab.bench.capabilities import DrivesSeveralShakers, PlaysWaves
from modallab.bench.protocol import (
    AcquisitionRequest,
    Bench,
    BenchInfo,
    Burst,
    DeliveredSampling,
    SampleChunk,
    Waveform,
)

Kind = Literal["dead", "frozen", "unplugged", "clipped", "swapped"]
KINDS: tuple[Kind, ...] = ("dead", "frozen", "unplugged", "clipped", "swapped")

UNPLUGGED_DECAY_S = 0.01
"""Time constant with which an input falls to nothing once its sensor is gone."""

LOOK_BACK_S = 0.5
"""A clipped channel is cut at a part of what it reached in so long before."""


@dataclass(frozen=True, slots=True)
class ChannelFault:
    """What fails, and when in a burst.

    Attributes:
        kind: dead: zero; frozen: the last value; unplugged: the input's noise alone; clipped: cut below the peak;
            swapped: the plugs of two channels change places.
        channel: that fails.
        burst: number of the burst it fails in, from 1.
        part: of the burst's duration after which it fails; below 0: while all rests before it.
        other: what it is swapped with.
        level: part of its peak at which it is clipped.
        noise: rms of an unplugged input, as delivered.
    """

    kind: Kind
    channel: int
    burst: int = 1
    part: float = 0.5
    other: int = 0
    level: float = 0.5
    noise: float = 1.0


class FaultyBench:
    """Passes everything on to a bench, and what it delivers through a fault.

    Attributes:
        at: sample from which on the channel fails; None before it is known.
        sound: the samples last read, as they were without the fault.
    """

    sound: NDArray[np.generic]

    def __init__(self, bench: Bench, fault: ChannelFault, seed: int = 0) -> None:
        self.at: int | None = None
        self._bench, self._fault = bench, fault
        self._rng = np.random.default_rng(seed)
        self._bursts = 0
        self._rate_hz = 0.0
        self._held: float | None = None
        self._past: NDArray[np.generic] | None = None

    @property
    def info(self) -> BenchInfo:
        """Of the bench."""
        return self._bench.info

    def configure(self, request: AcquisitionRequest) -> DeliveredSampling:
        """As the bench does."""
        delivery = self._bench.configure(request)
        self._rate_hz = delivery.rate_hz
        return delivery

    def start(self) -> None:
        """As the bench does."""
        self._bench.start()

    def read(self, count: int, timeout_s: float) -> SampleChunk:
        """As the bench does, with the fault."""
        chunk = self._bench.read(count, timeout_s)
        self.sound = chunk.samples
        past = chunk.samples if self._past is None else np.concatenate([self._past, chunk.samples], axis=1)
        self._past = past[:, -round(LOOK_BACK_S * self._rate_hz) :]
        if self.at is None or chunk.first_sample + count <= self.at:
            return chunk
        begin = max(0, self.at - chunk.first_sample)
        samples = chunk.samples.copy()
        samples[:, begin:] = self._spoiled(samples[:, begin:], past[:, past.shape[1] - count + begin - 1])
        return replace(chunk, samples=samples)

    def play(self, burst: Burst) -> int:
        """As the bench does; the fault's moment is now known."""
        return self._begun(self._bench.play(burst), burst)

    def play_wave(self, wave: Waveform) -> int:
        """As the bench does; a wave counts as a burst."""
        assert isinstance(self._bench, PlaysWaves)
        return self._begun(self._bench.play_wave(wave), wave)

    def play_waves(self, waves: Sequence[Waveform]) -> int:
        """As the bench does; waves of several shakers count as one burst."""
        assert isinstance(self._bench, DrivesSeveralShakers)
        return self._begun(self._bench.play_waves(waves), waves[0])

    def prompt_hit(self, point: int) -> None:
        """As the bench does."""
        self._bench.prompt_hit(point)

    def zero(self) -> None:
        """As the bench does."""
        self._bench.zero()

    def stop(self) -> None:
        """As the bench does."""
        self._bench.stop()

    def close(self) -> None:
        """As the bench does."""
        self._bench.close()

    def _begun(self, start: int, wave: Burst | Waveform) -> int:
        self._bursts += 1
        if self._bursts == self._fault.burst:
            self.at = start + round(self._fault.part * wave.duration_s * self._rate_hz)
        return start

    def _spoiled(self, samples: NDArray[np.generic], before: NDArray[np.generic]) -> NDArray[np.generic]:
        fault, own = self._fault, samples[self._fault.channel].astype(float)
        if fault.kind == "swapped":
            rows = list(range(len(samples)))
            rows[fault.channel], rows[fault.other] = fault.other, fault.channel
            return samples[rows]
        if self._held is None:
            assert self._past is not None
            last = float(before[fault.channel])
            peak = float(np.abs(self._past[fault.channel].astype(float)).max())
            self._held = fault.level * peak if fault.kind == "clipped" else last
        if fault.kind == "dead":
            own[:] = 0.0
        elif fault.kind == "frozen":
            own[:] = self._held
        elif fault.kind == "unplugged":
            fading = self._held * np.exp(-np.arange(1, own.size + 1) / (UNPLUGGED_DECAY_S * self._rate_hz))
            self._held = float(fading[-1])
            own = fading + self._rng.normal(0.0, fault.noise, own.size)
        else:
            own = np.clip(own, -self._held, self._held)
        if samples.dtype.kind in "iu":
            own = np.rint(own)
        spoiled = samples.copy()
        spoiled[fault.channel] = own.astype(samples.dtype)
        return spoiled
