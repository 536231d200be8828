"""The diagnosis of a structure that no beam describes: its modal model stands for the simulation."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from modallab.core.arrays import Real
from modallab.core.diagnosis import CandidateSet
from modallab.core.effect import BetweenPoints, EveryOutput, NamedChannel, NearPoint, PlaceOnStructure
from modallab.core.effects import kind_of
from modallab.core.frf import Frf
from modallab.core.modal_diagnosis import FoundChange, ModalDiagnosis
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.gap.modal.candidates import EVERY
from modallab.gap.modal.compared import SMOOTHER, Compared, compared
from modallab.gap.modal.fitting import FittedExplanation
from modallab.gap.modal.free import Free
from modallab.gap.modal.hanging import two_points
from modallab.gap.modal.judged import ModalVerdict, judged
from modallab.gap.modal.matching import Side
from modallab.gap.modal.off_axis import MeasuredFrfs
from modallab.gap.modal.parts import RelativeMisfits, by_channel, by_mode
from modallab.gap.modal.search import ModalSearch
from modallab.gap.model.tolerances import with_tolerances
from modallab.identification.backbone_laws import level_notes
from modallab.modification.freedoms import Freedom
from modallab.modification.mesh import Mesh
from modallab.updating.elements import COMPUTED

TWO_SIDED = 1.96
TRUNCATED = 0.08
"""Deviation of the logarithm of a mass or a spring: modes outside the band are one compliance at its place alone."""
FACTORS = ("gain_error", "force_gain")
"""Effects whose number is a factor, looked for by its logarithm."""
LOOSE = 5.0
"""How much looser a search begins than it ends."""


@dataclass(frozen=True, eq=False, slots=True)
class ComparisonOutcome:
    """What a comparison came to, with the comparison itself.

    Attributes:
        free: what was compared, and the numbers that were free in it.
        judged: the fits, and which of them counts.
        diagnosis: what is said of it.
    """

    free: Free
    judged: ModalVerdict
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
    frfs: tuple[Frf | None, Frf | None] = (None, None),
) -> ModalDiagnosis:
    """What is said of `explained_by_model`, which takes and raises the same."""
    return explained_by_model(reference, bench, rig, mesh, frfs=frfs).diagnosis


def explained_by_model(
    reference: ModalModel,
    bench: ModalModel,
    rig: Rig,
    mesh: Mesh | None = None,
    own: Rig | None = None,
    frfs: tuple[Frf | None, Frf | None] = (None, None),
) -> ComparisonOutcome:
    """What differs between a structure's modal model and the structure as it is, beyond the rig's tolerances.

    Args:
        reference: the simulation: identified before, or computed; with modal constants.
        bench: identified from the records of today; compared on the points and axes that both have.
        rig: points, channels and tolerances; the usual ones where it states none.
        mesh: the reference's shapes at nodes between the points, where it was computed.
        own: the reference's rig, where it is another.
        frfs: measured, that reference and bench were identified from.

    Raises:
        DataError: the two share no band, output or driven point.
    """
    known = with_tolerances(rig)
    before, after = (Side(m, MeasuredFrfs.of(frf, m)) for m, frf in zip((reference, bench), frfs, strict=True))
    compare = partial(compared, before, after, known, mesh=mesh, own=own)
    last = compare()
    smooth, closer = (Free(compare(width), LOOSE) for width in SMOOTHER)
    found = judged(ModalSearch.begun(smooth, closer, Free(last)))
    said = _said(Free(last), found, (reference.n_modes, bench.n_modes), _of_levels(bench))
    return ComparisonOutcome(Free(last), found, said)


def _said(free: Free, found: ModalVerdict, modes: tuple[int, int], levels: Sequence[str]) -> ModalDiagnosis:
    best, probable = found.best, {id(f): p for f, p in found.ranked}
    known = found.verdict == "known"
    misses = RelativeMisfits.of(free, found.base, best)
    said = ModalDiagnosis(
        rig=free.of.rig.name,
        verdict=found.verdict,
        nominal=free.share(np.zeros(free.size)),
        before=found.base.share,
        after=best.share,
        strain_before=found.strains[0],
        strain_after=found.strains[1],
        effects=[changed(free.of, best, probable[id(best)])] if known else [],
        candidates=[
            CandidateSet(effects=[f.candidate.effect], probability=p, gap=f.share)
            for f, p in found.ranked
            if f.candidate is not None
        ],
        nothing=found.nothing,
        unknown=found.unknown,
        modes=modes,
        by_channel=by_channel(free, misses),
        by_mode=by_mode(free, misses),
        notes=[*found.notes, *_without_name(found), *_of_the_whole(best), *levels],
    )
    return said.model_copy(update={"notes": [*said.notes, *_not_distinguished(said)]})


def _not_distinguished(said: ModalDiagnosis) -> list[str]:
    """Explanations that have 95 % together, where there are several."""
    each = said.explanations()
    listed = ", ".join(f"{name.replace('_', ' ')} {probability:.2f}" for name, probability in each.items())
    return [f"The records do not distinguish these explanations (probability): {listed}."] if len(each) > 1 else []


def _of_levels(bench: ModalModel) -> list[str]:
    """How a bench goes with its level, where it does: what is compared is its weakest."""
    if bench.backbone is None:
        return []
    weakest = f"The bench is compared at its weakest level, {bench.backbone.levels[0]}."
    return [*level_notes(bench.backbone, bench), weakest]


def _without_name(found: ModalVerdict) -> list[str]:
    """Where what has no name is."""
    whole = {"structure": "the structure itself, mode by mode", "everything": "every channel and point alike"}
    where = whole.get(found.where, found.where)
    return [f"Most likely what has no name is this: {where}."] if found.verdict == "unknown" else []


def _of_the_whole(best: FittedExplanation) -> list[str]:
    """What is said of E, where a computed reference is off as a whole."""
    log = float(best.free.parts(best.u)[0][0])
    sigma = float(np.sqrt(best.covariance[0, 0]) * best.free.deviations[0])
    if best.free.of.model.method != COMPUTED or abs(log) < TWO_SIDED * sigma:
        return []
    more = "stiffer" if log > 0 else "softer"
    off = f"{100 * abs(np.expm1(log)):.2g} %"
    return [f"The bench is {more} than the reference as a whole, by {off}: Young's modulus, or a thickness, is wrong."]


def changed(c: Compared, fitted: FittedExplanation, probability: float) -> FoundChange:
    """A fitted change with its numbers, their intervals and its place."""
    candidate = fitted.candidate
    assert candidate is not None
    # What the best explanation leaves is the scale of an error.
    widened = max(1.0, np.sqrt(fitted.cost / fitted.u.size))
    sigma = np.sqrt(np.diag(fitted.covariance))[fitted.u.size :] * widened
    hung = fitted.change.hung
    if hung is not None and None in (*hung.outputs, *hung.inputs):
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


def _numbers(c: Compared, fitted: FittedExplanation, sigma: Real) -> tuple[dict[str, float], list[float]]:
    """Numbers by name and their sigmas; of a mass or a spring that of the logarithm."""
    candidate, v = fitted.candidate, fitted.v
    assert candidate is not None
    kind = kind_of(candidate.effect)
    number = (kind.at_points or kind.parameters[0]).name
    if candidate.freedoms:
        return {number: float(np.exp(v[0]))}, [float(sigma[0])]
    if candidate.effect == "position_error":
        tangents = c.shapes.tangents(_freedom(c, candidate.channel or 0))
        names = ("dx", "dy", "dz")
        return dict(zip(names, (v[:2] @ tangents).tolist(), strict=True)), np.sqrt(
            sigma[:2] ** 2 @ tangents**2
        ).tolist()
    if candidate.effect in FACTORS:
        gain = next((g for _, g in fitted.change.gains), fitted.change.force_gain)
        return {number: gain}, [abs(gain) * float(sigma[0])]
    return {number: float(v[0])}, [float(sigma[0])]


def _place(c: Compared, fitted: FittedExplanation) -> PlaceOnStructure:
    candidate, v = fitted.candidate, fitted.v
    assert candidate is not None
    if candidate.effect in EVERY:
        return EveryOutput()
    if not candidate.freedoms:
        of_force = candidate.channel is None
        return NamedChannel(channel=c.rig.force_channel.name if of_force else c.model.outputs[candidate.channel or 0])
    freedom, last = candidate.freedoms[0], candidate.freedoms[-1]
    if two_points(candidate.freedoms):
        middle = (c.shapes.at_m[c.shapes.index(freedom)] + c.shapes.at_m[c.shapes.index(last)]) / 2
        return BetweenPoints(points=(freedom[0], last[0]), at_m=tuple(middle.tolist()), axis=freedom[1])
    at = c.shapes.at_m[c.shapes.index(freedom)] + candidate.offset(v) @ c.shapes.tangents(freedom)
    nearest = int(np.argmin(np.linalg.norm(c.shapes.at_m - at, axis=1)))
    axis = None if candidate.effect == "added_mass" else freedom[1]
    return NearPoint(point=c.shapes.freedoms[nearest][0], at_m=tuple(at.tolist()), axis=axis)


def _freedom(c: Compared, output: int) -> Freedom:
    axes = {channel.name: channel.direction[1] for channel in c.rig.channels}
    return (c.model.output_points[output] or 0, axes[c.model.outputs[output]])
