"""What a generator is set to, and what stands at its open output."""

from dataclasses import dataclass, field

import numpy as np

from modallab_simulators.ni_daqmx_server.lines import Floats

OUTPUT_OHM = 50.0


@dataclass(frozen=True, slots=True)
class SineBurst:
    """Whole cycles on the generator's own clock; the output rests at its offset before and after.

    Attributes:
        start_s: of the first cycle.
        frequency_hz: as set.
        cycles: infinite while no burst mode ends them.
        amplitude_v: at the open output.
        offset_v: there.
        ppm: by which its clock runs fast.
        square: whether it is a square wave.
    """

    start_s: float
    frequency_hz: float
    cycles: float
    amplitude_v: float
    ppm: float
    offset_v: float = 0.0
    square: bool = False

    def volts(self, times_s: Floats) -> Floats:
        """In V."""
        own = (times_s - self.start_s) * (1 + self.ppm * 1e-6) * self.frequency_hz
        wave = np.sin(2 * np.pi * own)
        shape = np.sign(wave) if self.square else wave
        return self.offset_v + np.where((own > 0) & (own < self.cycles), self.amplitude_v * shape, 0.0)


@dataclass(slots=True)
class Settings:
    """As after switching on. Amplitude and offset are kept as at the open output: the load only changes what is shown.

    Attributes:
        numbers: by name.
        words: by name.
    """

    numbers: dict[str, float] = field(
        default_factory=lambda: {
            "frequency": 1000.0, "amplitude": 0.2, "offset": 0.0, "cycles": 1.0, "load": 50.0, "phase": 0.0,
        }
    )  # fmt: skip
    words: dict[str, str] = field(
        default_factory=lambda: {
            "function": "SIN", "unit": "VPP", "output": "OFF", "burst": "OFF", "mode": "TRIG", "source": "IMM",
        }
    )  # fmt: skip

    @property
    def shown(self) -> float:
        """What is shown of a voltage at the open output: that at the load it was set for."""
        load = self.numbers["load"]
        return 1.0 if np.isinf(load) else load / (load + OUTPUT_OHM)
