"""Groups of a TDMS file as records of a campaign."""

import math
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np

from modallab.core.array_checks import check_rate
from modallab.core.axis_checks import whole_rate
from modallab.core.block import Block, Campaign
from modallab.core.errors import DataError, FormatError
from modallab.core.rig import Rig
from modallab.formats.block_facts import facts_or_options, read_facts
from modallab.formats.check_campaign import check_channels
from modallab.formats.options import ImportOptions
from modallab.formats.tdms.tdms_read import TdmsObject, read_tdms_objects
from modallab.formats.unit_text import normal_unit

_PARTS = re.compile(r"/'((?:[^']|'')*)'")
_SCALE = "NI_Scale[0]_"


def read_tdms(path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    """Read every group as a record; its channels are those of the rig, by name, whatever their order.

    Raises:
        FormatError: no TDMS file, cut off, or of a kind that is not read here.
        DataError: channels that are not those of the rig, or of unequal type, length or rate.
    """
    where = str(path)
    groups, remarks = groups_of(path)
    if not groups:
        raise DataError("holds no samples", where=where, remedy="export the records again")
    blocks = [
        _block(name, group, remarks.get(name, ""), order, rig, options, f"{where}, group {name}")
        for order, (name, group) in enumerate(groups.items())
    ]
    return Campaign(rig, tuple(blocks), source=where)


def groups_of(path: Path) -> tuple[dict[str, dict[str, TdmsObject]], dict[str, str]]:
    """Group -> channel -> its samples, and group -> its description.

    Raises:
        FormatError: no TDMS file, cut off, or of a kind that is not read here.
    """
    groups: dict[str, dict[str, TdmsObject]] = {}
    remarks: dict[str, str] = {}
    for name, found in read_tdms_objects(path).items():
        parts = [part.replace("''", "'") for part in _PARTS.findall(name)]
        if len(parts) == 1:
            remarks[parts[0]] = str(found.properties.get("description", ""))
        elif len(parts) == 2 and found.parts:
            groups.setdefault(parts[0], {})[parts[1]] = found
    return groups, remarks


def _block(
    name: str, group: dict[str, TdmsObject], remark: str, order: int, rig: Rig, options: ImportOptions, where: str
) -> Block:
    check_channels(tuple(sorted(group, key=_order(rig))), rig, where)
    parts = [group[channel.name] for channel in rig.channels]
    rows = [part.samples for part in parts]
    steps = {_number(part, "wf_increment", 0.0, where) for part in parts}
    if len({(row.dtype, len(row)) for row in rows}) > 1 or len(steps) > 1:
        raise DataError(
            "its channels differ in type, length or rate", where=where, remedy="export channels recorded together"
        )
    rate = _rate(steps.pop(), options, where)
    facts = facts_or_options(read_facts(remark, where), name, rate, options)
    return Block(
        name=facts.name,
        test=facts.test,
        order=order,
        rate_hz=facts.rate_hz,
        samples=np.stack(rows),
        scale=np.array([_scale(part, where) for part in parts]),
        units=tuple(
            normal_unit(str(part.properties.get("unit_string", ""))) or options.unit(channel)
            for part, channel in zip(parts, rig.channels, strict=True)
        ),
        channels=tuple(channel.name for channel in rig.channels),
        drive_point=facts.drive_point if options.drive_point is None else options.drive_point,
        level=facts.level,
        frequency_hz=facts.frequency_hz,
        first_sample=facts.first_sample,
    )


def _order(rig: Rig) -> Callable[[str], int]:
    places = {channel.name: channel.index for channel in rig.channels}

    def place(name: str) -> int:
        return places.get(name, len(places))

    return place


def _number(part: TdmsObject, name: str, default: float, where: str) -> float:
    value = part.properties.get(name, default)
    if not isinstance(value, int | float):
        raise FormatError(f"its {name} is {value!r}, no number", where=where, remedy="export the records again")
    return float(value)


def _rate(step: float, options: ImportOptions, where: str) -> float:
    if step > 0:
        rate = check_rate(whole_rate(1 / step, 1e-12 / step), where)
        options.agree(rate, where)
        return rate
    if options.rate_hz is None:
        raise DataError("says no wf_increment", where=where, remedy="give the rate with --rate")
    return check_rate(options.rate_hz, where)


def _scale(part: TdmsObject, where: str) -> float:
    scales = _number(part, "NI_Number_Of_Scales", 0, where)
    status = part.properties.get("NI_Scaling_Status", "unscaled" if scales else "scaled")
    if status == "scaled":
        return 1.0
    kind = part.properties.get(f"{_SCALE}Scale_Type")
    offset = _number(part, f"{_SCALE}Linear_Y_Intercept", 0.0, where)
    slope = _number(part, f"{_SCALE}Linear_Slope", math.nan, where)
    if scales != 1 or kind != "Linear" or offset != 0 or not math.isfinite(slope):
        raise DataError(
            f"is scaled by {scales:g} scales of type {kind}, slope {slope:g}, offset {offset:g}",
            where=where,
            remedy="export scaled values; here a factor only can be kept beside the counts",
        )
    return slope
