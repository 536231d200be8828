"""A rig from what a universal file says of its channels and its geometry."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

from modallab.core.errors import DataError
from modallab.core.rig import Direction, Point, Rig
from modallab.formats.draft import MEASURED, DraftChannel, rig_of, select_channels
from modallab.formats.options import ImportOptions
from modallab.formats.uff.uff_functions import KINDS, Function, read_functions
from modallab.formats.uff.uff_match import SPECIFIC
from modallab.formats.uff.uff_results import read_results
from modallab.formats.uff.uff_systems import read_nodes
from modallab.formats.unit_text import frf_unit, quantity_of

_DIRECTIONS: dict[int, Direction] = {1: "+x", 2: "+y", 3: "+z", -1: "-x", -2: "-y", -3: "-z"}


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
