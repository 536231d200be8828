"""Sine generators on a serial line."""

from modallab.bench.protocol import Found


def find_devices(address: str) -> list[Found]:
    """Serial ports of this machine, to which a generator may be connected."""
    from serial.tools import list_ports

    return [Found(str(port.device), f"serial port, {port.description}") for port in list_ports.comports()]
