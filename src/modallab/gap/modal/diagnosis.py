"""The diagnosis of a structure that no beam describes: its modal model stands for the simulation."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.diagnosis import CandidateSet
from modallab.core.effects import kind_of
from modallab.core.frf import Frf
from modallab.core.modal_diagnosis import FoundChange, ModalDiagnosis
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.gap.modal.candidates import EVERY
from modallab.gap.modal.compared import SMOOTHER, Compared, compared
from modallab.gap.modal.coupled import CoupledPair, pair_of, refined, unlike
from modallab.gap.modal.free import Free
from modallab.gap.modal.judged import Judged, judged, strain
from modallab.gap.modal.parts import Misses, by_channel, by_mode
from modallab.gap.modal.search import Fitted, explanations
from modallab.gap.model.tolerances import with_tolerances
from modallab.modification.freedoms import Freedom
from modallab.modification.mesh import Mesh

Real = NDArray[np.float64]

TWO_SIDED = 1.96
TRUNCATED = 0.08
"""Deviation of the logarithm of a mass or a spring: modes outside the band are one compliance at its place alone."""
LOOSE = 5.0
"""How much looser a search begins than it ends."""


@dataclass(frozen=True, eq=False, slots=True)
class Explained:
    """What a comparison came to, with the comparison itself.

    Attributes:
        free: what was compared, and the numbers that were free in it.
        judged: the fits, and which of them counts.
        diagnosis: what is said of it.
    """

    free: Free
    judged: Judged
    diagnosis: ModalDiagnosis

    @property
    def ranked(self) -> list[FoundChange]:
        """Every explanation that was fitted to the end, the most probable first."""
        return [changed(self.free.of, f, p) for f, p in self.judged.ranked if f.candidate is not None]


def diagnose_by_model(
    reference: ModalModel,
    bench: ModalModel,
    rig: Rig,
    mesh: Mesh | None = None,
    own: Rig | None = None,
    frfs: tuple[Frf, Frf] | None = None,
) -> ModalDiagnosis:
    """What differs between a structure's modal model and the structure as it is, beyond the rig's tolerances.

    Args:
        reference: the simulation: identified before, or computed; with modal constants.
        bench: identified from the records of today; compared on the points and axes that both have.
        rig: points, channels and tolerances; the usual ones where it states none.
        mesh: the reference's shapes at nodes between the points, where it was computed.
        own: the reference's rig, where it is another.
        frfs: of reference and bench, as they were measured, where nothing of a block's end is in them.

    Raises:
        DataError: the two share no band, output or driven point.
    """
    return explained_by_model(reference, bench, rig, mesh, own, frfs).diagnosis


def explained_by_model(
    reference: ModalModel,
    bench: ModalModel,
    rig: Rig,
    mesh: Mesh | None = None,
    own: Rig | None = None,
    frfs: tuple[Frf, Frf] | None = None,
) -> Explained:
    """The same with the fits behind it, from which FRFs can be drawn.

    Raises:
        DataError: as `diagnose_by_model`.
    """
    known = with_tolerances(rig)
    free = Free(compared(reference, bench, known, mesh=mesh, own=own))
    pair = None if frfs is None else pair_of(*frfs, free.of)
    if pair is not None:
        free = Free(free.of.off_by(unlike(pair, free.of)))
    base, tried = explanations(levels(reference, bench, known, free, mesh, own))
    found = _from_frfs(free, judged(free, base, tried), pair)
    return Explained(free, found, _said(free, found, (reference.n_modes, bench.n_modes)))


def _from_frfs(free: Free, found: Judged, pair: CoupledPair | None) -> Judged:
    """The same with the size of what hangs at a driven point from the FRFs themselves."""
    if pair is None:
        return found
    better = {id(f): refined(free, f, pair) for f, _ in found.ranked}
    ranked = [(better[id(f)], p) for f, p in found.ranked]
    return replace(found, best=better.get(id(found.best), found.best), ranked=ranked)


def levels(
    reference: ModalModel, bench: ModalModel, rig: Rig, last: Free, mesh: Mesh | None = None, own: Rig | None = None
) -> list[Free]:
    """The comparison from the smoothest and loosest to the last."""
    smoother = [Free(compared(reference, bench, rig, smooth, mesh, own), LOOSE) for smooth in SMOOTHER]
    return [*smoother, Free(last.of, LOOSE), last]


def _said(free: Free, found: Judged, modes: tuple[int, int]) -> ModalDiagnosis:
    best, probable = found.best, {id(f): p for f, p in found.ranked}
    known = found.verdict == "known"
    misses = Misses.of(free, found.base, best)
    return ModalDiagnosis(
        rig=free.of.rig.name,
        verdict=found.verdict,
        nominal=free.share(np.zeros(free.size)),
        before=free.share(found.base.u),
        after=free.share(best.u, best.change),
        strain_before=strain(free, found.base),
        strain_after=strain(free, best),
        effects=[changed(free.of, best, probable[id(best)])] if known else [],
        candidates=[
            CandidateSet(effects=[f.candidate.effect], probability=p, gap=free.share(f.u, f.change))
            for f, p in found.ranked
            if f.candidate is not None
        ],
        modes=modes,
        by_channel=by_channel(free, misses),
        by_mode=by_mode(free, misses),
        notes=found.notes,
    )


def changed(c: Compared, fitted: Fitted, probability: float) -> FoundChange:
    """A fitted change with its numbers, their intervals and its place."""
    candidate = fitted.candidate
    assert candidate is not None
    # What the best explanation leaves is the scale of an error, as in the probabilities.
    widened = 1.0 if fitted.measured else max(1.0, np.sqrt(fitted.cost / fitted.u.size))
    sigma = np.sqrt(np.diag(fitted.covariance))[fitted.u.size :] * widened
    if candidate.freedoms and not fitted.measured:
        sigma[0] = np.hypot(sigma[0], TRUNCATED)
    values, spread = _numbers(c, fitted, sigma)
    within = {
        name: (value * float(np.exp(-TWO_SIDED * s)), value * float(np.exp(TWO_SIDED * s)))
        if candidate.freedoms
        else (value - TWO_SIDED * s, value + TWO_SIDED * s)
        for (name, value), s in zip(values.items(), spread, strict=True)
    }
    return FoundChange(
        effect=candidate.effect,
        stage=kind_of(candidate.effect).stage,
        probability=probability,
        parameters=values,
        interval=within,
        place=_place(c, fitted),
    )


def _numbers(c: Compared, fitted: Fitted, sigma: Real) -> tuple[dict[str, float], list[float]]:
    """Numbers by name and their sigmas; of a mass or a spring that of the logarithm."""
    candidate, v = fitted.candidate, fitted.v
    assert candidate is not None
    number = kind_of(candidate.effect).parameters[0].name
    if candidate.freedoms:
        return {number: float(np.exp(v[0]))}, [float(sigma[0])]
    if candidate.effect == "position_error":
        tangents = c.shapes.tangents(_freedom(c, candidate.channel or 0))
        names = ("dx", "dy", "dz")
        return dict(zip(names, (v[:2] @ tangents).tolist(), strict=True)), np.sqrt(
            sigma[:2] ** 2 @ tangents**2
        ).tolist()
    return {number: float(v[0])}, [float(sigma[0])]


def _place(c: Compared, fitted: Fitted) -> dict[str, object]:
    candidate, v = fitted.candidate, fitted.v
    assert candidate is not None
    if candidate.effect in EVERY:
        return {"channels": "all"}
    if not candidate.freedoms:
        force = c.rig.force_channel.name
        return {"channel": force if candidate.channel is None else c.model.outputs[candidate.channel]}
    freedom = candidate.freedoms[0]
    at = c.shapes.at_m[c.shapes.index(freedom)] + v[1:3] @ c.shapes.tangents(freedom)
    nearest = int(np.argmin(np.linalg.norm(c.shapes.at_m - at, axis=1)))
    place: dict[str, object] = {"point": c.shapes.freedoms[nearest][0], "at_m": at.tolist()}
    return place | ({"axis": freedom[1]} if candidate.effect != "added_mass" else {})


def _freedom(c: Compared, output: int) -> Freedom:
    axes = {channel.name: channel.direction[1] for channel in c.rig.channels}
    return (c.model.output_points[output] or 0, axes[c.model.outputs[output]])
