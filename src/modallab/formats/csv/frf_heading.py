"""What the heading of a column of FRFs says: which part of a complex number, of which response to which force."""

import re
from collections.abc import Collection
from dataclasses import dataclass
from typing import Literal

from modallab.core.errors import DataError
from modallab.core.rig import Channel, Rig
from modallab.core.units import TO_SI
from modallab.formats.options import ImportOptions
from modallab.formats.unit_text import frf_unit, normal_unit

Part = Literal["re", "im", "magnitude", "phase", "coherence", "complex"]

_WORDS: dict[Part, str] = {
    "re": r"re|(?:real|reell|réel|reel)L",
    "im": r"imm?|imm?agL",
    "magnitude": r"gain|(?:mag|amp|abs|m[oó]dul|betrag|level|pegel|niveau|nivel|livello)L",
    "phase": r"ph|phi|(?:phas|fas|arg|ang|winkel)L",
    "coherence": r"(?:coh|koh|coer)L|(?:γ|gamma)\s?(?:²|\^?2)?",
}
"""How the words of several languages begin; L stands for the letters that follow."""
_WORDS = {part: words.replace("L", r"[^\W\d_]*") for part, words in _WORDS.items()}
_ANY = "|".join(_WORDS.values())
_FIRST = re.compile(
    rf"^(?:part[ei]e? )?(?P<part>{_ANY})(?:[ _]?(?:part|angle))?(?:(?:[\s_(:.{{]|$)\s*(?:of )?(?P<rest>.*?)[)}}]?)?$",
    re.I,
)
_LAST = re.compile(rf"^(?P<rest>.*?)[\s_:.(]+(?P<part>{_ANY})(?:[ _]?(?:part|angle))?\)?$", re.I)
_SIGNS: dict[Part, re.Pattern[str]] = {"magnitude": re.compile(r"^\|(.*)\|$"), "phase": re.compile(r"^[∠∡](.*)$")}
_UNIT_WORD = re.compile(r"^(?P<rest>.*?)[\s_](?P<unit>deg|degrees|rad|dB)$", re.I)
_NUMBERED = re.compile(
    r"^(?:h|frf|p|point|node|dof)?[\s_(]*(?P<output>\d+)(?P<axis>[+-]?[xyz])?"
    r"(?:[\s_,;:/-]+p?(?P<input>\d+)(?:[+-]?[xyz])?)?\)?$",
    re.I,
)
_RUN_TOGETHER = re.compile(r"(?<=^H)(\d)(\d)$", re.I)
_LEVEL = re.compile(r"^dB\b(?:\s*\(?(?:re|ref|rel)\b[.:]?)?\s*(?:1(?:\.0*)?\s+)?(?P<of>.*)$", re.I)
_FUNCTION = re.compile(r"^(?:H[12v]?|FRF|TF|G)(?:\s*\((?P<of>[^()]*)\)?|[\s_]+(?P<name>\D.*))$", re.I)
"""An FRF as a function of its response and its force, as H1(a01,force) or H a01."""
_ARGUMENT = re.compile(r"(?<=\d)\s*\(j?[fωws]\)?$", re.I)
"""What an FRF is a function of, as in H2,1(f)."""
_TO = re.compile(r"^(?P<output>.+?)\s*[/:,]\s*(?:p(?P<input>\d+)|(?P<force>[^/:,]+))$", re.I)


@dataclass(frozen=True, slots=True)
class FrfHeading:
    """One column.

    Attributes:
        text: as it is written, without the unit.
        part: of the complex numbers.
        unit: "" where none is written.
        of: what is left of the text once the part is taken off: whose FRF it is.
    """

    text: str
    part: Part
    unit: str
    of: str


@dataclass(frozen=True, slots=True)
class Pair:
    """Whose FRF a column holds; None where it is not said.

    Attributes:
        name: of the response.
        point: its number.
        axis: such as "+z".
        input: number of the point of the force.
        force: its name; some programs write it first.
    """

    name: str
    point: int | None = None
    axis: str = ""
    input: int | None = None
    force: str = ""


def frf_heading(name: str, unit: str) -> FrfHeading:
    """What a column's name and unit say."""
    text = name
    if not unit and (worded := _UNIT_WORD.match(name)):
        name, unit = worded["rest"], {"db": "dB"}.get(worded["unit"].lower(), normal_unit(worded["unit"].lower()))
    if unit and not _is_unit(unit) and _FIRST.fullmatch(unit):
        # The part stands in brackets behind the name, as in a1(Real).
        name, unit = f"{name} {unit}", ""
    for part, sign in _SIGNS.items():
        if signed := sign.match(name):
            return FrfHeading(text, part, unit, signed[1].strip())
    alone = _FIRST.match(name)
    if alone and unit and not (alone["rest"] or "") and not _is_unit(unit):
        # What stands in brackets is the argument, as in Re(H11), and not a unit.
        return FrfHeading(text, _part(alone["part"]), "", unit)
    found = alone or _LAST.match(name)
    if found is None:
        return FrfHeading(text, "complex", unit, name.strip())
    return FrfHeading(text, _part(found["part"]), unit, (found["rest"] or "").strip(" _:.(){}"))


def pair_of(of: str, points: Collection[int] = ()) -> Pair:
    """Response and force from a text such as "a01", "a01/p10", "H3,10", "3z" or ""; H21 as H2,1 if `points` say so."""
    of = _ARGUMENT.sub("", of)
    if function := _FUNCTION.match(of):
        of = (function["of"] or function["name"] or "").strip()
    apart = _RUN_TOGETHER.sub(r"\1,\2", of)
    if apart != of and int(of[-2:]) not in points and {int(of[-2]), int(of[-1])} <= set(points):
        of = apart
    if numbered := _NUMBERED.match(of):
        axis = (numbered["axis"] or "").lower()
        into = None if numbered["input"] is None else int(numbered["input"])
        signed = axis if not axis or axis[0] in "+-" else f"+{axis}"
        return Pair(of, int(numbered["output"]), signed, into)
    if to := _TO.match(of):
        into = None if to["input"] is None else int(to["input"])
        return Pair(to["output"].strip(), input=into, force=(to["force"] or "").strip())
    return Pair(of)


def is_left_out(heading: FrfHeading, rig: Rig, options: ImportOptions) -> bool:
    """Whether a column is of a channel that the user leaves out, which the rig may then have no more."""
    names, known = (heading.of, pair_of(heading.of).name), {channel.name.lower() for channel in rig.responses}
    return not all(map(options.takes, [name for name in names if name.lower() in known] or names))


def response_of(heading: FrfHeading, rig: Rig, where: str) -> tuple[Channel, int | None]:
    """The rig's response that a column belongs to, and the number of the point of the force.

    Raises:
        DataError: no response or several are meant.
    """
    pair = pair_of(heading.of, {point.id for point in rig.points})
    driven = rig.force is not None and pair.name.lower() == rig.force.name.lower()
    for name in (heading.of, pair.force if driven else pair.name):
        named = [c for c in rig.responses if c.name.lower() == name.lower()]
        if named:
            return named[0], pair.input if name != heading.of else None
    fitting = [
        c for c in rig.responses if pair.point is not None and c.point == pair.point and pair.axis in ("", c.direction)
    ]
    if len(rig.responses) == 1 and not heading.of:
        fitting = list(rig.responses)
    if len(fitting) != 1:
        raise DataError(
            f"column {heading.text!r} is the FRF of {'several responses' if fitting else 'no response'} of the rig, "
            f"which has {', '.join(c.name for c in rig.responses)}",
            where=where,
            remedy="name the columns as Re a1 and Im a1, or Re a1/p10 with the point of the force, a1 being a channel; "
            "with --columns, if not in the file",
        )
    return fitting[0], pair.input


def is_level(unit: str) -> bool:
    """Whether a unit is dB, of whatever."""
    return _LEVEL.match(unit) is not None


def reference_of(unit: str) -> str:
    """The unit that a level in dB refers to: g/N of "dB re 1 g/N" and "dB (g/N)"; a unit that is no level itself."""
    level = _LEVEL.match(unit)
    return unit if level is None else normal_unit(level["of"])


def _part(word: str) -> Part:
    return next(part for part, words in _WORDS.items() if re.fullmatch(words, word, re.I))


def _is_unit(unit: str) -> bool:
    known = unit in {"deg", "rad", "dB", "-", "1", "%"} or any(unit in units for units in TO_SI.values())
    return known or is_level(unit) or frf_unit(normal_unit(unit), "") is not None
