"""What a diagnosis says, as a document."""

from collections.abc import Mapping
from typing import ClassVar, Literal

from pydantic import Field

from modallab.core.budget import Budget
from modallab.core.effect import Alternative, Learned
from modallab.core.effects import Effect, Stage
from modallab.core.frozen import Frozen
from modallab.core.places import Place, place_as_shares
from modallab.core.versions import DIAGNOSIS

Verdict = Literal["no_gap", "known", "unknown"]


class Percent(Frozen):
    """Measured less predicted over the response, as a share: median over records, noise taken off.

    Attributes:
        at_resonance: on the lines about the modes; None where no record lies there.
        away: on the others.
    """

    at_resonance: float | None
    away: float | None


class Discrepancy(Frozen):
    """The model's own error: what no number and no effect explains of a record beyond its noise, over its response.

    Attributes:
        median: over the records.
        worst: of all records.
        record: which that is.
    """

    median: float
    worst: float
    record: str


class Gap(Frozen):
    """The gap in noise units; 1 is the floor.

    Attributes:
        before: rms of (measured - predicted) / noise of the twin without effects, nuisances fitted.
        floor: what noise alone leaves.
        after: the same with the effects judged present.
        by_record: record -> rms.
        by_test: test -> rms.
        by_level: level of the sine test -> rms.
        by_channel: channel -> rms.
        after_by_channel: the same with the effects judged present.
        by_band: band in Hz -> share of the squares.
        by_mode: mode -> share of the squares nearest to it.
        by_order: third of the campaign's time -> rms.
        poles_hz: frequencies of the ring-down, without any model.
        share_nominal: of the response, of the twin as the rig file has it.
        share_before: the same without effects, nuisances fitted.
        share_after: the same with the effects judged present.
        discrepancy: what then is left; None where no record stands out of its noise.
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
    share_nominal: Percent | None = None
    share_before: Percent | None = None
    share_after: Percent | None = None
    discrepancy: Discrepancy | None = None


class Where(Frozen):
    """Where the gap lies.

    Attributes:
        stage: where in the chain; None if there is no gap. That of the models which explain the gap where some do,
            otherwise what the tests on the residual say.
        tested_stage: what the tests on the residual say, before any effect has been fitted and without a name; None if
            the records show it without a model.
        channels: rows concerned: force, a01, ...; empty if it is none of them.
        x_m: place from the clamp; None where it has none or none was found.
        tests: tests that show it.
        bands: (low, high) in Hz that hold most of it.
        share: of the squares above the floor that lie in these tests, channels and bands.
        why: the tests on the residual that decided, in plain words.
    """

    stage: Stage | None
    tested_stage: Stage | None = None
    channels: list[str]
    x_m: float | None
    tests: list[str]
    bands: list[tuple[float, float]]
    share: float
    why: list[str]


class Found(Frozen):
    """An effect judged present.

    Attributes:
        effect: its name in the catalogue.
        stage: its stage.
        probability: calibrated, that it is this one.
        parameters: SI.
        interval: parameter -> (low, high) of 95 %; None where the records leave the number open.
        not_known: parameter -> why it has no interval.
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
        return Effect(effect=self.effect, parameters=self.parameters, place=place_as_shares(self.place))


class Shrink(Frozen):
    """How far the gap shrank on records that were not fitted.

    Attributes:
        held_out: names of those records.
        before: gap there without effects.
        after: gap there with them.
        closed: 1 - (after^2 - 1) / (before^2 - 1).
        interval: 95 % of `closed`, by bootstrap over records.
        rival: `closed` of the best explanation of another name, and its name.
    """

    held_out: list[str]
    before: float
    after: float
    closed: float | None
    interval: tuple[float, float] | None
    rival: dict[str, float]


class Departure(Frozen):
    """A number of the twin within its tolerance.

    Attributes:
        tolerance: its name in the rig file.
        at: channel, place in m, or term of a field, where there are several.
        sigma: one deviation, in the tolerance's unit.
        sign: 1 or -1 where it has one sign only, else 0.
        u: where the fit left it: deviations of its prior.
    """

    tolerance: str
    at: float
    sigma: float
    sign: int
    u: float


class Calibrated(Frozen):
    """The twin's own numbers after the fit.

    Attributes:
        youngs_modulus_pa: E.
        thickness_m: h.
        density_kg_m3: rho.
        zeta: damping ratio of each mode.
        gains: channel number -> factor, where sensitivities were free.
        residual_compliance: static compliance of the modes above the twin's own, as a share of its nominal value.
        root_rotation: compliance of the root in L / EI, where the rig file states one; 0 is rigid.
        departures: of the assembly from what the rig file says, those that no effect stands for.
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
    departures: list[Departure] = Field(default_factory=list[Departure])
    drift_curve: list[tuple[float, float]] = Field(default_factory=list[tuple[float, float]])


class CandidateSet(Frozen):
    """An explanation and its probability; `gap` is what it leaves.

    Attributes:
        effects: names of its effects.
        probability: 0 to 1.
        gap: that it leaves, in noise units.
        fitted: those of its effects that were fitted, with their numbers; empty in older documents.
        twin: the simulation's own numbers beside them; None in older documents.
    """

    effects: list[str]
    probability: float
    gap: float
    fitted: list[Effect] = Field(default_factory=list[Effect])
    twin: Calibrated | None = None


class Described(Frozen):
    """A gap that no effect of the catalogue explains: what it behaves like. Never a cause.

    Attributes:
        says: it in words, with its numbers.
        stage: where what describes it acts; the tests on the residual may say otherwise.
        elements: of the twin that behave so.
        x_m: place from the clamp; None where it has none.
        x_m_interval: 95 % of that place.
        channels: rows concerned; empty if it is none of them.
        shrink: how far it closes the gap on records that no fit has seen.
        twin: the simulation's own numbers beside these elements.
        alternatives: other descriptions that leave about as little.
    """

    says: str
    stage: Stage
    elements: list[Learned]
    x_m: float | None
    x_m_interval: tuple[float, float] | None
    channels: list[str]
    shrink: Shrink
    twin: Calibrated
    alternatives: list[Alternative]


class Diagnosis(Frozen):
    """Where the gap lies, which effect causes it, how far it shrinks once that effect is in the twin.

    Attributes:
        rig: its name.
        verdict: whether there is a gap, and whether it is explained.
        gap: how wide it is.
        where: where in the chain it lies.
        effects: that cause it, the most probable first.
        candidates: other explanations, with their probabilities.
        shrink: how far it shrank on records that were held out.
        next_experiment: what to measure next, in a sentence.
        twin: the simulation as it was calibrated.
        notes: what was found on the way.
        budget: how far the calibration moved, against the tolerances; None in older documents.
        described: what a gap without a name behaves like; None where a name explains it, where nothing describes it
            on records held out, and in older documents.
        unknown: probability that something without a name is the cause; None in older documents.
    """

    format_version: Literal[1, 2] = DIAGNOSIS
    rig: str
    verdict: Verdict
    gap: Gap
    where: Where
    effects: list[Found]
    candidates: list[CandidateSet]
    shrink: Shrink
    next_experiment: str
    twin: Calibrated
    notes: list[str]
    budget: Budget | None = None
    described: Described | None = None
    unknown: float | None = None
