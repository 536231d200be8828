"""The address of the simulated bench: `sim://cantilever?seed=1&bad_hits=0.1&effect=added_mass,mass=0.05,x=0.4`."""

from collections.abc import Callable
from dataclasses import dataclass, fields
from math import inf, isfinite
from typing import Any
from urllib.parse import parse_qsl, urlsplit

from modallab.core.effects import Effect
from modallab.core.errors import ConfigurationError
from modallab_simulators.cantilever.hammer import PEAK_N, REACTION_S
from modallab_simulators.cantilever.injected_effects import read_effect

MAX_ZETA = 0.2
TOLERANCES = ("none", "usual", "stated")


@dataclass(frozen=True, slots=True)
class BenchSettings:
    """What the address says.

    Attributes:
        seed: draws the true beam, the damping, the generator's clock, the hits and the noise.
        bad_hits: probability that a hit is a double hit or too weak.
        k_root: root rotational spring in EI/L; inf is a rigid clamp.
        pace: whether reads take real time.
        zeta: damping ratios of the first modes; a single one is that of every mode; empty: drawn.
        n_per_v: shaker and power amplifier, newton per volt of the generator.
        place_m: standard deviation of the place of a hit about its point.
        peak_n: between which forces the operator's hits peak, before what the sensors bear is known.
        reaction_s: between which times after the prompt the operator strikes.
        operator: port on which a script says when and where the hammer strikes; 0: the bench strikes when asked.
        speed: with `pace`, how many times faster than real time reads go.
        effects: what else is wrong with the bench; the parameter `effect` may occur many times, and is `none` alone
            where nothing is. None: what the revisions of the rig know.
        tolerances: how well it is put together: "none" is ideally, "usual" as in a lab, "stated" as its rig file says.
    """

    seed: int = 0
    bad_hits: float = 0.1
    k_root: float = 13.0
    pace: bool = False
    zeta: tuple[float, ...] = ()
    n_per_v: float = 0.5
    place_m: float = 0.0
    peak_n: tuple[float, float] = PEAK_N
    reaction_s: tuple[float, float] = REACTION_S
    operator: int = 0
    speed: float = 1.0
    effects: tuple[Effect, ...] | None = None
    tolerances: str = "none"


def parse_address(url: str) -> BenchSettings:
    """Read an address strictly.

    Raises:
        ConfigurationError: another bench than `cantilever`; or all unknown or repeated parameters and values that are
            not allowed, in one message.
    """
    parts = urlsplit(url)
    if parts.scheme != "sim" or parts.netloc != "cantilever" or parts.path not in ("", "/") or parts.fragment:
        raise ConfigurationError(
            f"no simulated bench at {url!r}", remedy="the only simulated bench is sim://cantilever?seed=1"
        )
    try:
        pairs = parse_qsl(parts.query, keep_blank_values=True, strict_parsing=bool(parts.query))
    except ValueError as error:
        raise ConfigurationError(
            f"cannot read the parameters {parts.query!r}: {error}", where=url, remedy="write name=value&name=value"
        ) from error
    values, problems = _read(pairs)
    if problems:
        raise ConfigurationError(
            "\n".join(problems), where=url, remedy="correct what is named, or leave it out to have the default"
        )
    return BenchSettings(**values)  # each reader returns the field's type


def _read(pairs: list[tuple[str, str]]) -> tuple[dict[str, Any], list[str]]:
    values: dict[str, Any] = {}
    effects: list[Effect] = []
    problems: list[str] = []
    named = [text for name, text in pairs if name == "effect"]
    for name, text in pairs:
        if name == "effect":
            effect, wrong = (None, []) if named == ["none"] else read_effect(text)
            problems += wrong
            effects += [effect] if effect else []
        elif name in values:
            problems.append(f"parameter {name!r} occurs twice; allowed: once")
        else:
            values[name] = _value(name, text, problems)
    if named:
        values["effects"] = tuple(effects)
    return values, problems


def _value(name: str, text: str, problems: list[str]) -> object:
    if name not in _READERS:
        names = ", ".join(sorted(f.name if f.name != "effects" else "effect" for f in fields(BenchSettings)))
        problems.append(f"unknown parameter {name!r}; allowed: {names}")
        return None
    reader, allowed = _READERS[name]
    try:
        return reader(text)
    except ValueError:
        problems.append(f"{name} is {text!r}; allowed: {allowed}")
        return None


def _number(low: float, high: float, *, above: bool = False) -> Callable[[str], float]:
    def read(text: str) -> float:
        value = float(text)
        if not low <= value <= high or (above and value == low):
            raise ValueError(text)
        return value

    return read


def _seed(text: str) -> int:
    if not text.isascii() or not text.isdigit():
        raise ValueError(text)
    return int(text)


def _port(text: str) -> int:
    port = _seed(text)
    return port if 1024 <= port <= 65535 else int(_reject(text))


def _flag(text: str) -> bool:
    return {"0": False, "1": True}[text] if text in ("0", "1") else _reject(text)


def _reject(text: str) -> bool:
    raise ValueError(text)


def _ratios(text: str) -> tuple[float, ...]:
    values = tuple(float(part) for part in text.split(","))
    if not all(isfinite(value) and 0 < value <= MAX_ZETA for value in values):
        raise ValueError(text)
    return values


def _range(text: str) -> tuple[float, float]:
    low, high = (float(part) for part in text.split(","))
    if not 0 < low <= high < inf:
        raise ValueError(text)
    return low, high


def _tolerances(text: str) -> str:
    if text not in TOLERANCES:
        raise ValueError(text)
    return text


_READERS: dict[str, tuple[Callable[[str], object], str]] = {
    "seed": (_seed, "a whole number from 0"),
    "bad_hits": (_number(0.0, 1.0), "a probability, 0 to 1"),
    "k_root": (_number(0.0, inf, above=True), "root spring in EI/L, above 0; inf for a rigid clamp"),
    "pace": (_flag, "0 (as fast as it goes) or 1 (real time)"),
    "zeta": (_ratios, f"damping ratios above 0 to {MAX_ZETA}: one for every mode, or a list 0.005,0.004,..."),
    "n_per_v": (_number(0.0, 1e4, above=True), "newton per volt of the generator, above 0 to 1e4"),
    "place_m": (_number(0.0, 0.1), "standard deviation of a hit's place in m, 0 to 0.1"),
    "peak_n": (_range, "lowest and highest peak of a hit in N, such as 50,150"),
    "operator": (_port, "a port from 1024 to 65535"),
    "speed": (_number(0.0, 100.0, above=True), "how many times faster than real time, above 0 to 100"),
    "tolerances": (_tolerances, ", ".join(TOLERANCES)),
    "reaction_s": (_range, "shortest and longest time to a hit in s, such as 0.5,1.5"),
}


@dataclass(frozen=True, slots=True)
class SessionConditions:
    """The circumstances of a session at the bench.

    Attributes:
        first_start: how many starts and hits went before, which counts where noise and hits are drawn.
        stretch: how much longer than meant all takes that excites. A converter that runs faster by as much sees the
            same forces as one that is right sees without.
        one_clock: whether the generator runs on the converter's clock, as on one card.
        straight_ramp: whether bursts rise along a straight line, not along a cosine.
        modes: how many modes the beam has in all; None for as many as there are.
        drift_s: bench time over which an ordinary drift runs; None for the usual.
    """

    first_start: int = 0
    stretch: float = 1.0
    one_clock: bool = False
    straight_ramp: bool = False
    modes: int | None = None
    drift_s: float | None = None


EVERYDAY = SessionConditions()
"""A bench as its address says."""
