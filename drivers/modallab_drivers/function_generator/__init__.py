"""Sine generators on a serial line, on USB or in the network."""

from contextlib import suppress
from typing import Any

from modallab.bench.protocol import FoundDevice


def find_devices(address: str) -> list[FoundDevice]:
    """Serial ports of this machine, to which a generator may be connected, and instruments on USB.

    Instruments in the network are not searched for: their address stands on their own display.
    """
    from serial.tools import list_ports

    ports = [FoundDevice(str(port.device), f"serial port, {port.description}") for port in list_ports.comports()]
    return ports + _on_usb()


def _on_usb() -> list[FoundDevice]:
    from pyvisa_py.protocols.usbtmc import find_tmc_devices

    # Without libusb, or without the right to look at the bus, there is nothing to be found.
    with suppress(Exception):
        devices: list[Any] = list(find_tmc_devices() or [])
        return [
            FoundDevice(f"USB0::0x{d.idVendor:04X}::0x{d.idProduct:04X}::{d.serial_number}::INSTR", f"USB, {d.product}")
            for d in devices
        ]
    return []
