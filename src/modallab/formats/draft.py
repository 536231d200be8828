"""A rig for recordings that came without one: from what their file says, and what is usual where it says nothing."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from modallab.core.digits import count_with_noun
from modallab.core.errors import DataError
from modallab.core.frf import FrfQuantity
from modallab.core.rig import Channel, Direction, Point, Rig
from modallab.core.units import SI_UNIT, Quantity
from modallab.formats.atomic import replacing
from modallab.formats.options import ImportOptions
from modallab.formats.rig.rig_file import dump_rig
from modallab.formats.unit_text import quantity_of

MEASURED: dict[FrfQuantity, Quantity] = {
    "receptance": "displacement",
    "mobility": "velocity",
    "inertance": "acceleration",
}
"""Motion that is measured for each kind of FRF."""
FORCE_NAMES = ("force", "hammer", "ham", "kraft", "impact", "f")


@dataclass(frozen=True, slots=True)
class DraftChannel:
    """What a file says of one channel; None or "" where it says nothing."""

    name: str
    quantity: Quantity | None = None
    unit: str = ""
    point: int | None = None
    direction: Direction | None = None


def rig_of(
    drafts: Sequence[DraftChannel],
    path: Path,
    points: tuple[Point, ...] = (),
    lines: tuple[tuple[int, int], ...] = (),
    driven: Iterable[int] = (),
    surfaces: tuple[tuple[int, ...], ...] = (),
) -> Rig:
    """A rig of the channels in their order; where a place is not known, points stand a metre apart.

    Args:
        drafts: of each channel.
        path: of the file, which names the rig.
        points: the geometry's.
        lines: of the geometry.
        driven: points where a force acts.
        surfaces: of the geometry.

    Raises:
        DataError: several forces.
    """
    forces = [i for i, s in enumerate(drafts) if _is_force(s)]
    if len(forces) > 1:
        raise DataError(
            f"has {len(forces)} channels of force: {', '.join(drafts[i].name for i in forces)}",
            where=str(path),
            remedy="a rig holds one force: write a rig file with one of them, and give it with --rig",
        )
    channels = [_channel(i, s, drafts, force=forces[:1] == [i]) for i, s in enumerate(drafts)]
    named = {c.point for c in channels if c.point} | set(driven)
    force = next((c for c in channels if c.quantity == "force"), None)
    return Rig(
        name=path.stem,
        model="unknown",
        drive_direction="+z" if force is None else force.direction,
        points=with_named_points(points, named),
        lines=lines,
        surfaces=surfaces,
        channels=tuple(channels),
    )


def with_named_points(points: tuple[Point, ...], named: Iterable[int]) -> tuple[Point, ...]:
    """Points of a geometry and those that are only named, a metre apart."""
    more = sorted(set(named) - {p.id for p in points})
    return (*points, *(Point(id=n, x_m=float(n)) for n in more))


def select_channels(drafts: Iterable[DraftChannel], options: ImportOptions) -> list[DraftChannel]:
    """The channels that the user takes, as `options.channels` and `options.ignore` say.

    Raises:
        DataError: a channel that is to be taken is not there, or none is left.
    """
    every = list(drafts)
    found = [one for one in every if options.takes(one.name)]
    missing = [n for n in options.channels if n.lower() not in {one.name.lower() for one in every}]
    if missing or not found:
        what = f"there is no channel {', '.join(missing)}" if missing else "no channel is left"
        there = ", ".join(one.name for one in every)
        raise DataError(
            f"{what}; there are {there}", remedy="name some of these with --channels, or fewer with --ignore"
        )
    return found


def assumptions(rig: Rig) -> tuple[str, ...]:
    """What of a drafted rig no file said, in sentences."""
    far = [p.id for p in rig.points if p.x_m == p.id and not (p.y_m or p.z_m)]
    notes = (
        [f"no place is known of {count_with_noun(len(far), 'point')}; the rig file sets points 1 m apart"]
        if far
        else []
    )
    if rig.force is None:
        notes.append("no force was measured: identify the responses alone (--response-only)")
    units = ", ".join(dict.fromkeys(f"{c.quantity} in {c.unit}" for c in rig.channels))
    notes.append(f"channels are taken as {units}; where the file names no unit, that is assumed")
    return tuple(notes)


def write_draft(rig: Rig, out: Path, notes: Sequence[str]) -> None:
    """Write a rig file for the user to complete.

    Raises:
        StorageError: the file cannot be written.
    """
    head = [
        "Drafted from a recording. Complete it: sensitivities, directions, masses and places of the sensors.",
        *notes,
        "Then import again with --rig and this file; the fields stand in docs/reference/rig-file.md.",
    ]
    with replacing(out) as temporary:
        temporary.write_text("".join(f"# {line}\n" for line in head) + dump_rig(rig), encoding="utf-8")


def _is_force(draft: DraftChannel) -> bool:
    if draft.quantity is not None:
        return draft.quantity == "force"
    return draft.name.strip().lower() in FORCE_NAMES


def _channel(index: int, draft: DraftChannel, others: Sequence[DraftChannel], *, force: bool) -> Channel:
    quantity = "force" if force else draft.quantity if draft.quantity not in (None, "force") else "acceleration"
    unit = draft.unit if draft.unit and quantity_of(draft.unit) == quantity else SI_UNIT[quantity]
    twice = sum(s.name == draft.name for s in others) > 1
    return Channel(
        index=index,
        name=f"{draft.name} {index}" if twice else draft.name,
        quantity=quantity,
        unit=unit,
        point=draft.point,
        direction=draft.direction or "+z",
    )
