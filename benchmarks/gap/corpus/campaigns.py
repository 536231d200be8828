"""The campaigns of the corpus: their rows in `campaigns.csv`, which of them are asked for, and in which order."""

import csv
import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import Any, TypeVar

from modallab.core.effects import catalogue
from modallab.twin.effect_model import NoChange
from modallab.twin.effects import effect_models

LIST = Path(__file__).parent / "campaigns.csv"
SECONDS = {"none": 5.0, "single": 35.0, "pair": 79.0, "unknown": 191.0, "stepped": 75.0, "structure": 6.0}
"""Kinds of campaigns, and what one took in the median when the corpus was made: only the order follows from it."""
KINDS = tuple(SECONDS)
Item = TypeVar("Item")


@dataclass(frozen=True)
class Entry:
    """One campaign.

    Attributes:
        id: its name; of another bench's campaign its folder.
        set: practice, practice_rough, own_built, own_ideal, decisions, structures or sealed.
        kind: of its truth, one of KINDS.
        how: it is made: folder, usual or none (tolerances of the own bench), plate or tube (the reference identified),
            plate computed or tube computed.
        effect: asked of the draw.
        seed: of the draw.
        seen: whether it was looked at while today's engine was developed: seen or unseen.
        named: the decision pages that tell of it.
        effects: as drawn, as JSON; "" where the truth is a file or is drawn when the campaign is made.
    """

    id: str
    set: str
    kind: str
    how: str
    effect: str
    seed: str
    seen: str
    named: str = ""
    effects: str = ""

    @property
    def drawn(self) -> list[dict[str, Any]] | None:
        return json.loads(self.effects) if self.effects else None


def entries(file: Path = LIST) -> list[Entry]:
    with file.open(encoding="utf-8", newline="") as source:
        return [Entry(**row) for row in csv.DictReader(source)]


def write(file: Path, listed: Sequence[Entry]) -> None:
    with file.open("w", encoding="utf-8", newline="") as target:
        writer = csv.DictWriter(target, list(Entry.__dataclass_fields__), lineterminator="\n")
        writer.writeheader()
        writer.writerows(vars(e) for e in listed)


def kind_of_truth(names: Sequence[str]) -> str:
    """The kind of campaign with these effects; outside the catalogue and pairs go before stepped."""
    if not names:
        return "none"
    if any(name not in catalogue() for name in names):
        return "unknown"
    if len(names) > 1:
        return "pair"
    return "stepped" if is_stepped(names[0]) else "single"


def is_stepped(name: str) -> bool:
    """Whether the twin steps an effect in time: its law depends on the size of the motion."""
    return not catalogue()[name].linear and not isinstance(effect_models()[name].change, NoChange)


def chosen(listed: Iterable[Entry], only: Sequence[str]) -> list[Entry]:
    """Those whose kind, set, kind/set or id is among some words; all if there are none."""
    return [e for e in listed if not only or {e.kind, e.set, f"{e.kind}/{e.set}", e.id} & set(only)]


def ordered(listed: Sequence[Entry], order: str) -> list[Entry]:
    """In which order campaigns are answered.

    `stratified`: a fair sample wherever it ends, kinds by one over the root of their seconds, which says most in a
    given time (Neyman's allocation), and sets in turn within a kind. `file`: as listed.
    """
    if order == "file":
        return list(listed)
    keyed = [(key, entry) for kind in KINDS for key, entry in _keyed(kind, listed)]
    return [entry for _, entry in sorted(keyed, key=lambda pair: pair[0])]


def _keyed(kind: str, listed: Sequence[Entry]) -> list[tuple[float, Entry]]:
    of = [e for e in listed if e.kind == kind]
    sets = [[e for e in of if e.set == name] for name in dict.fromkeys(e.set for e in of)]
    return [((n + 0.5) * SECONDS[kind] ** 0.5, entry) for n, entry in enumerate(in_turn(sets))]


def in_turn(lists: Sequence[Sequence[Item]]) -> list[Item]:
    """The first of each list, the second of each, and so on."""
    return [item for row in zip_longest(*lists) for item in row if item is not None]
