"""SEP005 of SDyPy: a list of time series, each a dictionary with data, name, unit and rate; in a file as JSON."""

import json
from decimal import Decimal
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from modallab.core.array_checks import check_rate, check_time
from modallab.core.block import Block, Campaign
from modallab.core.errors import DataError, FormatError
from modallab.core.rig import Rig
from modallab.core.units import Quantity
from modallab.formats.atomic import write_text
from modallab.formats.block_facts import MARK, BlockFacts, facts_or_options, read_facts
from modallab.formats.csv.csv_cells import number
from modallab.formats.draft import DraftChannel, rig_of, select_channels
from modallab.formats.options import ImportOptions
from modallab.formats.starts import Start, cut_to_common_time, one_rate, start_of, start_of_text
from modallab.formats.uff.uff_lines import physical
from modallab.formats.unit_text import normal_unit, quantity_of

_QUANTITY: dict[Quantity, str] = {"force": "f", "acceleration": "a", "velocity": "v", "displacement": "d"}
_AGREE = 1e-3
"""Relative difference of a rate from that of the times beside it."""
_NEEDED = {"data": list, "name": str, "unit_str": str}
_REMEDY = "give every series data, name, unit_str, and fs or time, as SEP005 demands"


def to_sep005(campaign: Campaign) -> list[dict[str, Any]]:
    """Every channel of every record as a series; `group` is the record, `data` a (n,) array in `unit_str`."""
    return [series for block in campaign.blocks for series in _series(block, campaign.rig)]


def write_sep005(campaign: Campaign, path: Path) -> None:
    """Write the series as JSON. Numbers have as many digits as are needed to read the same ones back.

    Raises:
        StorageError, DiskFullError: the file cannot be written.
    """
    content = [series | {"data": series["data"].tolist()} for series in to_sep005(campaign)]
    write_text(path, json.dumps(content, allow_nan=False) + "\n")


def read_sep005(path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    """Read series from JSON; those of one `group` are one record.

    Raises:
        FormatError: no list of series.
        DataError: channels missing, or of unequal rates or lengths.
    """
    where, groups = str(path), series_of(path)
    blocks: list[Block] = []
    notes: list[str] = []
    for order, (name, group) in enumerate(groups.items()):
        called = {options.channel_of(own): series for own, series in group.items()}
        block, note = _block(name, called, order, rig, options, where)
        blocks.append(block)
        notes += [f"{path.name}, group {name}: {note}"] if note else []
    return Campaign(rig, tuple(blocks), provenance={"notes": "\n".join(notes)} if notes else {}, source=where)


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
    except (ValueError, RecursionError) as error:
        raise FormatError(f"is no JSON: {error}", where=str(path), remedy="export the file again") from error
    if not isinstance(content, list) or not content:
        raise FormatError("holds no list of series", where=str(path), remedy=_REMEDY)
    return cast("list[dict[str, Any]]", content)


def _check(series: object, where: str) -> None:
    if not isinstance(series, dict):
        raise FormatError("is no series", where=where, remedy=_REMEDY)
    content = cast("dict[str, Any]", series)
    if isinstance(content.get("fs"), str):
        content["fs"] = number(content["fs"])
    wrong = [key for key, kind in _NEEDED.items() if not isinstance(content.get(key), kind)]
    if not isinstance(content.get("fs"), float | int) and not isinstance(content.get("time"), list):
        wrong.append("fs or time")
    if wrong:
        raise FormatError(f"has no {', '.join(wrong)}", where=where, remedy=_REMEDY)
    for key in ("data", "time"):
        if content.get(key) is not None:
            content[key] = _row(content[key], key, where)


def _row(values: object, key: str, where: str) -> NDArray[np.float64]:
    try:
        row = np.array(values, dtype=np.float64)
    except (ValueError, TypeError) as error:
        raise FormatError(f"{key} are no numbers: {error}", where=where, remedy=_REMEDY) from error
    if row.size == max(row.shape, default=0):
        row = row.ravel()
    if row.ndim != 1:
        raise FormatError(f"{key} are no single row of numbers", where=where, remedy=_REMEDY)
    return row


def _rate(series: dict[str, Any], where: str) -> float:
    """The rate of a series by its fs, which its times must not contradict, or by these alone."""
    times, fs = series.get("time"), series.get("fs")
    own = check_rate(float(fs), where) if isinstance(fs, float | int) else 0.0
    if times is None:
        return own
    if len(times) != len(series["data"]):
        found = f"{series['name']} has {len(times)} times and {len(series['data'])} samples"
        raise FormatError(found, where=where, remedy=_REMEDY)
    found = check_time(times, f"{where}, times of {series['name']}", resolution_s=_last_digit(times))
    if own and abs(found - own) > _AGREE * own:
        raise FormatError(f"{series['name']} has fs {own:g} Hz and times of {found:g} Hz", where=where, remedy=_REMEDY)
    return own or found


def _last_digit(times: NDArray[np.float64]) -> float:
    """Half of the last digit with which times are written, by those that are written longest."""
    exponents = [Decimal(repr(float(t))).as_tuple().exponent for t in times[:: max(1, len(times) // 50)]]
    return 0.5 * 10.0 ** min(e for e in exponents if isinstance(e, int)) if np.isfinite(times).all() else 0.0


def _start(series: dict[str, Any], where: str) -> Start | None:
    """The moment of the first sample; a series of times without a date counts them from the same moment as others."""
    stamp, times = series.get("start_timestamp"), series.get("time")
    if stamp is not None:
        return start_of_text(str(stamp), f"{where}, {series['name']}")
    return None if times is None else start_of(float(times[0]), _last_digit(times), timed=True)


def _block(
    name: str, group: dict[str, dict[str, Any]], order: int, rig: Rig, options: ImportOptions, where: str
) -> tuple[Block, str]:
    names = tuple(channel.name for channel in rig.channels)
    missing, unknown = [n for n in names if n not in group], [n for n in group if n not in names]
    if missing or unknown:
        raise DataError(
            f"group {name} lacks {', '.join(missing) or 'nothing'} and has {', '.join(unknown) or 'nothing'} besides",
            where=where,
            remedy="say which is which with --variable CHANNEL=NAME, or correct the rig",
        )
    parts = [group[n] for n in names]
    rates = {part["name"]: _rate(part, where) for part in parts}
    rate = options.agreed(one_rate(rates, f"{where}, group {name}") or 0.0, where)
    dated = any(part.get("start_timestamp") for part in parts)
    starts = [_start(part, where) if bool(part.get("start_timestamp")) == dated else None for part in parts]
    samples, note = cut_to_common_time([part["data"] for part in parts], starts, rate, names, f"{where}, group {name}")
    remark = str(parts[0].get("remark", ""))
    facts = facts_or_options(read_facts(remark, where) if remark.startswith(MARK) else None, name, rate, options)
    return facts.block(samples, [normal_unit(part["unit_str"]) for part in parts], rig, order=order), note


def draft_sep005(path: Path, options: ImportOptions) -> Rig:
    """The rig of a SEP005 file: the series of its first group, by their names and units.

    Raises:
        FormatError: no list of series.
    """
    drafts: list[DraftChannel] = []
    for name, series in next(iter(series_of(path).values())).items():
        unit = normal_unit(str(series["unit_str"]))
        drafts.append(DraftChannel(name, quantity_of(unit), unit))
    return rig_of(select_channels(drafts, options), path)
