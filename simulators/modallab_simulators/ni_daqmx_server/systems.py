"""Systems of devices that the server can be: chassis with modules, single devices, PXI chassis with cards."""

from dataclasses import dataclass, replace

from modallab_simulators.ni_daqmx_server.catalogue import CHASSIS_KINDS, PRODUCTS
from modallab_simulators.ni_daqmx_server.modules import Module


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


def own_ppm(serial: int) -> float:
    """What a device's own clock is off by: within 25 ppm, and always the same for a device."""
    return (serial * 7919 % 5001 - 2500) / 100


def module(product: str, name: str, serial: int, chassis: str = "", slot: int = 0) -> Module:
    """A device of a product.

    Raises:
        KeyError: the product cannot be simulated.
    """
    return replace(PRODUCTS[product], name=name, serial=serial, chassis=chassis, slot=slot, ppm=own_ppm(serial))


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


def domain(device: Module) -> str:
    """What shares one clock with a device: all of a chassis, or the device alone."""
    return device.chassis or device.name


def pxi_chassis(name: str) -> str:
    """The PXI chassis that a card is in, by its name; empty for other devices."""
    return name.partition("Slot")[0] if name.startswith("PXI") and "Slot" in name else ""
