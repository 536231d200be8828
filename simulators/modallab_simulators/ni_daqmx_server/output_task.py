"""Analog output and digital lines: on demand, finite, or again and again until somebody stops it."""

from dataclasses import dataclass, field, replace

import numpy as np

from modallab_simulators.ni_daqmx_server.clock import BenchClock
from modallab_simulators.ni_daqmx_server.lines import Floats, Hold, OutputLine, Samples
from modallab_simulators.ni_daqmx_server.plant import LATENCY_S
from modallab_simulators.ni_daqmx_server.status import INVALID_VALUE, NOT_SUPPORTED_HERE, OUTPUT_UNDERFLOW, StatusError
from modallab_simulators.ni_daqmx_server.tasks import Task

_EMPTY = np.zeros(0)

DELTA_SIGMA = ("NI 9260", "USB-4431", "PXI-4461", "PXIe-4463")
"""Their converters want a clock, so that nothing can be written on demand; and they know what to do when idle."""

IDLE_ZERO, IDLE_HOLD = 12526, 12528


@dataclass(slots=True)
class OutputTask(Task):
    """One analog output."""

    physical: str = ""
    line: OutputLine = field(default_factory=OutputLine)
    rate_hz: float = 0.0
    finite: bool = False
    again: bool = True
    data: Floats = field(default_factory=lambda: _EMPTY)
    wave: Samples | None = None
    generated: int = 0
    starved: bool = False
    product: str = ""
    idle: int = IDLE_HOLD

    def set_idle(self, behaviour: int) -> None:
        """What becomes of the output when nothing plays.

        Raises:
            StatusError: the device knows no such thing, or a task is playing.
        """
        if self.product not in DELTA_SIGMA or self.running:
            raise StatusError(NOT_SUPPORTED_HERE, f"Property: AO.IdleOutputBehavior\nTask Name: {self.name}")
        self.idle = behaviour

    def write(self, values: Floats, clock: BenchClock) -> None:
        """Put values into the buffer, or on the output at once where there is no clock."""
        if self.rate_hz == 0:
            if self.product in DELTA_SIGMA:
                raise StatusError(INVALID_VALUE, "Property: SampTimingType\nRequested Value: On Demand")
            self.line.put(clock.now() + LATENCY_S, Hold(float(values[-1])))
        elif self.running and self.wave is not None and not self.again:
            self.data = np.concatenate([self.data, values])
            self.wave = Samples(self.wave.start_s, self.rate_hz, self.data, again=False, before_v=self.wave.before_v)
            self.line.put(self.wave.start_s, self.wave)
        else:
            self.data = values.copy()

    def start(self, clock: BenchClock) -> None:
        """Begin to play the buffer."""
        self.running, self.starved = True, False
        if self.rate_hz == 0:
            return
        at_s = clock.now() + LATENCY_S
        again = not self.finite and self.again
        self.wave = Samples(at_s, self.rate_hz, self.data, again=again, before_v=self.line.at(at_s))
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
        if not self.committed:
            self.generated = 0
        self.running, self.wave = False, None

    def starve(self, clock: BenchClock) -> None:
        """Whoever streams the samples does so no more: the last value stays, and the task is in error."""
        if self.running and self.wave is not None and clock.now() < self.wave.end_s:
            self.line.put(clock.now(), Hold(self.line.at(clock.now()) if self.idle == IDLE_HOLD else 0.0))
            self.starved = True

    def done(self, clock: BenchClock) -> bool:
        """Whether it has played all it had to.

        Raises:
            StatusError: it ran out of samples that were to come.
        """
        if self.starved:
            raise StatusError(OUTPUT_UNDERFLOW, f"Task Name: {self.name}")
        if not self.running or self.rate_hz == 0:
            return True
        assert self.wave is not None
        ended = not self.wave.again and clock.now() >= self.wave.end_s
        if ended and not self.finite:
            raise StatusError(OUTPUT_UNDERFLOW, f"Task Name: {self.name}")
        return ended

    def played(self, clock: BenchClock) -> int:
        """Samples generated so far."""
        if self.wave is None:
            return self.generated
        return self._count(clock.now())

    def _count(self, at_s: float) -> int:
        assert self.wave is not None
        # The sample the output is on its way to is its last if it is stopped now.
        count = max(1, int((at_s - self.wave.start_s) * self.rate_hz) + 2)
        return count if self.wave.again else min(count, len(self.data))


@dataclass(slots=True)
class LineTask(Task):
    """Digital lines, of which the changes are counted."""

    lines: tuple[str, ...] = ()
    level: bool = False
    changes: int = 0
    last_change_s: float = 0.0

    def write(self, level: bool, clock: BenchClock) -> None:
        """Set the lines."""
        if level != self.level:
            self.changes += 1
            self.last_change_s = clock.now()
        self.level = level


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
