"""How one maker's generator is spoken to, how finely it can be set, and what it is set to."""

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
class GeneratorSettings:
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
    def displayed_voltage(self) -> float:
        """What is shown of a voltage at the open output: that at the load it was set for."""
        load = self.numbers["load"]
        return 1.0 if np.isinf(load) else load / (load + OUTPUT_OHM)


@dataclass(frozen=True, slots=True)
class SineDialect:
    """One maker's generator.

    Attributes:
        idn: answer to `*IDN?`.
        headers: what each setting is called; the value follows after a blank.
        trigger: starts a burst.
        pairs: whether settings are `C1:BTWV TIME,10` pairs.
        max_vpp: into an open end.
        min_vpp: into an open end.
        amplitude_step_vpp: to which an amplitude is rounded.
        frequency_step_hz: to which a frequency is rounded.
        number: how a number is written.
        booleans: how OFF and ON are answered.
    """

    idn: str
    headers: dict[str, str]
    trigger: str = "*TRG"
    pairs: bool = False
    max_vpp: float = 20.0
    min_vpp: float = 0.002
    amplitude_step_vpp: float = 1e-4
    frequency_step_hz: float = 1e-6
    number: str = "{:+.13E}"
    booleans: tuple[str, str] = ("0", "1")


def _headers(channel: str, outputs: str, source: str) -> dict[str, str]:
    return {
        "function": f"{channel}FUNC",
        "frequency": f"{channel}FREQ",
        "amplitude": f"{channel}VOLT",
        "unit": f"{channel}VOLT:UNIT",
        "offset": f"{channel}VOLT:OFFS",
        "load": f"{outputs}:LOAD",
        "output": outputs,
        "burst": f"{channel}BURS:STAT",
        "mode": f"{channel}BURS:MODE",
        "cycles": f"{channel}BURS:NCYC",
        "phase": f"{channel}BURS:PHAS",
        "source": source,
    }


SINE_DIALECTS: dict[str, SineDialect] = {
    "keysight-33500": SineDialect(
        "Agilent Technologies,33511B,MY52300001,2.08-1.19-2.00-52-00", _headers("SOUR1:", "OUTP1", "TRIG1:SOUR")
    ),
    "keysight-33210": SineDialect(
        "Agilent Technologies,33210A,MY48000001,1.04-1.04-22-2", _headers("", "OUTP", "TRIG:SOUR"),
        min_vpp=0.02, amplitude_step_vpp=1e-3, frequency_step_hz=1e-3,
    ),
    "rigol-dg1000": SineDialect(
        "Rigol Technologies,DG1022Z,DG1ZA000000001,00.02.06",
        _headers(":SOUR1:", ":OUTP1", ":SOUR1:BURS:TRIG:SOUR"), ":SOUR1:BURS:TRIG",
        number="{:.6E}", booleans=("OFF", "ON"),
    ),
    "siglent-sdg": SineDialect(
        "Siglent Technologies,SDG2042X,SDG2XAAA000001,2.01.01.35R3",
        {
            "function": "C1:BTWV CARR,WVTP",
            "frequency": "C1:BTWV CARR,FRQ",
            "amplitude": "C1:BTWV CARR,AMP",
            "offset": "C1:BTWV CARR,OFST",
            "output": "C1:OUTP",
            "load": "C1:OUTP LOAD",
            "burst": "C1:BTWV STATE",
            "mode": "C1:BTWV GATE_NCYC",
            "cycles": "C1:BTWV TIME",
            "phase": "C1:BTWV STPS",
            "source": "C1:BTWV TRSR",
        },
        "C1:BTWV MTRIG", pairs=True, min_vpp=0.004, amplitude_step_vpp=1e-3, number="{:.9g}", booleans=("OFF", "ON"),
    ),
}  # fmt: skip

WORDS: dict[str, dict[str, str]] = {
    "function": {"SIN": "SIN", "SINE": "SIN", "SQU": "SQU", "SQUARE": "SQU"},
    "output": {"ON": "ON", "OFF": "OFF", "1": "ON", "0": "OFF"},
    "burst": {"ON": "ON", "OFF": "OFF", "1": "ON", "0": "OFF"},
    "unit": {"VPP": "VPP"},
    "mode": {"TRIG": "TRIG", "NCYC": "NCYC", "GAT": "GAT", "GATE": "GATE"},
    "source": {"BUS": "BUS", "MAN": "MAN", "IMM": "IMM", "INT": "INT"},
}
"""What a word may be, and how it is kept."""
