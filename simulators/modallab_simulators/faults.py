"""What goes wrong on a bench, on purpose: each fault by its name, for the simulated devices.

`apply` reads a line such as `unplugged -201003` and arms the fault in the simulated device; the names are the same
whatever the device is, and a device rejects those it cannot have.
"""

from collections import deque
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

SAMPLES_LOST = "samples-overwritten"
TIME_OUT = "time-out"
PARTIAL = "partial-read"
UNPLUGGED = "unplugged"
PLUGGED = "plugged"
RESERVED = "reserved"
RELEASED = "released"
CLIPPED = "clipped-set-point"
DEAD_LINE = "dead-line"
WARNING = "warning"
STATUS = "status"
INVALID = "invalid-task"
COERCED = "coerced-set-point"
FRONT_PANEL = "front-panel"
POWER_CYCLE = "power-cycle"
STAYS_ON = "stays-on"
SLOW = "slow-answers"
LATE = "late-answer"
ECHO = "echo"
GARBAGE = "garbage"
CUT_OFF = "cut-off-answers"
TERMINATOR = "wrong-terminator"

DAQ_FAULTS = (
    SAMPLES_LOST, TIME_OUT, PARTIAL, UNPLUGGED, PLUGGED, RESERVED, RELEASED, DEAD_LINE, WARNING, STATUS, INVALID,
)  # fmt: skip
GENERATOR_FAULTS = (
    CLIPPED, DEAD_LINE, UNPLUGGED, TIME_OUT, COERCED, FRONT_PANEL, POWER_CYCLE, STAYS_ON, SLOW, LATE, ECHO, GARBAGE,
    CUT_OFF, TERMINATOR,
)  # fmt: skip


@dataclass(slots=True)
class ArmedFault:
    """A fault that waits for its call.

    Attributes:
        call: name of the call it spoils.
        code: status it gives; 0 if it only spoils what comes back.
        kind: name of the fault.
        times: how often still.
    """

    call: str
    code: int
    kind: str
    times: int = 1


class FaultPlan:
    """Faults armed for calls, in the order they were armed."""

    def __init__(self) -> None:
        self._armed: deque[ArmedFault] = deque()

    def arm(self, fault: ArmedFault) -> None:
        """Let a fault wait."""
        self._armed.append(fault)

    def due(self, call: str) -> ArmedFault | None:
        """The fault for a call that is being made, if one waits for it."""
        for fault in self._armed:
            if fault.call == call and fault.times > 0:
                fault.times -= 1
                if fault.times == 0:
                    self._armed.remove(fault)
                return fault
        return None


def parse_fault(line: str, known: tuple[str, ...]) -> tuple[str, list[str]]:
    """Name and arguments of a fault, as an operator types it.

    Raises:
        ValueError: the device cannot have this fault.
    """
    words = line.split()
    if not words or words[0] not in known:
        raise ValueError(f"unknown fault {line!r}; known: {', '.join(known)}")
    return words[0], words[1:]


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
