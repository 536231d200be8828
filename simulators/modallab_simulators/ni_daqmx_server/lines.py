"""What stands on an analog output, now and a while back."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

MEMORY_S = 6.0
"""What was before is forgotten: no trace may look back further."""


class Wave(Protocol):
    """A voltage over bench time."""

    def volts(self, times_s: Floats) -> Floats:
        """In V at bench times in s."""
        ...


@dataclass(frozen=True, slots=True)
class Hold:
    """A constant voltage."""

    level_v: float

    def volts(self, times_s: Floats) -> Floats:
        """In V."""
        return np.full(times_s.shape, self.level_v)


@dataclass(frozen=True, eq=False, slots=True)
class Samples:
    """Samples played from a buffer, joined by the output's reconstruction filter (straight lines).

    Attributes:
        start_s: time of the first.
        rate_hz: of the output.
        data: (n,) in V.
        again: whether they are played again and again; else the last one stays.
        before_v: what stood there before.
        held: whether each sample stands until the next one, in place of the straight lines.
    """

    start_s: float
    rate_hz: float
    data: Floats
    again: bool
    before_v: float = 0.0
    held: bool = False

    @property
    def end_s(self) -> float:
        """Time of the last sample, if they are not played again."""
        return self.start_s + len(self.data) / self.rate_hz

    def volts(self, times_s: Floats) -> Floats:
        """In V."""
        place = (times_s - self.start_s) * self.rate_hz
        if self.held:
            return self._held(np.floor(place + 1e-6).astype(np.int64))
        if self.again:
            first = np.floor(place).astype(np.int64)
            part = place - first
            one, other = self.data[first % len(self.data)], self.data[(first + 1) % len(self.data)]
            return np.where(place < 0, self.before_v, one + (other - one) * part)
        known = np.arange(-1, len(self.data))
        return np.interp(place, known, np.concatenate([[self.before_v], self.data]))

    def _held(self, step: NDArray[np.int64]) -> Floats:
        count = len(self.data)
        inside = step % count if self.again else np.clip(step, 0, count - 1)
        return np.where(step < 0, self.before_v, self.data[inside])


class OutputLine:
    """One analog output: which wave stands on it since when."""

    def __init__(self) -> None:
        self._parts: list[tuple[float, Wave]] = [(-np.inf, Hold(0.0))]
        self.held = False

    def expire(self, at_s: float, volts: float) -> None:
        """A watchdog takes the output: whatever a task writes from now on is ignored until the watchdog is cleared."""
        self.put(at_s, Hold(volts))
        self.held = True

    def put(self, at_s: float, wave: Wave) -> None:
        """From `at_s` on the output follows `wave`, unless a watchdog holds it."""
        if self.held:
            return
        self._parts = [part for part in self._parts if part[0] < at_s]
        self._parts.append((at_s, wave))
        while len(self._parts) > 1 and self._parts[1][0] < at_s - MEMORY_S:
            self._parts.pop(0)

    def hold(self, at_s: float) -> None:
        """From `at_s` on what stands there then stays."""
        self.put(at_s, Hold(self.at(at_s)))

    def at(self, time_s: float) -> float:
        """Voltage at a time."""
        return float(self.volts(np.array([time_s]))[0])

    def volts(self, times_s: Floats) -> Floats:
        """In V at ascending bench times."""
        result = np.zeros(times_s.shape)
        starts = [part[0] for part in self._parts]
        for n, (start_s, wave) in enumerate(self._parts):
            end_s = starts[n + 1] if n + 1 < len(starts) else np.inf
            inside = (times_s >= start_s) & (times_s < end_s)
            if inside.any():
                result[inside] = wave.volts(times_s[inside])
        return result
