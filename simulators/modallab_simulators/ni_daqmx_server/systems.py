"""Products with what their manuals say, and the systems of them that the server can be."""

from dataclasses import dataclass, replace
from typing import Any

from modallab_simulators.ni_daqmx_server.modules import Module

X_SERIES, C_SERIES, CHASSIS, DSA, M_SERIES = 15858, 14659, 14658, 14649, 14643
AO_SERIES, DIGITAL, SC_EXPRESS, OTHER_USB = 14647, 14648, 15886, 14646
TEST_SCALE_CHASSIS, TEST_SCALE_MODULE, MIO_DAQ = 16180, 16181, 16182
PXI, PXIE, PCIE, USB, CDAQ, NETWORK = 12583, 14706, 13612, 12586, 14637, 14828

_DIVIDED_HZ = 13.1072e6
_STRAIN = ("Bridge", "StrainGage", "RosetteStrainGage", "ForceBridge", "PressureBridge", "TorqueBridge")
_PLAIN = ("Voltage", "Current", "Resistance", "RTD", "Thrmcpl", "ThrmstrIex", "ThrmstrVex", "VoltageWithExcit", "StrainGage")  # fmt: skip  # noqa: E501
_DSA = ("Voltage", "Accel", "ForceIEPE", "Microphone", "VelocityIEPE", "PosEddyCurrProxProbe")

_X = Module("", "PCIe-6363", 0, inputs=32, outputs=4, max_rate_hz=2_000_000.0, multiplexed=True, timebase_hz=100e6,
            ports=(32, 8, 8), counters=4, narrower_v=(0.1, 0.2, 0.5, 1.0, 2.0, 5.0), max_output_hz=2_860_000.0,
            measures=_PLAIN, category=X_SERIES, bus=PCIE)  # fmt: skip
_DYNAMIC = Module("", "", 0, bits=24, clock="fine", min_rate_hz=1000.0, delta_sigma=True, max_rate_hz=204_800.0,
                  max_output_hz=204_800.0, delay_samples=63, narrower_v=(0.316, 1.0, 3.16, 10.0, 31.6),
                  input_range_v=42.4, currents_a=(0.0, 0.004, 0.010), measures=_DSA, category=DSA,
                  bus=PXIE)  # fmt: skip


def _c(product: str, **facts: Any) -> Module:
    return Module("", product, 0, category=C_SERIES, bus=CDAQ, **facts)


def _other(base: Module, product: str, **facts: Any) -> Module:
    return replace(base, product=product, **facts)


PRODUCTS: dict[str, Module] = {
    module.product: module
    for module in (
        _c("NI 9205", inputs=32, multiplexed=True, max_rate_hz=250_000.0, narrower_v=(0.2, 1.0, 5.0)),
        _c("NI 9214", inputs=16, bits=24, multiplexed=True, max_rate_hz=1088.0, input_range_v=0.078125,
           measures=("Thrmcpl", "Voltage", "TempBuiltInSensor")),
        _c("NI 9215", inputs=4),
        _c("NI 9234", inputs=4, input_range_v=5.0, bits=24, clock="divided", timebase_hz=_DIVIDED_HZ,
           max_rate_hz=51_200.0, delay_samples=38, delta_sigma=True, currents_a=(0.0, 0.002), measures=_DSA),
        # Its own timebase is 12.8 MHz, so its fastest rate is 50 kHz.
        _c("NI 9237", inputs=4, bits=24, clock="divided", timebase_hz=12.8e6, max_rate_hz=50_000.0, delay_samples=38,
           delta_sigma=True, bridge=True, bridge_ranges=(0.025,), measures=_STRAIN),
        _c("NI 9260", outputs=2, output_range_v=4.24264, clock="divided", timebase_hz=_DIVIDED_HZ,
           max_rate_hz=51_200.0, max_output_hz=51_200.0, delta_sigma=True),
        _c("NI 9263", outputs=4),
        _c("NI 9361", counters=8, ports=(8,), measures=("CI",)),
        _c("NI 9401", ports=(8,), counters=4),
        _c("NI 9775", inputs=4, bits=14, max_rate_hz=20_000_000.0),
        _X,
        _other(_X, "PXIe-6368", inputs=16, multiplexed=False, bus=PXIE),
        _other(_X, "USB-6423", outputs=4, ports=(8, 8), max_rate_hz=250_000.0, max_output_hz=250_000.0,
               category=MIO_DAQ, bus=USB),
        Module("", "USB-6211", 0, inputs=16, outputs=2, max_rate_hz=250_000.0, multiplexed=True, ports=(4, 4),
               counters=2, narrower_v=(0.2, 1.0, 5.0), max_output_hz=250_000.0, category=M_SERIES, bus=USB),
        _other(_DYNAMIC, "USB-4431", inputs=4, outputs=1, input_range_v=10.0, narrower_v=(), output_range_v=3.5,
               max_rate_hz=102_400.0, max_output_hz=96_000.0, delay_samples=34, currents_a=(0.0, 0.0021), bus=USB),
        _other(_DYNAMIC, "PXI-4461", inputs=2, outputs=2, bus=PXI),
        _other(_DYNAMIC, "PXIe-4464", inputs=4),
        _other(_DYNAMIC, "PXIe-4466", inputs=4),
        _other(_DYNAMIC, "PXIe-4480", inputs=6, max_rate_hz=20e6, input_range_v=10.0, narrower_v=(0.5, 1.0, 5.0),
               currents_a=(0.0, 0.004), measures=(*_DSA, "Charge", "AccelCharge", "Accel4WireDCVoltage")),
        _other(_DYNAMIC, "PXIe-4497", inputs=16, input_range_v=10.0, narrower_v=(0.316,), delay_samples=62,
               currents_a=(0.0, 0.004)),
        Module("", "PXIe-4311", 0, inputs=32, bits=24, max_rate_hz=51_200.0, category=SC_EXPRESS, bus=PXIE,
               measures=("Voltage", "Current", "CalculatedPower")),
        Module("", "PXIe-4322", 0, outputs=8, output_range_v=16.0, max_output_hz=250_000.0, category=AO_SERIES,
               bus=PXIE),
        Module("", "PXIe-4331", 0, inputs=8, bits=24, max_rate_hz=102_400.0, bridge=True, bridge_ranges=(0.025, 0.1),
               delta_sigma=True, measures=_STRAIN, category=SC_EXPRESS, bus=PXIE),
        Module("", "PXIe-4340", 0, inputs=4, bits=24, max_rate_hz=25_600.0, measures=("PosLVDT", "PosRVDT"),
               category=SC_EXPRESS, bus=PXIE),
        Module("", "PXIe-4353", 0, inputs=32, bits=24, max_rate_hz=90.0, measures=("Thrmcpl", "TempBuiltInSensor"),
               input_range_v=0.08, category=SC_EXPRESS, bus=PXIE),
        Module("", "PCIe-6535", 0, ports=(8, 8, 8, 8), max_output_hz=10e6, category=DIGITAL, bus=PCIE),
        Module("", "NI myDAQ", 0, inputs=2, outputs=2, max_rate_hz=200_000.0, multiplexed=True, narrower_v=(2.0,),
               ports=(8,), counters=1, measures=("Voltage", "VoltageRMS", "CurrentRMS", "Current", "Resistance"),
               category=OTHER_USB, bus=USB),
        Module("", "TS-15100", 0, inputs=8, category=TEST_SCALE_MODULE, bus=CDAQ),
        Module("", "TS-15200", 0, inputs=1, measures=("Power",), category=TEST_SCALE_MODULE, bus=CDAQ),
    )
}  # fmt: skip
"""Devices without a name, by product type."""

CHASSIS_KINDS = {
    "cDAQ-9178": (CHASSIS, USB), "cDAQ-9189": (CHASSIS, NETWORK), "cDAQ-9185": (CHASSIS, NETWORK),
    "TS-15000": (TEST_SCALE_CHASSIS, USB),
}  # fmt: skip
"""Category and bus of the chassis that are devices of their own."""


@dataclass(frozen=True, slots=True)
class Chassis:
    """A chassis that is a device of its own, with the modules in it.

    Attributes:
        name: as the system names it.
        product: product type.
        serial: serial number.
        simulated: whether the driver makes it up.
    """

    name: str
    product: str
    serial: int = 0x0C0DE
    simulated: bool = False

    @property
    def category(self) -> int:
        """Family of products."""
        return CHASSIS_KINDS[self.product][0]

    @property
    def bus(self) -> int:
        """What it is plugged into."""
        return CHASSIS_KINDS[self.product][1]


@dataclass(frozen=True, slots=True)
class Layout:
    """What stands in a system."""

    chassis: tuple[Chassis, ...]
    modules: tuple[Module, ...]


def clock_error_ppm(serial: int) -> float:
    """What a device's own clock is off by: within 25 ppm, and always the same for a device."""
    return (serial * 7919 % 5001 - 2500) / 100


def module(product: str, name: str, serial: int, chassis: str = "", slot: int = 0) -> Module:
    """A device of a product.

    Raises:
        KeyError: the product cannot be simulated.
    """
    return replace(PRODUCTS[product], name=name, serial=serial, chassis=chassis, slot=slot, ppm=clock_error_ppm(serial))


def _compact(name: str, *products: str, serial: int = 0x1A00) -> tuple[Module, ...]:
    return tuple(module(p, f"{name}Mod{n}", serial + n, name, n) for n, p in enumerate(products, start=1))


def _cards(number: int, *products: str) -> tuple[Module, ...]:
    # The first slot holds the controller.
    return tuple(module(p, f"PXI{number}Slot{n}", 0x4E00 + n, "", n) for n, p in enumerate(products, start=2))


def _one_chassis(*products: str) -> Layout:
    return Layout((Chassis("cDAQ1", "cDAQ-9178"),), _compact("cDAQ1", *products))


SYSTEMS: dict[str, Layout] = {
    "9234": _one_chassis("NI 9234", "NI 9234", "NI 9234", "NI 9263", "NI 9401"),
    "9215": _one_chassis("NI 9215", "NI 9215", "NI 9215", "NI 9263", "NI 9401"),
    "9237": _one_chassis("NI 9237", "NI 9237", "NI 9237", "NI 9263", "NI 9401"),
    "9260": _one_chassis("NI 9234", "NI 9234", "NI 9234", "NI 9260", "NI 9401"),
    "mixed": _one_chassis("NI 9234", "NI 9234", "NI 9215", "NI 9263", "NI 9401"),
    "6211": Layout((), (module("USB-6211", "Dev1", 0x2B01),)),
    "4431": Layout((), (module("USB-4431", "Dev1", 0x3C01),)),
    "two-4431": Layout((), (module("USB-4431", "Dev1", 0x3C01), module("USB-4431", "Dev2", 0x3C02))),
    "4461": Layout((), _cards(1, *("PXI-4461",) * 6)),
    "4464": Layout((), _cards(1, "PXIe-4464", "PXIe-4464", "PXIe-4464", "PXI-4461")),
    "64": Layout((), _cards(1, *("PXIe-4497",) * 4, "PXI-4461")),
    "two-chassis": Layout(
        (Chassis("cDAQ1", "cDAQ-9189"), Chassis("cDAQ2", "cDAQ-9189", 0x0C0DF)),
        _compact("cDAQ1", "NI 9234", "NI 9234", "NI 9263") + _compact("cDAQ2", "NI 9234", "NI 9234", serial=0x1B00),
    ),
}
"""Systems by what they are named on the command line."""


def clock_domain(device: Module) -> str:
    """What shares one clock with a device: all of a chassis, or the device alone."""
    return device.chassis or device.name


def pxi_chassis(name: str) -> str:
    """The PXI chassis that a card is in, by its name; empty for other devices."""
    return name.partition("Slot")[0] if name.startswith("PXI") and "Slot" in name else ""
