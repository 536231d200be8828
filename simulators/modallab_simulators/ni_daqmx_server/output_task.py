"""Analog output: on demand, finite, or again and again until somebody stops it."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from modallab_simulators.ni_daqmx_server.acquisition import Channel, Task
from modallab_simulators.ni_daqmx_server.lines import Floats, Hold, OutputLine, Samples
from modallab_simulators.ni_daqmx_server.plant import LATENCY_S
from modallab_simulators.ni_daqmx_server.signals import BenchClock
from modallab_simulators.ni_daqmx_server.status import INVALID_VALUE, NOT_SUPPORTED_HERE, OUTPUT_UNDERFLOW, StatusError

_EMPTY = np.zeros(0)
IDLE_HOLD = 12528


@dataclass(slots=True)
class OutputTask(Task):
    """One analog output, with the `others` of its task, which do as it does.

    Attributes:
        held_steps: whether the converter holds each sample until the next one.
        generated: samples generated before it was stopped.
        starved: whether the samples did not come any more while it played.
        ppm: what its sample clock is off by while it plays.
        needs_clock: whether its converter oversamples: it takes no value on demand, and can be set for when it is idle.
        idle: what becomes of the output when nothing plays.
    """

    physical: str = ""
    line: OutputLine = field(default_factory=OutputLine)
    rate_hz: float = 0.0
    finite: bool = False
    samples: int = 0
    again: bool = True
    data: Floats = field(default_factory=lambda: _EMPTY)
    wave: Samples | None = None
    channels: list[Channel] = field(default_factory=list[Channel])
    others: list["OutputTask"] = field(default_factory=list["OutputTask"])
    held_steps: bool = False
    generated: int = 0
    starved: bool = False
    ppm: float = 0.0
    needs_clock: bool = False
    idle: int = IDLE_HOLD

    def all_channels(self) -> Sequence[Channel]:
        """Its channels, in order."""
        return self.channels

    @property
    def true_hz(self) -> float:
        """Of its sample clock in bench time."""
        return self.rate_hz * (1 + 1e-6 * self.ppm)

    def set_idle(self, behaviour: int) -> None:
        """What becomes of the output when nothing plays.

        Raises:
            StatusError: the device knows no such thing, or a task is playing.
        """
        if not self.needs_clock or self.running:
            raise StatusError(NOT_SUPPORTED_HERE, f"Property: AO.IdleOutputBehavior\nTask Name: {self.name}")
        self.idle = behaviour

    def write(self, values: Floats, clock: BenchClock) -> None:
        """Put values into the buffer, or on the output at once where there is no clock."""
        if self.rate_hz == 0 and self.needs_clock:
            raise StatusError(INVALID_VALUE, "Property: SampTimingType\nRequested Value: On Demand")
        if self.rate_hz == 0:
            self.line.put(clock.now() + LATENCY_S, Hold(float(values[-1])))
        elif self.running and self.wave is not None and not self.again:
            self.data = np.concatenate([self.data, values])
            self.wave = Samples(
                self.wave.start_s, self.true_hz, self.data, again=False, before_v=self.wave.before_v,
                held=self.held_steps,
            )  # fmt: skip
            self.line.put(self.wave.start_s, self.wave)
        else:
            self.data = values.copy()

    def start(self, clock: BenchClock, at_s: float | None = None) -> None:
        """Begin to play the buffer, now or at the bench time that a trigger or clock gives."""
        self.running, self.starved = True, False
        if self.rate_hz == 0:
            return
        at_s = clock.now() + LATENCY_S if at_s is None else at_s
        again = not self.finite and self.again
        self.wave = Samples(
            at_s, self.true_hz, self.data, again=again, before_v=self.line.at(at_s), held=self.held_steps
        )
        self.line.put(at_s, self.wave)

    def stop(self, clock: BenchClock) -> None:
        """Stop playing: the last value stays. A committed task knows how far it came, any other has forgotten it."""
        if self.running and self.wave is not None and not self.starved:
            at_s = clock.now() + LATENCY_S
            if self.wave.again:
                self.line.hold(at_s)
            else:
                self.generated = self._count(at_s)
                held = replace(self.wave, data=self.data[: self.generated])
                self.line.put(at_s, held if self.idle == IDLE_HOLD else Hold(0.0))
        if not self.kept:
            self.generated = 0
        self.running, self.wave = False, None

    def starve(self, clock: BenchClock) -> None:
        """Whoever streams the samples does so no more: the last value stays, and the task is in error."""
        for output in (self, *self.others):
            if output.running and output.wave is not None and clock.now() < output.wave.end_s:
                now_v = output.line.at(clock.now()) if output.idle == IDLE_HOLD else 0.0
                output.line.put(clock.now(), Hold(now_v))
                output.starved = True

    def done(self, clock: BenchClock) -> bool:
        """Whether it has played all it had to.

        Raises:
            StatusError: it ran out of samples that were to come.
        """
        if self.starved:
            raise StatusError(OUTPUT_UNDERFLOW, f"Task Name: {self.name}")
        if not self.running or self.rate_hz == 0:
            return True
        if self.wave is None:
            return False
        ended = not self.wave.again and clock.now() >= self.wave.end_s
        if ended and not self.finite:
            raise StatusError(OUTPUT_UNDERFLOW, f"Task Name: {self.name}")
        return ended

    def played(self, clock: BenchClock) -> int:
        """Samples generated so far."""
        return self.generated if self.wave is None else self._count(clock.now())

    def _count(self, at_s: float) -> int:
        assert self.wave is not None
        # The sample the output is on its way to, or holds, is its last if it is stopped now.
        ahead = 1 if self.held_steps else 2
        count = max(1, int((at_s - self.wave.start_s) * self.true_hz) + ahead)
        return count if self.wave.again else min(count, len(self.data))


@dataclass(slots=True)
class WatchdogTask(Task):
    """Brings outputs to a safe state when nobody resets its timer, by the clock on the wall."""

    device: str = ""
    timeout_s: float = 10.0
    states: dict[str, float] = field(default_factory=dict[str, float])
    due_s: float = float("inf")
    expired: bool = False

    def kick(self, wall_s: float) -> None:
        """Reset the timer."""
        self.due_s = wall_s + self.timeout_s if self.running and self.timeout_s >= 0 else float("inf")
