"""The address of the simulated bench: `sim://cantilever?seed=1&bad_hits=0.1`."""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, isfinite
from urllib.parse import parse_qsl, urlsplit

from modallab.errors import ConfigurationError

MAX_ZETA = 0.2


@dataclass(frozen=True, slots=True)
class Settings:
    """What the address says.

    Attributes:
        seed: draws the true beam, the damping, the generator's clock, the blows and the noise.
        bad_hits: probability that a blow is a double hit or too weak.
        k_root: root rotational spring in EI/L; inf is a rigid clamp.
        pace: whether reads take real time.
        zeta: damping ratios of the first modes; a single one is that of every mode; empty: drawn.
        n_per_v: shaker and power amplifier, newton per volt of the generator.
        place_m: standard deviation of the place of a blow about its point.
    """

    seed: int = 0
    bad_hits: float = 0.1
    k_root: float = 13.0
    pace: bool = False
    zeta: tuple[float, ...] = ()
    n_per_v: float = 0.5
    place_m: float = 0.0


def parse(url: str) -> Settings:
    """Read an address strictly.

    Raises:
        ConfigurationError: another bench than `cantilever`, an unknown or repeated parameter, a value not allowed.
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
    values: dict[str, object] = {}
    for name, text in pairs:
        values[name] = _value(url, name, text, repeated=name in values)
    return Settings(**values)  # pyright: ignore[reportArgumentType]  # each reader returns the field's type


def _value(url: str, name: str, text: str, *, repeated: bool) -> object:
    if name not in _READERS:
        raise ConfigurationError(
            f"unknown parameter {name!r}", where=url, remedy=f"use only: {', '.join(sorted(_READERS))}"
        )
    if repeated:
        raise ConfigurationError(f"parameter {name!r} occurs twice", where=url, remedy="give it once")
    reader, allowed = _READERS[name]
    try:
        return reader(text)
    except ValueError as error:
        raise ConfigurationError(f"{name} is {text!r}", where=url, remedy=f"allowed: {allowed}") from error


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


def _flag(text: str) -> bool:
    return {"0": False, "1": True}[text] if text in ("0", "1") else _refuse(text)


def _refuse(text: str) -> bool:
    raise ValueError(text)


def _ratios(text: str) -> tuple[float, ...]:
    values = tuple(float(part) for part in text.split(","))
    if not all(isfinite(value) and 0 < value <= MAX_ZETA for value in values):
        raise ValueError(text)
    return values


_READERS: dict[str, tuple[Callable[[str], object], str]] = {
    "seed": (_seed, "a whole number from 0"),
    "bad_hits": (_number(0.0, 1.0), "a probability, 0 to 1"),
    "k_root": (_number(0.0, inf, above=True), "root spring in EI/L, above 0; inf for a rigid clamp"),
    "pace": (_flag, "0 (as fast as it goes) or 1 (real time)"),
    "zeta": (_ratios, f"damping ratios above 0 to {MAX_ZETA}: one for every mode, or a list 0.005,0.004,..."),
    "n_per_v": (_number(0.0, 1e4, above=True), "newton per volt of the generator, above 0 to 1e4"),
    "place_m": (_number(0.0, 0.1), "standard deviation of a blow's place in m, 0 to 0.1"),
}
