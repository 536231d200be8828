"""A diagnosis in one sentence."""

from collections.abc import Sequence
from math import floor, inf, isfinite, log10
from typing import cast

from modallab.core.diagnosis import Diagnosis, Found, Gap, Percent
from modallab.core.effects import kind_of
from modallab.core.rounded import rounded
from modallab.twin.effects import model_of

UNITS = 4
"""Most digits of a parameter in a sentence."""
KNOWN = 2.0
"""Factor from before to after that is no matter of tolerances."""


def sentence(diagnosis: Diagnosis, channels: Sequence[str] = ()) -> str:
    """The verdict in one sentence.

    Args:
        diagnosis: of a campaign.
        channels: names of its rig's channels, where they are known.
    """
    gap = diagnosis.gap
    if diagnosis.verdict == "no_gap":
        within = "tolerances" if diagnosis.twin.departures else "noise"
        # What no force predicts, and the rig's revisions know, no twin takes away; it is no gap any more.
        known = gap.before > KNOWN * gap.after
        left = f"{gap.after:.2f} noise units with what its revisions know" if known else f"{gap.before:.2f} noise units"
        return f"Twin and bench agree to within the {within}: the gap is {left}, the floor 1."
    if diagnosis.verdict == "unknown":
        where = diagnosis.where
        at = f" on {', '.join(where.channels)}" if 0 < len(where.channels) < 4 else ""
        return (
            f"A gap of {rounded(gap.before)} noise units lies in the {where.stage}{at}, and none of the known effects "
            f"explains it.{_behaves(diagnosis)}"
        )
    parts = " and ".join(spoken(f, channels) for f in diagnosis.effects)
    closed = diagnosis.shrink.closed
    how_far = f", which closes {100 * closed:.1f} % of it on records held out" if closed is not None else ""
    return f"The gap of {rounded(gap.before)} noise units comes from {parts}{how_far}."


def _behaves(diagnosis: Diagnosis) -> str:
    """What a gap without a name behaves like, and how far that closes it."""
    described = diagnosis.described
    if described is None or described.shrink.closed is None:
        return ""
    says = described.says.rstrip(",")
    return f" It behaves like {says}, which closes {described.shrink.closed:.1%} of it on records held out."


def in_percent(gap: Gap) -> str:
    """The gap as a share of the response, in one sentence; "" where it is not known."""
    stages = (
        ("as the rig file describes the bench", gap.share_nominal),
        ("within the tolerances", gap.share_before),
        ("with what was found", gap.share_after),
    )
    said = [f"{_sides(share)} {name}" for name, share in stages if share is not None and _sides(share)]
    whole = f"In percent of the response, at resonance and away from it: {'; '.join(said)}." if said else ""
    return " ".join(s for s in (whole, own_error(gap)) if s)


def own_error(gap: Gap) -> str:
    """What is left of the records beyond noise, in one sentence; "" where it is not known."""
    left = gap.discrepancy
    if left is None:
        return ""
    if not left.worst:
        return "Beyond noise nothing is left of any record."
    return (
        f"Beyond noise, {as_percent(left.median)} of a record is left unexplained (median); "
        f"at worst {as_percent(left.worst)}, of {left.record}."
    )


def _sides(share: Percent) -> str:
    return " and ".join(as_percent(v) for v in (share.at_resonance, share.away) if v is not None)


def as_percent(value: float) -> str:
    """A share of the response in percent, without an exponent: "below 0.01 %", "3.2 %", "100 %"."""
    percent = 100 * value
    return "below 0.01 %" if percent < 0.01 else f"{percent:.2g} %" if percent < 10 else f"{percent:.0f} %"


def spoken(found: Found, channels: Sequence[str] = ()) -> str:
    """An effect with its numbers, its place and its probability; channels by number where their names are not given."""
    kind = kind_of(found.effect)
    numbers = ", ".join(
        f"{p.name} not known" if p.name in found.not_known else f"{p.name} = {_number(found, p.name)} {p.unit}".strip()
        for p in kind.parameters
    )
    place = place_in_words(found, channels)
    name = " ".join(filter(None, (model_of(found.effect).spoken, place)))
    return f"{name} ({numbers + '; ' if numbers else ''}probability {found.probability:.2f})"


def _number(found: Found, name: str) -> str:
    """A parameter to the digits that its interval bears, at most `UNITS`."""
    value, interval = found.parameters[name], found.interval.get(name)
    if interval is None or not (value and isfinite(value)) or not 0 < interval[1] - interval[0] < inf:
        return f"{value:.{UNITS}g}"
    sigma = (interval[1] - interval[0]) / (2 * 1.96)
    # One digit of the standard deviation, two where the first is a one.
    last = floor(log10(sigma)) - (sigma / 10 ** floor(log10(sigma)) < 1.95)
    digits = floor(log10(abs(value))) - last + 1
    return f"{value:#.{min(max(digits, 1), UNITS)}g}".rstrip(".")


def place_in_words(found: Found, channels: Sequence[str] = ()) -> str:
    """Where an effect acts: "at 0.622 m", "on channel 3", "on channels 3 and 7"; "" where it has no place."""
    place, channel = found.place, found.place.get("channel")
    if "x" in found.not_known:
        return "somewhere along the beam"
    if isinstance(place.get("x_m"), float):
        return f"at {place['x_m']:.3f} m"
    if channel is None or channel == "all":
        return ""
    rows = cast("Sequence[object]", channel) if isinstance(channel, list | tuple) else [cast("object", channel)]
    known = [channels[row] for row in rows if isinstance(row, int) and 0 <= row < len(channels)]
    if len(known) == len(rows):
        return f"on {' and '.join(known)}"
    return f"on channel{'s' * (len(rows) > 1)} {' and '.join(map(str, rows))}"
