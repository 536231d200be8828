"""Records at several levels: whether the modes go with their amplitude, and the model nearest to the linear one."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from modallab.core.errors import ModallabError
from modallab.core.model import ModalModel, Verification
from modallab.core.units import Test
from modallab.identification.backbone import DriveLevel, backbone_of, is_nonlinear
from modallab.identification.backbone_laws import level_notes
from modallab.identification.options import IdentificationOptions
from modallab.signals.signals import Signals
from modallab.verification.assessment import ModelAssessment

Source = Test | Literal["frf"]
Groups = Sequence[Sequence[Signals]]
FORCE_RATIO = 1.5
"""Hits are of two levels if the harder ones are this much harder."""


@dataclass(frozen=True, eq=False, slots=True)
class IdentifiedTest:
    """One test's model, its verification and its assessment; none for the peak method: it has no model of the block.

    `index` is the place among the campaign's FRFs of the one it came from.
    """

    source: Source
    model: ModalModel
    verification: Verification | None
    assessment: ModelAssessment | None = None
    index: int = 0


def group_by_level(signals: Sequence[Signals]) -> list[tuple[str, list[Signals]]]:
    """The records of each level that they name, from the weakest force to the strongest."""
    names = dict.fromkeys(s.block.level or "" for s in signals)
    found = [(name, [s for s in signals if (s.block.level or "") == name]) for name in names]
    return sorted(found, key=lambda level: np.mean([_strength_of_drive(s) for s in level[1]]))


def group_by_strength(groups: Groups) -> list[tuple[str, list[list[Signals]]]]:
    """Hits at the points that were hit at several levels, from the softest to the hardest; none if there are no such.

    Levels are those that the hits name; where they name none, hits whose peaks are near each other.

    Args:
        groups: the hits at each point.
    """
    levels = [_levels_of(group) for group in groups]
    count = min((len(each) for each in levels if len(each) > 1), default=0)
    found: list[tuple[str, list[list[Signals]]]] = []
    for k in range(count):
        parts = [each[k * (len(each) - 1) // (count - 1)] for each in levels if len(each) > 1]
        name = parts[0][0].block.level or f"{np.mean([_peak_force(hit) for part in parts for hit in part]):.3g} N"
        found.append((name, parts))
    return found


def weakest_hits(groups: Groups) -> list[Signals]:
    """The hits of the softest level at each point."""
    return [hit for group in groups for hit in _levels_of(group)[0]]


def _levels_of(hits: Sequence[Signals]) -> list[list[Signals]]:
    if len({s.block.level for s in hits}) > 1:
        return [records for _, records in group_by_level(hits)]
    found: list[list[Signals]] = []
    for hit in sorted(hits, key=_peak_force):
        if found and _peak_force(hit) <= FORCE_RATIO * _peak_force(found[-1][0]):
            found[-1].append(hit)
        else:
            found.append([hit])
    return found


def model_of_weakest_level(
    pooled: IdentifiedTest | None,
    levels: Sequence[DriveLevel],
    identify: Callable[[IdentificationOptions], IdentifiedTest],
    options: IdentificationOptions,
) -> IdentifiedTest | None:
    """The model of the weakest level with its modes' backbones, where the modes go with the level.

    Overtones that stand for modes at the weakest level are dropped. Else the pooled model is left as it is.

    Args:
        pooled: the model of all records, with its verdict on linearity; None if they gave none.
        levels: from the weakest to the strongest.
        identify: the records of the weakest level.
        options: of the identification.
    """
    if len(levels) < 2:
        return pooled
    try:
        weak = identify(options)
        found = backbone_of(weak.model, levels)
        if not found.alone.all():
            weak = identify(replace(options, drop_hz=(*options.drop_hz, *weak.model.frequency_hz[~found.alone])))
            found = backbone_of(weak.model, levels)
    except ModallabError:
        return pooled
    if not is_nonlinear(found.backbone).any():
        return pooled
    weakest = f"Frequencies depend on the level: the model is that of the weakest level, {levels[0].name}."
    notes = (*weak.model.notes, *level_notes(found.backbone, weak.model), weakest)
    model = weak.model.model_copy(update={"backbone": found.backbone, "notes": notes})
    assessment = weak.assessment if pooled is None else _with_linearity(weak.assessment, pooled.assessment)
    return replace(weak, model=model, assessment=assessment)


def is_linear(found: IdentifiedTest) -> bool:
    """Whether the verdict is that linearity holds."""
    verdicts = () if found.assessment is None else found.assessment.verdicts
    return any(verdict.holds for verdict in verdicts if verdict.assumption == "linearity")


def _with_linearity(own: ModelAssessment | None, pooled: ModelAssessment | None) -> ModelAssessment | None:
    """An assessment with the verdict on linearity of all levels."""
    if own is None or pooled is None:
        return own
    verdict = [v for v in pooled.verdicts if v.assumption == "linearity"]
    others = [v for v in own.verdicts if v.assumption != "linearity"]
    unjudged = tuple(one for one in own.unjudged if one[0] != "linearity")
    return replace(own, verdicts=(*verdict, *others), unjudged=unjudged)


def _peak_force(signals: Signals) -> float:
    return float(np.max(np.abs(signals.force)))


def _strength_of_drive(signals: Signals) -> float:
    return float(np.sqrt(np.mean(signals.forces**2)))
