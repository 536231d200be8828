"""Finds the driver or simulator for a bench's URL by entry point; none is ever imported by name."""

from collections.abc import Sequence
from math import sqrt
from typing import cast
from urllib.parse import quote

from modallab.bench.protocol import Bench, BenchOpener, DeviceFinder, FoundDevice, OutputHandle, OutputOpener
from modallab.core.discovery import installed_entry_points
from modallab.core.effects import EffectKind, catalogue
from modallab.core.errors import ConfigurationError
from modallab.core.rig import Rig

_PLACES = {"x": "x=0.8", "channel": "channel=a03", "pair": "channel=a03:a07"}


def simulated_bench(rig: Rig, seed: int, effects: Sequence[str] = (), tolerances: str = "none") -> str:
    """The address of the simulated bench with these effects.

    Args:
        rig: what stands on it.
        seed: draws the bench and its noise.
        effects: each as added_mass,mass=0.05,x=0.8.
        tolerances: none, usual, or stated for those of the rig file.

    Raises:
        ConfigurationError: an effect that there is not, or a number or place of it that is missing or cannot be.
    """
    built = "" if tolerances == "none" else f"&tolerances={tolerances}"
    url = f"sim://cantilever?seed={seed}{built}"
    for effect in effects:
        try:
            open_bench(f"{url}{_added_effect(effect)}", rig).close()
        except ConfigurationError as error:
            raise ConfigurationError(
                error.what.replace("\n", "; "), where=f"effect {effect}", remedy=_remedy(effect, rig)
            ) from error
    url += "".join(map(_added_effect, effects))
    open_bench(url, rig).close()
    return url


def example_effect(kind: EffectKind, rig: Rig) -> str:
    """An effect of this kind, large enough to be seen in a test: added_mass,mass=0.05,x=0.8."""
    words = [kind.name]
    for number in kind.parameters:
        low, high = (number.low, number.high) if rig.beam is None else number.bounds(rig.beam)
        words.append(f"{number.name}={number.none + sqrt(low * high):.3g}")
    return ",".join([*words, *([_PLACES[kind.place]] if kind.place in _PLACES else [])])


def _added_effect(effect: str) -> str:
    return f"&effect={quote(effect, safe=',=')}"


def _remedy(effect: str, rig: Rig) -> str:
    name = effect.partition(",")[0].strip()
    if name in catalogue():
        return f"write it as {example_effect(catalogue()[name], rig)}; modallab gap effects {name} describes the effect"
    return "modallab demo --effect help lists the effects; write one as added_mass,mass=0.05,x=0.8"


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


def find_devices(address: str = "") -> list[FoundDevice]:
    """What is there: every installed driver is asked. With an address, only what is behind it.

    Raises:
        BenchError: what the address names can't be reached.
    """
    scheme = address.partition("://")[0]
    finders = [e for e in installed_entry_points(DEVICES) if not scheme or e.name == scheme]
    if scheme and not finders:
        raise ConfigurationError(
            f"no devices can be listed at {address!r}", remedy="give an address such as nidaqmx://"
        )
    return [found for entry in finders for found in cast("DeviceFinder", entry.load())(address)]
