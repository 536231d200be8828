"""What the comparison of a structure with its modal model says, as a document."""

from typing import Literal

from pydantic import Field

from modallab.core.diagnosis import CandidateSet, Verdict
from modallab.core.effect import PlaceOnStructure
from modallab.core.effects import Stage
from modallab.core.frozen import Frozen
from modallab.core.versions import MODAL_DIAGNOSIS


class FoundChange(Frozen):
    """A change judged present.

    Attributes:
        effect: name in the catalogue.
        stage: stage of the effect.
        probability: of all explanations that were fitted.
        parameters: SI; of a sensor's place dx, dy and dz in m.
        interval: parameter -> (low, high) of 95 %.
        place: on the structure, or the channel's name.
    """

    effect: str
    stage: Stage
    probability: float
    parameters: dict[str, float]
    interval: dict[str, tuple[float, float]]
    place: PlaceOnStructure


class PartOfGap(Frozen):
    """What one channel, or the lines about one mode, contribute: shares of the response, as of the whole.

    Attributes:
        name: of the channel; of a mode its number among the bench's, from 1.
        frequency_hz: of a mode; None of a channel.
        nominal: share by which the modal model as it came misses it.
        before: with the tolerances fitted.
        after: with the change judged present; as before where none is.
    """

    name: str
    frequency_hz: float | None = None
    nominal: float
    before: float
    after: float


class ModalDiagnosis(Frozen):
    """Where a structure as it is differs from its modal model, beyond the tolerances of the rig.

    Attributes:
        rig: its name.
        verdict: whether there is a gap, and whether it is explained.
        nominal: share of the response by which the modal model as it came misses it: rms over the FRFs of both, on
            lines off the frequency axis.
        before: the same with the tolerances fitted.
        after: the same with the change judged present; as before where none is.
        strain_before: root of misfit and priors together over the count of tolerances. About 1 is what tolerances do;
            more says that they had to be bent.
        strain_after: the same with the change.
        effects: the change that causes it.
        candidates: all explanations, the most probable first; `gap` is the share that each leaves.
        nothing: probability that nothing was changed; None in older files.
        unknown: probability that something without a name is the cause; None in older files.
        modes: numbers of modes of the reference and of the bench.
        by_channel: the gap of each output that both models have; [] in older files.
        by_mode: the gap on the lines nearest to each mode of the bench; [] in older files.
        notes: notes on the records and the fit.
    """

    format_version: Literal[1] = MODAL_DIAGNOSIS
    rig: str
    verdict: Verdict
    nominal: float
    before: float
    after: float
    strain_before: float
    strain_after: float
    effects: list[FoundChange]
    candidates: list[CandidateSet]
    nothing: float | None = None
    unknown: float | None = None
    modes: tuple[int, int]
    by_channel: list[PartOfGap] = Field(default_factory=list)
    by_mode: list[PartOfGap] = Field(default_factory=list)
    notes: list[str]

    def explanations(self, together: float = 0.95) -> dict[str, float]:
        """The most probable ones until they have this probability together: effects, "no_gap" and "unknown"."""
        each = {"no_gap": self.nothing or 0.0, "unknown": self.unknown or 0.0}
        each |= {candidate.effects[0]: candidate.probability for candidate in self.candidates}
        found: dict[str, float] = {}
        for name in sorted(each, key=lambda name: -each[name]):
            if sum(found.values()) < together:
                found[name] = each[name]
        return found
