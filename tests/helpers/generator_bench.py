"""A simulated generator on the wall's clock, and a driver that looks after it as a bench does."""

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab_drivers.function_generator.generator import Generator
from modallab_drivers.function_generator.line import InstrumentLine
from modallab_simulators.ni_daqmx_server.lines import OutputLine
from modallab_simulators.scpi_generator import (
    SINE_DIALECTS,
    HislipGenerator,
    PtyGenerator,
    ScpiGenerator,
    SocketGenerator,
)

RATE_HZ = 1000.0
CHUNK_S = 0.02


WAYS = {"pty": PtyGenerator, "socket": SocketGenerator, "hislip": HislipGenerator}


class WallClock:
    def now(self) -> float:
        return time.monotonic()


@dataclass
class Bench:
    """One instrument, how it is reached, and what stands at its output."""

    line: OutputLine
    device: ScpiGenerator
    port: PtyGenerator | SocketGenerator | HislipGenerator
    dialect: str

    def open(self) -> Generator:
        return Generator(InstrumentLine(self.port.port, 115200), self.dialect)

    def pace(self, generator: Generator, began: float, until_s: float) -> None:
        """Look after a burst that began at `began` of the clock, as one does who reads samples."""
        while (at := time.monotonic() - began) < until_s:
            generator.tick(round(at * RATE_HZ))
            time.sleep(0.002)

    def volts(self, first_s: float, last_s: float, rate_hz: float = 50e3) -> NDArray[np.float64]:
        """At the output, between two times of the clock."""
        return self.line.volts(np.arange(first_s, last_s, 1 / rate_hz))


def make(dialect: str, way: str = "pty") -> Bench:
    line = OutputLine()
    device = ScpiGenerator(SINE_DIALECTS[dialect], line, WallClock())
    return Bench(line, device, WAYS[way](device), dialect)
