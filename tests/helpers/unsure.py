"""Small campaigns that leave several explanations, and diagnoses that say so, without a search."""

from dataclasses import replace

from made_diagnosis import made_diagnosis

from modallab.core.block import Campaign
from modallab.core.diagnosis import CandidateSet, Diagnosis
from modallab.core.effects import Effect
from modallab.core.rig import Rig


def of_sensors(campaign: Campaign, points: tuple[int, ...], hits: tuple[int, ...] | None = None) -> Campaign:
    """The campaign as fewer accelerometers saw it, and of the hits only those at these points."""
    rows = [c.index for c in campaign.rig.channels if c.point is None or c.point in points]
    kept = [b for b in campaign.blocks if hits is None or b.test == "sine" or b.drive_point in hits]
    blocks = [
        replace(
            b,
            samples=b.samples[rows],
            scale=b.scale[rows],
            units=tuple(b.units[r] for r in rows),
            channels=tuple(b.channels[r] for r in rows),
        )
        for b in kept
    ]
    return replace(campaign, rig=rig_of_sensors(campaign.rig, points), blocks=tuple(blocks))


def rig_of_sensors(rig: Rig, points: tuple[int, ...]) -> Rig:
    """The rig with the accelerometers at these points only."""
    kept = [c for c in rig.channels if c.point is None or c.point in points]
    return rig.model_copy(update={"channels": tuple(c.model_copy(update={"index": k}) for k, c in enumerate(kept))})


def remaining_explanations(rig: Rig, *effects: Effect) -> Diagnosis:
    """A diagnosis that cannot decide between these effects."""
    found = made_diagnosis(rig, effects[0])
    share = 1 / len(effects)
    sets = [
        CandidateSet(effects=[e.effect], probability=share - 1e-6 * k, gap=1.0, fitted=[e], twin=found.twin)
        for k, e in enumerate(effects)
    ]
    return found.model_copy(update={"candidates": sets})
