"""Finds the driver or simulator for a bench's URL by entry point; none is ever imported by name."""

from typing import cast

from modallab.bench.protocol import Bench, BenchOpener, DeviceFinder, Found, OutputHandle, OutputOpener
from modallab.core.discovery import installed_entry_points
from modallab.core.errors import ConfigurationError
from modallab.core.rig import Rig

GROUP = "modallab.backends"
OUTPUTS = "modallab.outputs"
DEVICES = "modallab.devices"


def open_bench(url: str, rig: Rig) -> Bench:
    """Open the bench at `url`, such as `sim://cantilever?seed=1`.

    Raises:
        ConfigurationError: no scheme, or no installed driver for it.
    """
    scheme, separator, _ = url.partition("://")
    known = {entry.name: entry for entry in installed_entry_points(GROUP)}
    if not separator or scheme not in known:
        raise ConfigurationError(
            f"no driver for the bench address {url!r}",
            remedy=f"use an address that begins with one of: {', '.join(f'{name}://' for name in sorted(known))}",
        )
    opener = cast("BenchOpener", known[scheme].load())
    return opener(url, rig)


def has_output(url: str) -> bool:
    """Whether the bench at `url` may have an output that outlives the process that drives it."""
    return any(entry.name == url.partition("://")[0] for entry in installed_entry_points(OUTPUTS))


def open_output(url: str, rig: Rig) -> OutputHandle | None:
    """A second handle to the excitation output of the bench at `url`; None where no output outlives its process.

    Raises:
        BenchError: it cannot be had.
    """
    scheme = url.partition("://")[0]
    known = {entry.name: entry for entry in installed_entry_points(OUTPUTS)}
    if scheme not in known:
        return None
    return cast("OutputOpener", known[scheme].load())(url, rig)


def find_devices(address: str = "") -> list[Found]:
    """What is there: every installed driver is asked. With an address, only what is behind it.

    Raises:
        BenchError: what the address names can't be reached.
    """
    scheme = address.partition("://")[0]
    finders = [e for e in installed_entry_points(DEVICES) if not scheme or e.name == scheme]
    if scheme and not finders:
        raise ConfigurationError(f"nothing to look for at {address!r}", remedy="give an address such as nidaqmx://")
    return [found for entry in finders for found in cast("DeviceFinder", entry.load())(address)]
