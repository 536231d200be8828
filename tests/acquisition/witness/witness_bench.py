"""A bench in real time that writes what happens to its output into a file, where a test outside its process sees it.

The file is named by the environment variable WITNESS_LOG. It is found as any installed driver is: by its entry point.
"""

import os
import time
from pathlib import Path

import numpy as np

from modallab.bench.protocol import (
    AcquisitionRequest,
    Bench,
    BenchInfo,
    Burst,
    DeliveredSampling,
    OutputHandle,
    SampleChunk,
)
from modallab.core.errors import DeviceGoneError
from modallab.core.rig import Rig


class WitnessBench:
    """Noise on every channel, and on the force's what is driven, at the pace of the clock.

    A run of it goes on for as long as its plan says, and is not stopped for a drive that moves nothing.
    """

    def __init__(self, url: str, rig: Rig) -> None:
        self._url, self._channels, self._force = url, len(rig.channels), rig.force_channel.index
        self._burst, self._played = Burst(1.0, 0.0, 0.0, 0.0), 0
        note("open")

    @property
    def info(self) -> BenchInfo:
        return BenchInfo(self._url, (("witness", "1"),), True, True, {})

    def configure(self, request: AcquisitionRequest) -> DeliveredSampling:
        self._rate = request.rate_hz
        rate, units = request.rate_hz, ("V",) * self._channels
        return DeliveredSampling(rate, rate, rate, np.dtype(np.int16), np.full(self._channels, 1e-3), units)

    def start(self) -> None:
        self._began, self._position = time.monotonic(), 0
        self._noise = np.random.default_rng(1)

    def read(self, count: int, timeout_s: float) -> SampleChunk:
        if "unplugged" in self._url and self._position > 200:
            raise DeviceGoneError("the witness is unplugged", where=self._url, remedy="plug it in")
        first, self._position = self._position, self._position + count
        time.sleep(max(0.0, self._began + self._position / self._rate - time.monotonic()))
        samples = self._noise.normal(0, 2, (self._channels, count))
        times = (first - self._played + np.arange(count)) / self._rate
        sine = np.sin(2 * np.pi * self._burst.frequency_hz * times)
        samples[self._force] += self._burst.amplitude_v / 1e-3 * self._burst.envelope(times) * sine
        return SampleChunk(first, samples.astype(np.int16), np.zeros(self._channels, dtype=bool))

    def play(self, burst: Burst) -> int:
        note("play")
        self._burst, self._played = burst, self._position
        return self._position

    def prompt_hit(self, point: int) -> None:
        note("prompt")

    def zero(self) -> None:
        note("zero")

    def stop(self) -> None:
        note("stop")

    def close(self) -> None:
        note("close")


def note(what: str) -> None:
    with Path(os.environ["WITNESS_LOG"]).open("a") as file:
        file.write(f"{what} {time.time():.6f}\n")


class WitnessOutput:
    """The same output, reached from another process."""

    def __init__(self, url: str) -> None:
        if "locked" in url:
            raise DeviceGoneError("the output is locked", where=url, remedy="unlock it")

    def zero(self) -> None:
        note("outside-zero")

    def release(self) -> None:
        self.zero()

    def close(self) -> None:
        note("outside-close")


def open_output(url: str, rig: Rig) -> OutputHandle:
    return WitnessOutput(url)


def open_bench(url: str, rig: Rig) -> Bench:
    return WitnessBench(url, rig)
