"""An explanation of a diagnosis as a fit again: its effects and its twin, read back from the document."""

from math import log

import numpy as np

from modallab.core.arrays import Real
from modallab.core.diagnosis import CandidateSet, TwinParameters
from modallab.core.effect import AlongBeam, TwoChannels, channels_of_place
from modallab.core.effects import Effect, kind_of
from modallab.core.errors import DataError
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.model.candidates import beam_candidates, channel_candidates, pair_candidates
from modallab.gap.model.fit import Problem
from modallab.gap.model.nuisances import Nuisances, beam_of
from modallab.gap.model.tolerances import FREE, MOST
from modallab.twin.candidate import CandidateEffect, FreeNumber
from modallab.twin.structure import ROOT, root_of_rig_file

EDGE = 1e-6
"""How near to its bounds a share may be."""


def coordinates_of_twin(twin: TwinParameters, free: Nuisances) -> Real:
    """(size,) the nuisances at which a fit left the twin: what `calibrated` wrote down, the other way round.

    Args:
        twin: the numbers.
        free: the nuisances, which may be of another campaign of the same rig: what the document does not mention, such
            as where the hits at a new point land, is 0.
    """
    rig, u = free.rig, np.zeros(free.size)
    beam, t = beam_of(rig), rig.tolerance
    own = (
        (twin.youngs_modulus_pa / beam.youngs_modulus_pa, t.youngs_modulus),
        (twin.thickness_m / beam.thickness_m, t.thickness),
        (twin.density_kg_m3 / beam.density_kg_m3, t.density),
    )
    u[:3] = [_free(log(ratio) / sigma) if sigma else 0.0 for ratio, sigma in own]
    zeta = np.array(twin.zeta[: free.modes]) / rig.damping_ratio.guess
    u[3 : 3 + free.modes] = np.log(zeta) / log(rig.damping_ratio.factor)
    for k, channel in enumerate(free.gains):
        u[3 + free.modes + k] = _free(log(twin.gains.get(channel, 1.0)) / free.tolerance)
    stated = {(d.tolerance, d.at): d.u for d in twin.departures}
    u[free.first_deviation : free.first_deviation + len(free.deviations)] = [
        stated.get((d.tolerance, d.at), 0.0) for d in free.deviations
    ]
    if free.root:
        u[-2] = _free(log(twin.root_rotation / root_of_rig_file(beam)) / ROOT)
    u[-1] = 0.5 + _free(twin.residual_compliance - 0.5, 0.6, 1.0)
    return u


def _free(value: float, free: float = FREE, most: float = MOST) -> float:
    """The inverse of `limited_number`: what was pressed together towards its bound, as it was."""
    if abs(value) < free:
        return value
    room = most - free
    return float(np.sign(value) * (free + room * np.arctanh(min((abs(value) - free) / room, 1 - 1e-9))))


def start_from_diagnosis(
    said: CandidateSet, data: Reduced, free: Nuisances, in_place: bool = False
) -> tuple[Problem, Real]:
    """An explanation's problem on records, and (u,) its numbers, from which a fit begins.

    Args:
        said: the explanation, with its numbers.
        data: the records, which may be others than it was found on.
        free: the nuisances, see `coordinates_of`.
        in_place: whether its effects stay where they are.

    Raises:
        DataError: it has an effect that no fit looks for on this rig.
    """
    assert said.twin is not None
    found = [_free_again(e, data) for e in said.fitted]
    found = [_held_in_place(*f) for f in found] if in_place else found
    u = np.concatenate([coordinates_of_twin(said.twin, free), *(own for _, own in found)])
    return Problem(data, free, tuple(f for f, _ in found), drift_curve=tuple(said.twin.drift_curve)), u


def _free_again(effect: Effect, data: Reduced) -> tuple[CandidateEffect, Real]:
    """An effect with its numbers free, and the coordinates at which it is this one."""
    for c in _like(effect, data):
        values = effect.parameters | ({"x": effect.place.x} if isinstance(effect.place, AlongBeam) else {})
        there = c.place == effect.place or "x" in (s.name for s in c.slots)
        if c.effect == effect.effect and there and all(values.get(k) == v for k, v in c.fixed):
            return c, np.array([_coordinate(s, values[s.name]) for s in c.slots])
    raise DataError(
        f"no fit looks for {effect.effect} at {effect.place}",
        where=data.rig.name,
        remedy="name the rig file that the campaign was diagnosed with",
    )


def _held_in_place(candidate: CandidateEffect, own: Real) -> tuple[CandidateEffect, Real]:
    names = [s.name for s in candidate.slots]
    if "x" not in names:
        return candidate, own
    at = names.index("x")
    return candidate.with_fixed_place(candidate.slots[at].value(float(own[at]))), np.delete(own, at)


def _like(effect: Effect, data: Reduced) -> list[CandidateEffect]:
    if isinstance(effect.place, TwoChannels):
        return pair_candidates(data.rig, effect.place.channel)
    kind, row = kind_of(effect.effect).place, channels_of_place(effect.place)
    return (
        channel_candidates(data.rig, row) if kind == "channel" and isinstance(row, int) else beam_candidates(data.rig)
    )


def _coordinate(slot: FreeNumber, value: float) -> float:
    near = float(np.clip(value, EDGE, 1 - EDGE)) if slot.transform == "share" else float(value)
    return slot.coordinate(near)
