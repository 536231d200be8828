"""Analog output: on demand, finite, or again and again until somebody stops it."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from modallab_simulators.ni_daqmx_server.clock import BenchClock
from modallab_simulators.ni_daqmx_server.lines import Floats, Hold, OutputLine, Samples
from modallab_simulators.ni_daqmx_server.plant import LATENCY_S
from modallab_simulators.ni_daqmx_server.status import OUTPUT_UNDERFLOW, StatusError
from modallab_simulators.ni_daqmx_server.tasks import Channel, Task

_EMPTY = np.zeros(0)


@dataclass(slots=True)
class OutputTask(Task):
    """One analog output, with the `others` of its task, which do as it does.

    Attributes:
        held_steps: whether the converter holds each sample until the next one.
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

    def all_channels(self) -> Sequence[Channel]:
        """Its channels, in order."""
        return self.channels

    def write(self, values: Floats, clock: BenchClock) -> None:
        """Put values into the buffer, or on the output at once where there is no clock."""
        if self.rate_hz == 0:
            self.line.put(clock.now() + LATENCY_S, Hold(float(values[-1])))
        elif self.running and self.wave is not None and not self.again:
            self.data = np.concatenate([self.data, values])
            self.wave = Samples(
                self.wave.start_s, self.rate_hz, self.data, again=False, before_v=self.wave.before_v,
                held=self.held_steps,
            )  # fmt: skip
            self.line.put(self.wave.start_s, self.wave)
        else:
            self.data = values.copy()

    def start(self, clock: BenchClock, at_s: float | None = None) -> None:
        """Begin to play the buffer, now or at the bench time that a trigger or clock gives."""
        self.running = True
        if self.rate_hz == 0:
            return
        at_s = clock.now() + LATENCY_S if at_s is None else at_s
        again = not self.finite and self.again
        self.wave = Samples(
            at_s, self.rate_hz, self.data, again=again, before_v=self.line.at(at_s), held=self.held_steps
        )
        self.line.put(at_s, self.wave)

    def stop(self, clock: BenchClock) -> None:
        """Stop playing: the last value stays."""
        if self.running and self.wave is not None:
            self.line.hold(clock.now() + LATENCY_S)
        self.running, self.wave = False, None

    def done(self, clock: BenchClock) -> bool:
        """Whether it has played all it had to.

        Raises:
            StatusError: it ran out of samples that were to come.
        """
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
        if self.wave is None:
            return 0
        count = max(0, int((clock.now() - self.wave.start_s) * self.rate_hz))
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
