"""What a diagnosis says, as a document."""

from collections.abc import Mapping
from typing import ClassVar, Literal

from pydantic import Field

from modallab.core.budget import Budget
from modallab.core.effect import AlternativeDescription, LearnedElement, Place, place_relative_to_length
from modallab.core.effects import Effect, Stage
from modallab.core.frozen import Frozen
from modallab.core.versions import DIAGNOSIS

Verdict = Literal["no_gap", "known", "unknown"]


class ResponseShare(Frozen):
    """Measured less predicted over the response, as a share: median over records, after subtraction of the noise.

    Attributes:
        at_resonance: share on the lines about the modes; None if no record covers them.
        away: share on the other lines.
    """

    at_resonance: float | None
    away: float | None


class Discrepancy(Frozen):
    """Error of the model: the unexplained part of a record beyond its noise, over its response.

    Attributes:
        median: median over the records.
        worst: largest value of all records.
        record: name of that record.
    """

    median: float
    worst: float
    record: str


class Gap(Frozen):
    """The gap in noise units; 1 is the floor.

    Attributes:
        before: rms of (measured - predicted) / noise of the twin without effects, with fitted tolerances.
        floor: gap that noise alone leaves.
        after: the same with the effects judged present.
        by_record: record -> rms.
        by_test: test -> rms.
        by_level: level of the sine test -> rms.
        by_channel: channel -> rms.
        after_by_channel: the same with the effects judged present.
        by_band: band in Hz -> share of the squares.
        by_mode: mode -> share of the squares nearest to it.
        by_order: third of the campaign's time -> rms.
        poles_hz: frequencies of the ring-down, identified without a model.
        share_nominal: share of the response, for the twin of the rig file.
        share_before: the same without effects, with fitted tolerances.
        share_after: the same with the effects judged present.
        discrepancy: unexplained rest; None if no record exceeds its noise.
    """

    before: float
    floor: float
    after: float
    by_record: dict[str, float]
    by_test: dict[str, float]
    by_level: dict[str, float]
    by_channel: dict[str, float]
    after_by_channel: dict[str, float]
    by_band: dict[str, float]
    by_mode: dict[str, float]
    by_order: dict[str, float]
    poles_hz: list[float]
    share_nominal: ResponseShare | None = None
    share_before: ResponseShare | None = None
    share_after: ResponseShare | None = None
    discrepancy: Discrepancy | None = None


class GapLocation(Frozen):
    """Location of the gap.

    Attributes:
        stage: stage of the measurement chain; None without a gap. It follows from the explanation, or from tests on
            the residual if there is none.
        tested_stage: stage indicated by tests on the residual before any fit of effects; None if the records show the
            cause without a model.
        channels: channels concerned: force, a01, ...; empty if none.
        x_m: distance from the clamp; None if there is none or none was found.
        tests: tests that show it.
        bands: (low, high) in Hz of the bands with most of the gap.
        share: share of the squares above the floor in these tests, channels and bands.
        why: deciding tests on the residual, in words.
    """

    stage: Stage | None
    tested_stage: Stage | None = None
    channels: list[str]
    x_m: float | None
    tests: list[str]
    bands: list[tuple[float, float]]
    share: float
    why: list[str]


class FoundEffect(Frozen):
    """An effect that was judged present.

    Attributes:
        effect: name in the catalogue.
        stage: stage of the effect.
        probability: calibrated probability of this effect.
        parameters: parameters in SI units.
        interval: parameter -> (low, high) of the 95 % interval; None if the records leave the number open.
        not_known: parameter -> reason for a missing interval.
        place: as in the catalogue; x is a share of the length, x_m metres.
    """

    effect: str
    stage: Stage
    probability: float
    parameters: dict[str, float]
    interval: dict[str, tuple[float, float] | None]
    not_known: dict[str, str] = Field(default_factory=dict[str, str])
    place: Place

    def as_effect(self) -> Effect:
        """The effect for the twin."""
        return Effect(effect=self.effect, parameters=self.parameters, place=place_relative_to_length(self.place))


class Shrinkage(Frozen):
    """Shrinkage of the gap on held-out records.

    Attributes:
        held_out: names of those records.
        before: gap there without effects.
        after: gap there with effects.
        closed: 1 - (after^2 - 1) / (before^2 - 1).
        interval: 95 % interval of `closed`, by bootstrap over records.
        rival: name and `closed` of the best explanation with another name.
    """

    held_out: list[str]
    before: float
    after: float
    closed: float | None
    interval: tuple[float, float] | None
    rival: dict[str, float]


class ToleranceDeviation(Frozen):
    """Deviation of a parameter of the twin within its tolerance.

    Attributes:
        tolerance: name of the tolerance in the rig file.
        at: channel, place in m, or term of a field, where there are several.
        sigma: one deviation, in the tolerance's unit.
        sign: 1 or -1 if only one sign is possible, otherwise 0.
        u: fitted value, in standard deviations of its prior.
    """

    tolerance: str
    at: float
    sigma: float
    sign: int
    u: float


class TwinParameters(Frozen):
    """The fitted parameters of the twin.

    Attributes:
        youngs_modulus_pa: E.
        thickness_m: thickness.
        density_kg_m3: density.
        zeta: damping ratio of each mode.
        gains: channel number -> factor, where sensitivities were free.
        residual_compliance: static compliance of the modes above the twin's own, as a share of its nominal value.
        root_rotation: compliance of the root in L / EI, where the rig file states one; 0 is rigid.
        departures: deviations of the assembly from the rig file that no effect replaces.
        drift_curve: (time as a share of the campaign's, share of a drift) where a drift was found.
    """

    renamed: ClassVar[Mapping[str, str]] = {"rest": "residual_compliance"}

    youngs_modulus_pa: float
    thickness_m: float
    density_kg_m3: float
    zeta: list[float]
    gains: dict[int, float] = Field(default_factory=dict[int, float])
    residual_compliance: float = 0.0
    root_rotation: float = 0.0
    departures: list[ToleranceDeviation] = Field(default_factory=list[ToleranceDeviation])
    drift_curve: list[tuple[float, float]] = Field(default_factory=list[tuple[float, float]])


class CandidateSet(Frozen):
    """An explanation with its probability, and the gap that it leaves.

    Attributes:
        effects: names of its effects.
        probability: 0 to 1.
        gap: gap that it leaves, in noise units.
        fitted: its fitted effects with their numbers; empty in older documents.
        twin: parameters of the twin fitted with them; None in older documents.
    """

    effects: list[str]
    probability: float
    gap: float
    fitted: list[Effect] = Field(default_factory=list[Effect])
    twin: TwinParameters | None = None


class GapDescription(Frozen):
    """Description of a gap that no effect of the catalogue explains. Never a cause.

    Attributes:
        says: description in words, with its numbers.
        stage: stage in which the description acts; tests on the residual may indicate another.
        elements: elements of the twin that describe the gap.
        x_m: distance from the clamp; None without a place.
        x_m_interval: 95 % interval of that distance.
        channels: channels concerned; empty if none.
        shrink: shrinkage of the gap on held-out records.
        twin: parameters of the twin fitted with these elements.
        alternatives: other descriptions that leave nearly the same gap.
    """

    says: str
    stage: Stage
    elements: list[LearnedElement]
    x_m: float | None
    x_m_interval: tuple[float, float] | None
    channels: list[str]
    shrink: Shrinkage
    twin: TwinParameters
    alternatives: list[AlternativeDescription]


class Diagnosis(Frozen):
    """Location and cause of the gap, and its shrinkage once the cause is in the twin.

    Attributes:
        rig: its name.
        verdict: whether there is a gap, and whether it is explained.
        gap: size of the gap.
        where: location of the gap in the measurement chain.
        effects: effects that cause the gap, the most probable first.
        candidates: other explanations, with their probabilities.
        shrink: shrinkage of the gap on held-out records.
        next_experiment: suggested next measurement, in a sentence.
        twin: fitted parameters of the simulation.
        notes: notes on the records and the fit.
        budget: contributions of the fitted parameters and effects to the gap; None in older documents.
        described: description of an unnamed cause; None if a named effect explains the gap, if nothing describes it
            on held-out records, and in older documents.
        unknown: probability of an unnamed cause; None in older documents.
    """

    format_version: Literal[1, 2] = DIAGNOSIS
    rig: str
    verdict: Verdict
    gap: Gap
    where: GapLocation
    effects: list[FoundEffect]
    candidates: list[CandidateSet]
    shrink: Shrinkage
    next_experiment: str
    twin: TwinParameters
    notes: list[str]
    budget: Budget | None = None
    described: GapDescription | None = None
    unknown: float | None = None
