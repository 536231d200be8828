"""Universal files: time records become blocks, FRFs an FRF matrix."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from modallab.core.array_checks import check_rate, check_time
from modallab.core.axis_checks import nearest_whole_rate
from modallab.core.block import Block, Campaign
from modallab.core.errors import DataError
from modallab.core.rig import Direction, Point, Rig
from modallab.formats.block_facts import facts_or_options, read_facts
from modallab.formats.draft import MEASURED, DraftChannel, rig_of, select_channels
from modallab.formats.options import ImportOptions
from modallab.formats.starts import cut_to_common_time, one_rate, start_of
from modallab.formats.uff.uff_frf import read_frf
from modallab.formats.uff.uff_functions import KINDS, FileUnits, Function, UniversalFile, read_functions
from modallab.formats.uff.uff_match import SPECIFIC, Match, known_point, match_channel, unit_of
from modallab.formats.uff.uff_results import read_results
from modallab.formats.uff.uff_systems import read_nodes
from modallab.formats.unit_text import frf_unit, quantity_of

_USED = (1, 4, 6)
_Group = dict[str, tuple[Function, Match]]
_DIRECTIONS: dict[int, Direction] = {1: "+x", 2: "+y", 3: "+z", -1: "-x", -2: "-y", -3: "-z"}


def read_uff(path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    """Read the functions (dataset 58, text or binary) of a universal file.

    Raises:
        FormatError: no universal file, cut off or damaged.
        DataError: neither time records nor FRFs, or not those of the rig.
    """
    where = str(path)
    content = read_functions(path)
    blocks, notes = _read_blocks(content, path, rig, options)
    frfs = read_frf(content, rig, where)
    if not blocks and not frfs:
        raise DataError(
            f"holds neither time records nor FRFs, only {_contents(content)}",
            where=where,
            remedy="export time records or FRFs as dataset 58",
        )
    skipped = [f for f in content.functions if f.kind not in _USED]
    left_out = (f"{path.name}: left out {_contents(content)}",) if skipped or content.others else ()
    remarks = (*notes, *left_out)
    return Campaign(rig, blocks, frfs, {"notes": "\n".join(remarks)} if remarks else {}, where)


def _contents(content: UniversalFile) -> str:
    functions = [KINDS.get(f.kind, f"function of type {f.kind}") for f in content.functions if f.kind not in _USED]
    return ", ".join(dict.fromkeys([*functions, *(f"dataset {kind}" for kind in content.others)])) or "no sets"


def _read_blocks(
    content: UniversalFile, path: Path, rig: Rig, options: ImportOptions
) -> tuple[tuple[Block, ...], tuple[str, ...]]:
    """The time records as blocks: the first record of each channel is of the first one, and so on; and notes on them.

    Raises:
        DataError: complex or uneven records, channels missing or unequal in rate, or not recorded together.
    """
    where = str(path)
    groups: list[_Group] = []
    for function in (f for f in content.functions if f.kind == 1):
        if np.iscomplexobj(function.values):
            raise DataError(
                f"set {function.place} is a time record of complex numbers", where=where, remedy="export it as real"
            )
        match = match_channel(function, rig.channels, where)
        before = sum(match.channel.name in group for group in groups)
        if before == len(groups):
            groups.append({})
        groups[before][match.channel.name] = (function, match)
    blocks: list[Block] = []
    notes: list[str] = []
    for order, group in enumerate(groups):
        name = path.stem if len(groups) == 1 else f"{path.stem}_{order + 1}"
        block, note = _block(group, name, order, content.units, rig, options, where)
        blocks.append(block)
        notes += [f"{name}: {note}"] if note else []
    return tuple(blocks), tuple(notes)


def _block(
    group: _Group, name: str, order: int, units: FileUnits | None, rig: Rig, options: ImportOptions, where: str
) -> tuple[Block, str]:
    _check_complete(group, rig, where)
    parts = [group[channel.name] for channel in rig.channels]
    functions = [function for function, _ in parts]
    rate = _common_rate(functions, options, where)
    samples, note = cut_to_common_time(
        [np.asarray(f.values, dtype=np.float64) for f in functions],
        [start_of(float(f.axis[0]), f.start_error) for f in functions],
        rate,
        [f"{channel.name} (set {f.place})" for channel, f in zip(rig.channels, functions, strict=True)],
        where,
    )
    # Our own files carry the facts of a block in the last two identification lines.
    facts = facts_or_options(
        read_facts("".join(n for n in functions[0].names[3:5] if n != "NONE"), where), name, rate, options
    )
    facts = replace(facts, drive_point=_drive_point(group, rig, options, where))
    channel_units = [unit_of(f, units, where) for f in functions]
    signs = np.array([match.sign for _, match in parts], dtype=np.float64)
    block = facts.block(samples, channel_units, rig, order=order, scale=signs)
    return block, note


def _check_complete(group: _Group, rig: Rig, where: str) -> None:
    missing = [channel.name for channel in rig.channels if channel.name not in group]
    if missing:
        places = ", ".join(str(function.place) for function, _ in group.values())
        raise DataError(
            f"no time record for channel {', '.join(missing)} beside sets {places}",
            where=where,
            remedy="export every channel of the rig, or leave these channels out of the rig",
        )


def _common_rate(functions: Sequence[Function], options: ImportOptions, where: str) -> float:
    rates = {f"set {function.place}": _rate(function, where) for function in functions}
    return options.agreed(one_rate(rates, where) or 0.0, where)


def _rate(function: Function, where: str) -> float:
    where = f"{where}, set {function.place}"
    if not function.even:
        return check_time(function.axis, where, resolution_s=function.axis_error)
    step = float(function.axis[1] - function.axis[0]) if len(function.axis) > 1 else 0.0
    if not step > 0:
        raise DataError(f"the time step is {step:g} s", where=where, remedy="export the record with its time step")
    return check_rate(nearest_whole_rate(1 / step, function.axis_error / step**2), where)


def _drive_point(group: _Group, rig: Rig, options: ImportOptions, where: str) -> int | None:
    if options.drive_point is not None or rig.force is None:
        return options.drive_point
    force = group[rig.force_channel.name][0]
    nodes = [force.node, *(function.reference_node for function, _ in group.values())]
    return known_point(next((node for node in nodes if node), 0), rig, where)


def draft_uff(path: Path, options: ImportOptions) -> Rig:
    """The rig that a universal file's time records or FRFs were made on, as far as it says.

    Raises:
        FormatError: no universal file, cut off or damaged.
        DataError: it holds neither time records nor FRFs.
    """
    content, where = read_functions(path), str(path)
    used = [f for f in content.functions if f.kind == 1] or [f for f in content.functions if f.kind == 4]
    if not used:
        raise DataError(
            f"holds neither time records nor FRFs, only {_held(content.functions, content.others)}",
            where=where,
            remedy="export time records or FRFs as dataset 58"
            + (
                "; spectra and PSDs by themselves do not hold the phases that a model needs"
                if content.functions
                else ""
            ),
        )
    nodes = read_nodes(path)

    def turned(one: DraftChannel) -> DraftChannel:
        if one.point is None or one.direction is None:
            return one
        return replace(one, direction=nodes.direction(one.point, one.direction, where))

    drafts = select_channels(
        (turned(one) for one in dict.fromkeys(_draft_of(f, _name_at(used)) for f in used)), options
    )
    if used[0].kind == 4:
        node, axis = used[0].reference_node, used[0].reference_direction
        drafts.insert(0, turned(DraftChannel("force", "force", "N", node or None, _DIRECTIONS.get(axis))))
    found = read_results(path).geometry
    drives = {f.reference_node for f in used if f.reference_node}
    places = {n: Point(id=n, x_m=at[0], y_m=at[1], z_m=at[2]) for n, at in found.points.items() if n > 0}
    return rig_of(drafts, path, tuple(places.values()), found.lines, drives, found.surfaces)


def _name_at(functions: Sequence[Function]) -> int:
    """Which of a set's texts names its channel: the entity's name, or the first line where entities share theirs."""
    return 0 if len({f.names[0] for f in functions}) >= len({f.names[1] for f in functions}) else 1


def _draft_of(function: Function, name_at: int) -> DraftChannel:
    of_frf = frf_unit(function.unit, function.divisor_unit) if function.kind == 4 else None
    if of_frf is not None:
        quantity, unit = MEASURED[of_frf[0]], ""
    else:
        quantity = quantity_of(function.unit) or SPECIFIC.get(function.specific)
        unit = function.unit if quantity is not None and quantity_of(function.unit) else ""
    ordered = (function.names[name_at], *function.names[:2])
    name = next((n for n in ordered if n not in ("", "NONE")), "")
    at = f"p{function.node}{_DIRECTIONS.get(function.direction, '')}" if function.node else f"set {function.place}"
    # What stands at a node is known by it; of FRFs to several nodes the name would not tell.
    return DraftChannel(
        at if not name or (function.kind == 4 and function.node) else name,
        quantity,
        unit,
        function.node or None,
        _DIRECTIONS.get(function.direction),
    )


def _held(functions: Iterable[Function], others: Iterable[int]) -> str:
    kinds = [KINDS.get(f.kind, f"function of type {f.kind}") for f in functions]
    return ", ".join(dict.fromkeys([*kinds, *(f"dataset {kind}" for kind in others)])) or "no sets"
