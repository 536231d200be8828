"""What may be wrong, as coordinates for a fit: every effect the twin can predict, at every place it may be.

Positive numbers are searched as logarithms, shares as logits, so that no step leaves their range (Gelman et al.,
Bayesian Data Analysis, 2013).
"""

from itertools import combinations

from modallab.core.effects import PlaceKind
from modallab.core.rig import Rig
from modallab.gap.conditioning.rows import Reduced
from modallab.twin.candidate import CandidateEffect
from modallab.twin.effect_model import EffectModel, Overtones
from modallab.twin.effects import effect_models, search_of


def beam_candidates(rig: Rig) -> list[CandidateEffect]:
    """Linear effects that have one place each, or lie somewhere along the beam."""
    return [c for m in _searched() if m.kind.place not in ("channel", "pair") for c in m.candidates(rig)]


def stepped_candidates(rig: Rig, overtones: Overtones) -> list[CandidateEffect]:
    """Effects of the beam that depend on the size of the motion and make such overtones; each is stepped in time."""
    found = [
        (m.search.rank, m)
        for m in effect_models().values()
        if m.search is not None and m.search.law.overtones == overtones and not m.kind.linear
    ]
    return [c for _, m in sorted(found, key=lambda f: f[0]) for c in m.candidates(rig)]


def channel_candidates(rig: Rig, channel: int) -> list[CandidateEffect]:
    """Effects on one accelerometer."""
    return [c for m in _searched("channel") for c in m.candidates(rig, (channel,))]


def pair_candidates(rig: Rig, channels: tuple[int, ...]) -> list[CandidateEffect]:
    """Effects on two accelerometers, for every two of these channels."""
    return [c for m in _searched("pair") for pair in combinations(channels, 2) for c in m.candidates(rig, pair)]


def has_needed_tests(candidate: CandidateEffect, data: Reduced) -> bool:
    """Whether the data hold the test that the effect needs."""
    needs = search_of(candidate.effect).needs
    struck = any(not d.piece.by_shaker for d in data.impacts)
    return {"impact": struck, "shaker": data.shaker_x_m is not None, "sine": data.sines is not None, None: True}[needs]


def _searched(place: PlaceKind | None = None) -> list[EffectModel]:
    found = [(m.search.rank, m) for m in effect_models().values() if m.search is not None and m.kind.linear]
    return [m for _, m in sorted(found, key=lambda f: f[0]) if place in (None, m.kind.place)]
