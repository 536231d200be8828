"""What every bench can be asked: real hardware, a simulator, or a replay."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from modallab.core.rig import Rig
from modallab.core.units import Test


@dataclass(frozen=True, slots=True)
class BenchInfo:
    """What answers at an address, and what it can do.

    Attributes:
        url: the address.
        devices: (name, serial) of each device.
        can_drive: whether it has an excitation output.
        real_time: whether samples arrive at the pace of the clock on the wall.
        facts: what else is known, such as a simulator's seed and true parameters, as text.
        streams_bursts: whether a burst ends midway, with the output at its last value, when this process or machine
            dies; else it goes on to its own end at 0 V.
    """

    url: str
    devices: tuple[tuple[str, str], ...]
    can_drive: bool
    real_time: bool
    facts: dict[str, str]
    streams_bursts: bool = False


@dataclass(frozen=True, slots=True)
class AcquisitionRequest:
    """How to acquire: `test` sets the preamplifiers, `rate_hz` the requested rate per channel."""

    test: Test
    rate_hz: float


@dataclass(frozen=True, eq=False, slots=True)
class DeliveredSampling:
    """What the device will deliver: its rate, type, and unit and scale per channel (rig order)."""

    requested_rate_hz: float
    actual_rate_hz: float
    rate_hz: float
    dtype: np.dtype[np.generic]
    scale: NDArray[np.float64]
    units: tuple[str, ...]


@dataclass(frozen=True, eq=False, slots=True)
class SampleChunk:
    """Contiguous samples.

    Attributes:
        first_sample: index of the first, counted by the device since `start`.
        samples: (channels, n) as delivered.
        overload: (channels,) whether a channel was beyond its range in this stretch.
    """

    first_sample: int
    samples: NDArray[np.generic]
    overload: NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Burst:
    """One finite sine on the output: rises over `ramp_s`, holds, falls over `ramp_s`, ends at exactly 0 V."""

    frequency_hz: float
    amplitude_v: float
    ramp_s: float
    hold_s: float

    @property
    def duration_s(self) -> float:
        """From 0 V to 0 V."""
        return 2 * self.ramp_s + self.hold_s

    def envelope(self, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Level at times since its start, 0 to 1: cosine tapers at both ends."""
        if self.ramp_s == 0:
            return ((times_s >= 0) & (times_s <= self.duration_s)).astype(float)
        edge = np.clip(np.minimum(times_s, self.duration_s - times_s) / self.ramp_s, 0, 1)
        return (1 - np.cos(np.pi * edge)) / 2


@dataclass(frozen=True, eq=False, slots=True)
class Waveform:
    """A finite drive of any shape.

    Attributes:
        samples: (n,) in V; the first and the last are exactly 0.
        rate_hz: at which they follow each other; another rate of the output is met by straight lines between them.
    """

    samples: NDArray[np.float64]
    rate_hz: float

    @property
    def duration_s(self) -> float:
        """From 0 V to 0 V."""
        return (len(self.samples) - 1) / self.rate_hz

    def at(self, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """In V at times since its beginning; exactly 0 outside."""
        return np.interp(times_s * self.rate_hz, np.arange(len(self.samples)), self.samples, left=0.0, right=0.0)


@runtime_checkable
class Bench(Protocol):
    """A bench: inputs that stream, and perhaps one excitation output. One owner, one thread.

    Every method may raise DeviceGoneError. The order is configure, start, then read and play; `zero`, `stop`
    and `close` are legal in every state and never raise for having nothing to do.
    """

    @property
    def info(self) -> BenchInfo:
        """What this bench is."""
        ...

    def configure(self, request: AcquisitionRequest) -> DeliveredSampling:
        """Set rate and ranges. Raises ConfigurationError, DeviceBusyError."""
        ...

    def start(self) -> None:
        """Start streaming; the device's sample count begins at 0."""
        ...

    def read(self, count: int, timeout_s: float) -> SampleChunk:
        """The next `count` samples, without a gap. Raises BenchTimeoutError, SamplesLostError, ConfigurationError."""
        ...

    def play(self, burst: Burst) -> int:
        """Start a burst; returns the sample count at which its rise begins. Raises UnsupportedError."""
        ...

    def prompt_hit(self, point: int) -> None:
        """Notify whoever swings the hammer that a hit at `point` is requested. Hardware has nothing to do here."""
        ...

    def zero(self) -> None:
        """Bring the output to 0 V now, by a fall where a burst is on and the device answers (`bench.fall`)."""
        ...

    def stop(self) -> None:
        """Stop streaming, with the output at 0 V."""
        ...

    def close(self) -> None:
        """Release the device, with the output at 0 V."""
        ...


class BenchOpener(Protocol):
    """What an entry point of the group `modallab.backends` names."""

    def __call__(self, url: str, rig: Rig) -> Bench:
        """Open the bench at `url`. Raises DeviceGoneError, DeviceBusyError, ConfigurationError."""
        ...


class OutputHandle(Protocol):
    """A second handle to an excitation output, in another process than the one that drives; it can only end it."""

    def zero(self) -> None:
        """Bring the output to 0 V, whoever drives it. Raises BenchError."""
        ...

    def release(self) -> None:
        """Bring the output to 0 V and give back what an owner that died still holds. Raises BenchError."""
        ...

    def close(self) -> None:
        """Let go."""
        ...


class OutputOpener(Protocol):
    """What an entry point of the group `modallab.outputs` names."""

    def __call__(self, url: str, rig: Rig) -> OutputHandle:
        """A handle to the output of the bench at `url`. Raises BenchError."""
        ...


@dataclass(frozen=True, slots=True)
class FoundDevice:
    """A device that was found.

    Attributes:
        address: to open it by.
        what: it is, in words.
    """

    address: str
    what: str


class DeviceFinder(Protocol):
    """What an entry point of the group `modallab.devices` names."""

    def __call__(self, address: str) -> list[FoundDevice]:
        """Devices of this family: here if `address` is empty, else behind it. Nothing found is no error."""
        ...
