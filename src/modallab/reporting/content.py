"""What a report is made from."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from modallab.core.block import Campaign
from modallab.core.frf import Frf
from modallab.core.model import ModalModel, Verification
from modallab.core.rig import Rig
from modallab.core.units import Test
from modallab.identification.selection.diagram import StabilisationData
from modallab.identification.setups.readings import SetUpReading
from modallab.signals.signals import Signals
from modallab.verification.assessment import ModelAssessment


@dataclass(frozen=True, eq=False, slots=True)
class ReportedHit:
    """One hit of the hammer, counted or rejected.

    Attributes:
        name: name of its record.
        point: where it was meant to land; None if unknown.
        force_n: (n,) force in N.
        rate_hz: sampling rate.
        accepted: whether it counts.
        reason: why it was rejected, else "".
    """

    name: str
    point: int | None
    force_n: NDArray[np.float64]
    rate_hz: float
    accepted: bool = True
    reason: str = ""


@dataclass(frozen=True, eq=False, slots=True)
class TrueModes:
    """The modes a simulated bench was built with.

    Attributes:
        frequency_hz: (modes,) undamped natural frequencies.
        damping_ratio: (modes,) zeta.
        source: who says so, to be read after "the truth is known from".
        sine: the same with what hangs on the beam in the sine test, if that is another.
        drift: relative change of the stiffness over the campaign, at whose beginning the frequencies are these.
    """

    frequency_hz: NDArray[np.float64]
    damping_ratio: NDArray[np.float64]
    source: str = ""
    sine: "TrueModes | None" = None
    drift: float = 0.0

    def of(self, test: Test | None) -> "TrueModes":
        """The modes of a test."""
        return self.sine if test == "sine" and self.sine is not None else self


@dataclass(frozen=True, eq=False, slots=True)
class OutcomeOfTest:
    """What one test gave. What is None leaves its part of the report out, with a sentence why.

    Attributes:
        test: impact or sine; None for FRFs of unknown origin.
        model: the identified model; None if identification failed, then `missing` says why.
        frf: as measured, with coherence.
        verification: measured against regenerated mobility.
        example: one block in SI units, to be drawn; see `modallab.reporting.figures.mode_shapes.example_block`.
        filtered: (outputs, n) the responses of `example` after the band-pass filter.
        hits: every hit, the rejected ones too.
        missing: why there is no model.
        assessment: the test's assumptions, and how well each mode stands.
        diagram: what the identification began with, or why it can't be drawn.
    """

    test: Test | None
    model: ModalModel | None = None
    frf: Frf | None = None
    verification: Verification | None = None
    example: Signals | None = None
    filtered: NDArray[np.float64] | None = None
    hits: tuple[ReportedHit, ...] = ()
    missing: str = ""
    assessment: ModelAssessment | None = None
    diagram: StabilisationData | str | None = None


@dataclass(frozen=True, eq=False, slots=True)
class ReportContent:
    """Everything a report says.

    Attributes:
        title: heading of the page.
        campaign: the recordings, with the rig they were made on.
        outcomes: one a test.
        truth: the modes that were built into a simulated bench; None on a real one.
        notes: plain sentences for the reader.
        provenance: what it takes to repeat this (code version, seeds, rig hash, time), as text. The rates of the
            blocks and what the campaign says of itself are added to it.
        setups: what each set-up read, where the model joins several.
    """

    title: str
    campaign: Campaign
    outcomes: tuple[OutcomeOfTest, ...] = ()
    truth: TrueModes | None = None
    notes: tuple[str, ...] = ()
    provenance: dict[str, str] = field(default_factory=dict[str, str])
    setups: tuple[SetUpReading, ...] = ()

    @property
    def rig(self) -> Rig:
        """Description of the bench."""
        return self.campaign.rig

    @property
    def models(self) -> tuple[ModalModel, ...]:
        """The models there are, in the order of the tests."""
        return tuple(o.model for o in self.outcomes if o.model is not None)

    @property
    def confidence(self) -> tuple[NDArray[np.float64] | None, ...]:
        """How clearly each mode stands, model by model."""
        with_model = [o for o in self.outcomes if o.model is not None]
        return tuple(None if o.assessment is None else o.assessment.confidence for o in with_model)
