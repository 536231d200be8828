"""What plays on analog outputs is ended by a fall from the value each has, by whoever reaches their task.

A finite burst lies whole in its buffer and can't be changed while it plays. So it is stopped, whereupon the output
holds the last sample; how many were generated says which one that is; and the same task then plays the fall from there.
The task is committed before it starts: when it is stopped it keeps the output and the count. What is played is written
into the description of its channel, so that another process knows it too: a burst by its numbers, a wave by the name of
a file that holds its samples for as long as it plays.
"""

import os
import re
import tempfile
import time
from collections.abc import Generator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import nidaqmx.errors
import numpy as np
from nidaqmx.constants import AcquisitionType, AOIdleOutputBehavior, Edge
from numpy.typing import NDArray

from modallab.bench.protocol import Burst
from modallab.bench.ramp_down import ramp_down_samples
from modallab.core.child_process import FileLock
from modallab.core.errors import ConfigurationError
from modallab_drivers.ni_daqmx.errors import typed_error
from modallab_drivers.output import burst_samples

DESCRIPTION = 0x1926
GENERATED = 0x192B
OUTPUT_BUFFER = 0x186D
IDLE = 0x2240
FALLING = "modallab: falls to 0 V"
BEGIN_S = 0.25
"""Whoever has begun to stop a task has by then begun its fall, or is frozen."""
SHAPED = "modallab-wave"
"""Before the rate and the file of a wave."""


@dataclass(frozen=True, slots=True)
class TaskSignal:
    """What a task plays.

    Attributes:
        burst: from its start.
        rate_hz: of the output.
    """

    burst: Burst
    rate_hz: float

    def described(self) -> str:
        """For the channel's description."""
        b = self.burst
        return " ".join(map(repr, (b.frequency_hz, b.amplitude_v, b.ramp_s, b.hold_s, float(self.rate_hz))))

    def wave(self) -> tuple[NDArray[np.float64], float]:
        """(n,) in V, and their rate."""
        return burst_samples(self.burst, self.rate_hz), self.rate_hz

    @classmethod
    def zeros(cls, count: int, rate_hz: float) -> Self:
        """0 V for so many samples, on an output that nothing is played on while others play."""
        return cls(Burst(1.0, 0.0, 0.0, (count - 1) / rate_hz), rate_hz)

    @classmethod
    def read(cls, text: str) -> Self:
        """From a channel's description.

        Raises:
            ValueError: it is no burst of ours.
        """
        frequency_hz, amplitude_v, ramp_s, hold_s, rate_hz = map(float, text.split())
        return cls(Burst(frequency_hz, amplitude_v, ramp_s, hold_s), rate_hz)


@dataclass(frozen=True, eq=False, slots=True)
class TaskWave:
    """What a task plays that is no sine.

    Attributes:
        samples: (n,) in V.
        rate_hz: of the output.
        file: that holds them, for other processes of this machine.
    """

    samples: NDArray[np.float64]
    rate_hz: float
    file: Path

    @classmethod
    def kept(cls, samples: NDArray[np.float64], rate_hz: float) -> Self:
        """With its samples written to a new file."""
        handle, name = tempfile.mkstemp(prefix="modallab-wave-", suffix=".npy")
        with os.fdopen(handle, "wb") as file:
            np.save(file, samples, allow_pickle=False)
        return cls(samples, rate_hz, Path(name))

    def described(self) -> str:
        """For the channel's description."""
        return f"{SHAPED} {float(self.rate_hz)!r} {self.file}"

    def wave(self) -> tuple[NDArray[np.float64], float]:
        """(n,) in V, and their rate."""
        return self.samples, self.rate_hz

    def forget(self) -> None:
        """Remove the file."""
        self.file.unlink(missing_ok=True)

    @classmethod
    def read(cls, text: str) -> Self:
        """From a channel's description.

        Raises:
            ValueError: it is no wave of ours.
            OSError: its file is not on this machine.
        """
        _, rate_hz, name = text.split(" ", 2)
        return cls(np.load(name, allow_pickle=False), float(rate_hz), Path(name))


def read_description(text: str) -> TaskSignal | TaskWave:
    """What a channel's description says that its task plays.

    Raises:
        ValueError: nothing of ours.
        OSError: the file of a wave is not on this machine.
    """
    return TaskWave.read(text) if text.startswith(SHAPED) else TaskSignal.read(text)


def ramp_down_to_zero(
    interpreter: Any, task: Any, physical: Sequence[str], own: tuple[NDArray[np.float64], float] | None = None
) -> None:
    """Stop what a task plays and let it fall, all outputs together; returns at 0 V, or with whoever else does the same.

    It does nothing where the device brings an idle output to 0 V by itself and can't be kept from it: the stop is then
    a step.

    Args:
        interpreter: the package's way to the driver.
        task: handle of a committed task.
        physical: its outputs.
        own: (outputs, n) what the task plays in V, and its rate, for who knows it; else the descriptions say it.

    Raises:
        ValueError, OSError: what the task plays is not known.
        DaqError: the task is gone, or could not be played: the output is wherever it is.
    """
    # One who comes a moment later must take neither the fall for the burst, nor what is stopped for what has fallen.
    with _alone(physical[0]):
        described = [interpreter.get_chan_attribute_string(task, output, DESCRIPTION) for output in physical]
        if described[0] != FALLING:
            waves, rate_hz = own or _described(described)
            # Of all of them: each must be kept from a step.
            if not all(_holds(interpreter, task, output) for output in physical):
                return
            interpreter.set_chan_attribute_string(task, physical[0], DESCRIPTION, FALLING)
            at = _stopped_at(interpreter, task, rate_hz)
            _play(interpreter, task, _falls(waves[:, min(at, waves.shape[1] - 1)], waves, rate_hz), rate_hz)
    interpreter.wait_until_task_done(task, WAIT_S)


def _described(texts: Sequence[str]) -> tuple[NDArray[np.float64], float]:
    """(outputs, n) what plays in V, and its rate, by the outputs' descriptions."""
    played = [read_description(text).wave() for text in texts]
    shortest = min(len(wave) for wave, _ in played)
    return np.stack([wave[:shortest] for wave, _ in played]), played[0][1]


def _falls(volts: NDArray[np.float64], waves: NDArray[np.float64], rate_hz: float) -> NDArray[np.float64]:
    """(outputs, n) from the value each output has to 0 V; who is there first stays there."""
    # An output that plays nothing has no level, and nothing to fall from.
    levels = np.maximum(np.abs(waves).max(axis=1), np.finfo(float).tiny)
    falls = [ramp_down_samples(float(v), float(level), rate_hz) for v, level in zip(volts, levels, strict=True)]
    longest = max(map(len, falls))
    return np.stack([np.pad(fall, (0, longest - len(fall))) for fall in falls])


@contextmanager
def _alone(physical: str) -> Generator[None]:
    """Keeps others of this machine from the same output, but never for long: a fall must come."""
    lease = FileLock(Path(tempfile.gettempdir()) / f"modallab-{re.sub('[^A-Za-z0-9]', '-', physical)}.lock")
    until = time.monotonic() + BEGIN_S
    with suppress(OSError):
        while not lease.acquire() and time.monotonic() < until:
            time.sleep(0.002)
    try:
        yield
    finally:
        lease.release()


def _holds(interpreter: Any, task: Any, physical: str) -> bool:
    hold = AOIdleOutputBehavior.MAINTAIN_EXISTING_VALUE.value
    try:
        idle = interpreter.get_chan_attribute_int32(task, physical, IDLE)
    except nidaqmx.errors.DaqError:
        # Most devices know no other way.
        return True
    if idle == hold:
        return True
    with suppress(nidaqmx.errors.DaqError):
        interpreter.set_chan_attribute_int32(task, physical, IDLE, hold)
        return True
    return False


def _stopped_at(interpreter: Any, task: Any, rate_hz: float) -> int:
    """Place of the last sample it has generated."""
    before = int(interpreter.get_write_attribute_uint64(task, GENERATED))
    asked_s = time.monotonic()
    interpreter.stop_task(task)
    took_s = time.monotonic() - asked_s
    count = 0
    with suppress(nidaqmx.errors.DaqError):
        count = int(interpreter.get_write_attribute_uint64(task, GENERATED))
    if count < before:
        # A driver that forgets the count with the stop leaves no better guess than the middle of the call.
        count = before + round(took_s / 2 * rate_hz)
    return max(0, count - 1)


def _play(interpreter: Any, task: Any, volts: Any, rate_hz: float) -> None:
    count = volts.shape[1]
    edge, finite = Edge.RISING.value, AcquisitionType.FINITE.value
    interpreter.cfg_samp_clk_timing(task, rate_hz, "", edge, finite, count)
    # The buffer of the burst would want to be filled before it starts.
    interpreter.set_buffer_attribute_uint32(task, OUTPUT_BUFFER, count)
    interpreter.write_analog_f64(task, count, False, WAIT_S, GROUP_BY_CHANNEL, volts)
    interpreter.start_task(task)


GROUP_BY_CHANNEL = 0
WAIT_S = 1.0
CLOCKED_HZ = 10_000.0
CLOCKED = 16
"""Samples: some converters want several before they give the first."""


def write_zero(interpreter: Any, task: Any, outputs: int = 1) -> None:
    """Put 0 V on the outputs of an unused task; they then hold it.

    Args:
        interpreter: the package's way to the driver; past `Task.write`, which asks three times what it writes to.
        task: handle of a task without a clock.
        outputs: that it has.

    Raises:
        DaqError: the device rejected it.
    """
    try:
        interpreter.write_analog_f64(task, 1, True, WAIT_S, GROUP_BY_CHANNEL, np.zeros((outputs, 1)))
    except nidaqmx.errors.DaqError as error:
        # Converters that oversample want a clock.
        if not isinstance(typed_error(error, ""), ConfigurationError):
            raise
        edge, finite = Edge.RISING.value, AcquisitionType.FINITE.value
        interpreter.cfg_samp_clk_timing(task, CLOCKED_HZ, "", edge, finite, CLOCKED)
        interpreter.write_analog_f64(task, CLOCKED, True, WAIT_S, GROUP_BY_CHANNEL, np.zeros((outputs, CLOCKED)))
        interpreter.wait_until_task_done(task, WAIT_S)
