"""The time of the simulated bench, and pulses on its terminals."""

import time
from dataclasses import dataclass
from math import ceil, floor, inf


class BenchClock:
    """Seconds since the bench was switched on.

    With `pace` it runs as the clock on the wall does. Without, it stands still until samples are read, and then goes
    on by just as much: a test then takes no time, and repeats itself exactly.
    """

    def __init__(self, pace: bool) -> None:
        self.pace = pace
        self._began_s = time.monotonic()
        self._virtual_s = 0.0

    def now(self) -> float:
        """Bench time in s."""
        return time.monotonic() - self._began_s if self.pace else self._virtual_s

    def read_up_to(self, time_s: float) -> None:
        """Samples up to a time were read: without pace it has then come."""
        self._virtual_s = max(self._virtual_s, time_s)


TIMEBASES = {"100MHzTimebase": 100e6, "80MHzTimebase": 80e6, "20MHzTimebase": 20e6, "10MHzRefClock": 10e6,
             "100kHzTimebase": 100e3, "PXI_Clk10": 10e6, "PXIe_Clk100": 100e6}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Pulses:
    """A train of pulses.

    Attributes:
        start_s: time of the first rising edge.
        frequency_hz: of the pulses.
        duty: part of a period for which it is high.
        count: how many pulses there are; inf: without end.
    """

    start_s: float
    frequency_hz: float
    duty: float = 0.5
    count: float = inf

    def edge_after(self, at_s: float, rising: bool = True) -> float | None:
        """Time of the first edge at or after a time; None if none comes any more."""
        first = self.start_s + (0.0 if rising else self.duty / self.frequency_hz)
        place = max(0, ceil((at_s - first) * self.frequency_hz - 1e-6))
        return first + place / self.frequency_hz if place < self.count else None

    def edges_until(self, at_s: float) -> int:
        """Rising edges by a time."""
        passed = floor((at_s - self.start_s) * self.frequency_hz) + 1
        return int(min(max(passed, 0), self.count))

    def high(self, at_s: float) -> bool:
        """Level at a time."""
        turns = (at_s - self.start_s) * self.frequency_hz
        return 0 <= turns < self.count and turns % 1 < self.duty
