"""Places and numbers of a diagnosis in words, with as many digits as their intervals bear."""

import re
from collections.abc import Sequence
from math import floor, isfinite
from typing import cast

from modallab.core.diagnosis import BudgetRow, CandidateSet, Diagnosis, Found, Percent
from modallab.core.effects import Parameter, kind_of
from modallab.core.rig import Rig
from modallab.reporting.digits import alike, glued, listed, plain
from modallab.twin.effects import model_of

SIGMAS = 2 * 1.96
"""Standard deviations in a 95 % interval."""
CERTAIN = 0.99
"""No probability is stated higher."""
FIXED = {
    "root": "at the clamp",
    "shaker": "at the shaker",
    "base": "at the base",
    "force": "on the force channel",
    "hit": "where the hammer strikes",
    "impact": "in the impact test",
}
_PERCENT = re.compile(r"(?<=\d)%")
_MINUS = re.compile(r"(?<![\w\d])-(?=\d)")


def typeset(text: str) -> str:
    """A sentence of a diagnosis with a blank before `%` and true minus signs."""
    return glued(_MINUS.sub("\u2212", _PERCENT.sub(" %", text)))


def in_between(value: float, interval: tuple[float, float] | None, unit: str = "") -> tuple[str, str]:
    """A number and its 95 % interval to the digits that its uncertainty bears; "" for an interval that is not known."""
    tail = f" {unit}" if unit else ""
    if interval is None or not all(map(isfinite, interval)) or interval[1] <= interval[0]:
        return f"{plain(value)}{tail}", ""
    sigma = (interval[1] - interval[0]) / SIGMAS
    low, high = (alike(v, sigma) for v in interval)
    return f"{alike(value, sigma)}{tail}", f"{low} to {high}{tail}"


def of_parameter(found: Found, parameter: Parameter) -> tuple[str, str]:
    """A parameter's value and its interval, as text; why it has none, where the records leave it open."""
    why = found.not_known.get(parameter.name)
    if why:
        return f"about {found.parameters[parameter.name]:.1g} {parameter.unit}".rstrip(), f"not known: {why}"
    return in_between(found.parameters[parameter.name], found.interval.get(parameter.name), parameter.unit)


def place_of(found: Found, rig: Rig) -> tuple[str, str]:
    """Where an effect acts, and the 95 % interval: "0.622 m from the clamp", "0.621 to 0.623 m"; "" for all of it."""
    x_m, share, channel = found.place.get("x_m"), found.interval.get("x"), found.place.get("channel")
    if isinstance(x_m, float):
        if "x" in found.not_known:
            return "somewhere along the beam", f"not known: {found.not_known['x']}"
        x = found.place.get("x")
        length = x_m / x if isinstance(x, float) and x else 1.0
        within = None if share is None else (share[0] * length, share[1] * length)
        value, interval = in_between(x_m, within, "m")
        return f"{value} from the clamp", interval
    if channel == "all":
        return "on all channels", ""
    if channel is not None:
        rows = cast("Sequence[int]", channel) if isinstance(channel, list | tuple) else [channel]
        return f"on {listed([_name(row, rig) for row in rows])}", ""
    return FIXED.get(kind_of(found.effect).place, ""), ""


def _name(row: object, rig: Rig) -> str:
    if isinstance(row, int) and 0 <= row < len(rig.channels):
        return rig.channels[row].name
    return f"channel {row}"


def sure(probability: float) -> str:
    """A probability to two digits, never rounded up, and never a certainty."""
    return f"{floor(100 * min(probability, CERTAIN) + 1e-9) / 100:.2f}"


def probability_of(candidate: CandidateSet, diagnosis: Diagnosis) -> float:
    """Of an explanation: where it is the one effect that was found, what is stated of that effect."""
    one = diagnosis.effects[0] if len(diagnosis.effects) == 1 else None
    return one.probability if one is not None and candidate.effects == [one.effect] else candidate.probability


def named(effects: Sequence[str]) -> str:
    """Effects of the catalogue in words."""
    return listed([model_of(name).spoken for name in effects])


def percent(value: float | None) -> str:
    """A share in percent, to two digits; a dash where it is not known."""
    if value is None:
        return "–"
    at = 100 * value
    return "< 0.01 %" if abs(at) < 0.01 else f"{plain(at, 2) if at < 10 else round(at)} %"


def both(share: Percent | None) -> tuple[str, str]:
    """At resonance and away from it."""
    at, away = (None, None) if share is None else (share.at_resonance, share.away)
    return percent(at), percent(away)


def part_of(share: float) -> str:
    """A part of the whole, to a tenth of a percent."""
    at = round(100 * share, 1)
    return f"{0.0 if at == 0 else at:.1f} %".replace("-", "\u2212")


def mostly(row: BudgetRow) -> str:
    """Test, channel, band and mode with the most of a part."""
    most = {division: max(by, key=lambda name: abs(by[name])) for division, by in row.by.items() if by}
    spoken = {"test": "{} test", "channel": "{}", "band": "{} Hz", "mode": "mode {}"}
    said = ", ".join(spoken[division].format(name) for division, name in most.items())
    return said.replace("-", " to ")
