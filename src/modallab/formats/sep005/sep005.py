"""SEP005 of SDyPy: a list of time series, each a dictionary with data, name, unit and rate; in a file as JSON."""

import json
from pathlib import Path
from typing import Any, cast

import numpy as np

from modallab.core.array_checks import check_rate
from modallab.core.block import Block, Campaign
from modallab.core.errors import DataError, FormatError
from modallab.core.rig import Rig
from modallab.core.units import Quantity
from modallab.formats.atomic import replacing
from modallab.formats.block_facts import MARK, BlockFacts, facts_or_options, read_facts
from modallab.formats.options import ImportOptions
from modallab.formats.uff.uff_lines import physical
from modallab.formats.unit_text import normal_unit

_QUANTITY: dict[Quantity, str] = {"force": "f", "acceleration": "a", "velocity": "v", "displacement": "d"}
_NEEDED = {"data": list, "name": str, "unit_str": str, "fs": float | int}
_REMEDY = "give every series data, name, unit_str and fs, as SEP005 demands"


def to_sep005(campaign: Campaign) -> list[dict[str, Any]]:
    """Every channel of every record as a series; `group` is the record, `data` a (n,) array in `unit_str`."""
    return [series for block in campaign.blocks for series in _series(block, campaign.rig)]


def write_sep005(campaign: Campaign, path: Path) -> None:
    """Write the series as JSON. Numbers have as many digits as are needed to read the same ones back.

    Raises:
        StorageError, DiskFullError: the file cannot be written.
    """
    content = [series | {"data": series["data"].tolist()} for series in to_sep005(campaign)]
    with replacing(path) as draft:
        draft.write_text(json.dumps(content, allow_nan=False) + "\n", encoding="utf-8")


def read_sep005(path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    """Read series from JSON; those of one `group` are one record.

    Raises:
        FormatError: no list of series.
        DataError: channels missing, or of unequal rates or lengths.
    """
    where, groups = str(path), series_of(path)
    blocks = [_block(name, group, order, rig, options, where) for order, (name, group) in enumerate(groups.items())]
    return Campaign(rig, tuple(blocks), source=where)


def series_of(path: Path) -> dict[str, dict[str, dict[str, Any]]]:
    """Group -> name -> its series, with `data` as an array.

    Raises:
        FormatError: no list of series.
    """
    groups: dict[str, dict[str, dict[str, Any]]] = {}
    for place, series in enumerate(_load(path), start=1):
        _check(series, f"{path}, series {place}")
        groups.setdefault(str(series.get("group", path.stem)), {})[series["name"]] = series
    return groups


def _series(block: Block, rig: Rig) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = []
    for channel, unit, values in zip(rig.channels, block.units, physical(block), strict=True):
        series = {"data": values, "name": channel.name, "unit_str": unit, "fs": block.rate_hz, "group": block.name}
        if channel.quantity in _QUANTITY and not unit.endswith("V"):
            series["quantity"] = _QUANTITY[channel.quantity]
        found.append(series | {"remark": BlockFacts.of(block).text()})
    return found


def _load(path: Path) -> list[dict[str, Any]]:
    try:
        content: Any = json.loads(path.read_text(encoding="utf-8"))
    except (ValueError, UnicodeError, RecursionError) as error:
        raise FormatError(f"is no JSON: {error}", where=str(path), remedy="export the file again") from error
    if not isinstance(content, list) or not content:
        raise FormatError("holds no list of series", where=str(path), remedy=_REMEDY)
    return cast("list[dict[str, Any]]", content)


def _check(series: object, where: str) -> None:
    if not isinstance(series, dict):
        raise FormatError("is no series", where=where, remedy=_REMEDY)
    content = cast("dict[str, Any]", series)
    wrong = [key for key, kind in _NEEDED.items() if not isinstance(content.get(key), kind)]
    if wrong:
        raise FormatError(f"has no {', '.join(wrong)}", where=where, remedy=_REMEDY)
    try:
        content["data"] = np.array(content["data"], dtype=np.float64)
    except (ValueError, TypeError) as error:
        raise FormatError(f"data are no numbers: {error}", where=where, remedy=_REMEDY) from error
    if content["data"].ndim != 1:
        raise FormatError("data are no single row of numbers", where=where, remedy=_REMEDY)


def _block(
    name: str, group: dict[str, dict[str, Any]], order: int, rig: Rig, options: ImportOptions, where: str
) -> Block:
    names = tuple(channel.name for channel in rig.channels)
    missing, unknown = [n for n in names if n not in group], [n for n in group if n not in names]
    if missing or unknown:
        raise DataError(
            f"group {name} lacks {', '.join(missing) or 'nothing'} and has {', '.join(unknown) or 'nothing'} besides",
            where=where,
            remedy="make rig and recording name the same channels",
        )
    parts = [group[n] for n in names]
    if len({(len(part["data"]), float(part["fs"])) for part in parts}) > 1:
        raise DataError(
            f"the series of group {name} differ in length or rate", where=where, remedy="export them together"
        )
    rate = check_rate(float(parts[0]["fs"]), where)
    options.agree(rate, where)
    remark = str(parts[0].get("remark", ""))
    facts = facts_or_options(read_facts(remark, where) if remark.startswith(MARK) else None, name, rate, options)
    return Block(
        name=facts.name,
        test=facts.test,
        order=order,
        rate_hz=facts.rate_hz,
        samples=np.stack([part["data"] for part in parts]),
        scale=np.ones(len(names)),
        units=tuple(
            normal_unit(part["unit_str"]) or options.unit(channel)
            for part, channel in zip(parts, rig.channels, strict=True)
        ),
        channels=names,
        drive_point=facts.drive_point if options.drive_point is None else options.drive_point,
        level=facts.level,
        frequency_hz=facts.frequency_hz,
        first_sample=facts.first_sample,
    )
