"""The devices that can be simulated, each with what its manual says of rates, ranges and delays."""

from dataclasses import dataclass, replace
from math import floor, isfinite
from typing import Literal

from modallab_simulators.ni_daqmx_server.status import INVALID_VALUE, StatusError

Clock = Literal["divided", "timebase", "fine"]

_DIVIDED_HZ = 13.1072e6 / 256
_TIMEBASE_HZ = 80e6


@dataclass(frozen=True, slots=True)
class Module:
    """One device.

    Attributes:
        name: as the system names it.
        product: product type.
        serial: serial number.
        inputs: analog inputs.
        outputs: analog outputs.
        input_range_v: of the inputs.
        output_range_v: of the outputs.
        bits: of the input converter.
        clock: `divided`: 13.1072 MHz / 256 / n, n to 31; `timebase`: 80 MHz / n; `fine`: as asked for.
        max_rate_hz: per channel, or of all channels together where they share a converter.
        min_rate_hz: where the clock itself sets none.
        delay_samples: of the converter's digital filter.
        multiplexed: whether channels share one converter.
        iepe: whether inputs feed IEPE sensors.
        bridge: whether inputs feed bridges.
        supplies_a: currents an IEPE input can feed a sensor with.
        coupling: of an input that nobody has set: AC 10045, DC 10050.
        lines: digital lines.
    """

    name: str
    product: str
    serial: int
    inputs: int = 0
    outputs: int = 0
    input_range_v: float = 10.0
    output_range_v: float = 10.0
    bits: int = 16
    clock: Clock = "timebase"
    max_rate_hz: float = 100_000.0
    min_rate_hz: float = 0.0
    delay_samples: int = 0
    multiplexed: bool = False
    iepe: bool = False
    bridge: bool = False
    lines: int = 0
    supplies_a: tuple[float, ...] = ()
    coupling: int = 10050

    def input_names(self) -> tuple[str, ...]:
        """Physical channels of the inputs."""
        return tuple(f"{self.name}/ai{n}" for n in range(self.inputs))

    def output_names(self) -> tuple[str, ...]:
        """Physical channels of the outputs."""
        return tuple(f"{self.name}/ao{n}" for n in range(self.outputs))

    def line_names(self) -> tuple[str, ...]:
        """Digital lines."""
        return tuple(f"{self.name}/port0/line{n}" for n in range(self.lines))

    def convert_rate_hz(self, channels: int, rate_hz: float) -> float:
        """Rate at which a multiplexer steps through its channels: the fastest plus 10 us, if there is time for it."""
        relaxed = 1 / (1 / self.max_rate_hz + 10e-6)
        return relaxed if relaxed >= channels * rate_hz else channels * rate_hz


def coerced(modules: tuple[Module, ...], channels: int, rate_hz: float) -> float:
    """The rate the devices give for a requested one: never a lower one, except past their highest.

    Raises:
        StatusError: no rate, or one above what the devices can do.
    """
    if not isfinite(rate_hz) or rate_hz <= 0:
        raise StatusError(INVALID_VALUE, f"Property: SampClk.Rate\nRequested Value: {rate_hz}")
    share = max(channels if m.multiplexed else 1 for m in modules)
    highest = min(m.max_rate_hz for m in modules) / share
    if rate_hz > highest * (1 + 1e-9):
        raise StatusError(
            INVALID_VALUE, f"Property: SampClk.Rate\nRequested Value: {rate_hz}\nMaximum Value: {highest}"
        )
    if any(m.clock == "divided" for m in modules):
        # Modules in one task share one timebase, and its grid.
        return _DIVIDED_HZ / min(31, max(1, floor(_DIVIDED_HZ / rate_hz * (1 + 1e-12))))
    if any(m.clock == "fine" for m in modules):
        return max(rate_hz, *(m.min_rate_hz for m in modules))
    return _TIMEBASE_HZ / max(1, floor(_TIMEBASE_HZ / rate_hz * (1 + 1e-12)))


_M9234 = Module("", "NI 9234", 0, inputs=4, input_range_v=5.0, bits=24, clock="divided", max_rate_hz=51_200.0,
                delay_samples=38, iepe=True, supplies_a=(0.002,), coupling=10045)  # fmt: skip
_M9215 = Module("", "NI 9215", 0, inputs=4)
_M9237 = Module("", "NI 9237", 0, inputs=4, bits=24, clock="divided", max_rate_hz=50_000.0, delay_samples=38,
                bridge=True)  # fmt: skip
_M9263 = Module("", "NI 9263", 0, outputs=4)
_M9401 = Module("", "NI 9401", 0, lines=8)
_M6211 = Module("", "USB-6211", 0, inputs=16, outputs=2, max_rate_hz=250_000.0, multiplexed=True, lines=4)
_M4431 = Module("", "USB-4431", 0, inputs=4, outputs=1, bits=24, clock="fine", max_rate_hz=102_400.0,
                min_rate_hz=1000.0, delay_samples=34, iepe=True, supplies_a=(0.0021,))  # fmt: skip


def _chassis(name: str, *kinds: Module) -> tuple[Module, ...]:
    return tuple(replace(kind, name=f"{name}Mod{n}", serial=0x1A00 + n) for n, kind in enumerate(kinds, start=1))


SYSTEMS: dict[str, tuple[str, tuple[Module, ...]]] = {
    "9234": ("cDAQ-9178", _chassis("cDAQ1", _M9234, _M9234, _M9234, _M9263, _M9401)),
    "9215": ("cDAQ-9178", _chassis("cDAQ1", _M9215, _M9215, _M9215, _M9263, _M9401)),
    "9237": ("cDAQ-9178", _chassis("cDAQ1", _M9237, _M9237, _M9237, _M9263, _M9401)),
    "mixed": ("cDAQ-9178", _chassis("cDAQ1", _M9234, _M9234, _M9215, _M9263, _M9401)),
    "6211": ("", (replace(_M6211, name="Dev1", serial=0x2B01),)),
    "4431": ("", (replace(_M4431, name="Dev1", serial=0x3C01),)),
    "64": ("PXIe-1082", _chassis("cDAQ1", *(_M9234,) * 16, _M9263)),
}
"""Chassis (its product, or "" where there is none) and devices, by what they are named on the command line."""

CHASSIS = "cDAQ1"
