"""A campaign and its models as the content of a report."""

import json
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modallab import __version__
from modallab.core.block import Block, Campaign
from modallab.core.frf import Frf
from modallab.core.rig import Rig
from modallab.core.units import Test
from modallab.frf.estimate import convert_frf, group_by_point, impact_frf
from modallab.identification.setups.readings import SetUpReading
from modallab.pipelines.curves import diagram_of
from modallab.pipelines.identify import CampaignResult, IdentifiedTest, UnidentifiedTest, usable_blocks
from modallab.reporting.content import OutcomeOfTest, ReportContent, ReportedHit, TrueModes
from modallab.reporting.figures.mode_shapes import example_block
from modallab.signals.signals import Signals, to_signals
from modallab.signals.transform import bandpass, remove_mean

PAPER_BAND = (3.0, 110.0)
"""The paper's band-pass: its three lowest bending modes."""


def report_content(
    campaign: Campaign,
    result: CampaignResult,
    title: str,
    rejected: Sequence[tuple[Block, str]] = (),
    setups: Sequence[SetUpReading] = (),
) -> ReportContent:
    """Everything the report says of a campaign.

    Args:
        campaign: blocks and rig.
        result: models of the tests.
        title: heading.
        rejected: hits that were not accepted, each with its reason.
        setups: what each set-up read, where the model joins several.
    """
    return ReportContent(
        title=title,
        campaign=campaign,
        outcomes=(
            *(_outcome_of_test(campaign, item, rejected) for item in result.identified),
            *(_outcome_without_model(item) for item in result.unidentified),
        ),
        truth=modes_as_built(campaign),
        provenance={"modallab": __version__},
        setups=tuple(setups),
    )


def modes_as_built(campaign: Campaign) -> TrueModes | None:
    """The modes a simulated bench says it was built with, if it was one."""
    frequency = campaign.provenance.get("bench.frequency_hz")
    damping = campaign.provenance.get("bench.damping_ratio")
    if frequency is None or damping is None:
        return None
    source = f"the simulated bench {campaign.provenance.get('bench', 'the bench')}"
    drift = float(campaign.provenance.get("bench.stiffness_drift", 0.0))
    hung_hz, hung_zeta = (campaign.provenance.get(f"bench.sine_{name}") for name in ("frequency_hz", "damping_ratio"))
    sine = None
    if hung_hz is not None and hung_zeta is not None:
        sine = TrueModes(np.array(json.loads(hung_hz)), np.array(json.loads(hung_zeta)), source, None, drift)
    return TrueModes(np.array(json.loads(frequency)), np.array(json.loads(damping)), source, sine, drift)


def _outcome_of_test(campaign: Campaign, item: IdentifiedTest, rejected: Sequence[tuple[Block, str]]) -> OutcomeOfTest:
    if item.source == "frf":
        return OutcomeOfTest(
            test=None,
            model=item.model,
            verification=item.verification,
            assessment=item.assessment,
            diagram=diagram_of(campaign, item, _frf_of_model(campaign, item)),
        )
    test: Test = item.source
    if item.model.operating_shapes is not None:
        return OutcomeOfTest(test=test, model=item.model, diagram="its modes were found in the responses alone")
    block = example_block(campaign, test)
    example = None if block is None else to_signals(block, campaign.rig)
    return OutcomeOfTest(
        test=test,
        model=item.model,
        frf=_measured_signals(campaign, item),
        verification=item.verification,
        example=example,
        filtered=None if example is None else _band_filtered(example),
        hits=_hits_for_report(campaign, rejected) if test == "impact" else (),
        assessment=item.assessment,
        diagram=diagram_of(campaign, item),
    )


def _frf_of_model(campaign: Campaign, item: IdentifiedTest) -> Frf:
    """The FRF that the model was made from, at the lines of its band."""
    frf = campaign.frfs[item.index]
    inside = (frf.frequency_hz >= item.model.band_hz[0]) & (frf.frequency_hz <= item.model.band_hz[1])
    return replace(
        frf, frequency_hz=frf.frequency_hz[inside], values=frf.values[..., inside], coherence=None, variance=None
    )


def _outcome_without_model(item: UnidentifiedTest) -> OutcomeOfTest:
    return OutcomeOfTest(test=None if item.source == "frf" else item.source, missing=str(item.error))


def _band_filtered(signals: Signals) -> NDArray[np.float64] | None:
    if PAPER_BAND[1] >= signals.rate_hz / 2 or signals.n_samples < PAPER_BAND[0] * 100:
        return None
    return bandpass(remove_mean(signals.responses), signals.rate_hz, PAPER_BAND)


def _measured_signals(campaign: Campaign, item: IdentifiedTest) -> Frf | None:
    if item.source != "impact":
        return None if item.verification is None else item.verification.measured
    signals, rig, _ = usable_blocks(campaign, campaign.of("impact"))
    groups = group_by_point(signals)
    return convert_frf(impact_frf(groups, rig, item.model.band_hz), "mobility")


def _hits_for_report(campaign: Campaign, rejected: Sequence[tuple[Block, str]]) -> tuple[ReportedHit, ...]:
    good = [_hit_for_report(block, campaign.rig, "") for block in campaign.of("impact")]
    return (*good, *(_hit_for_report(block, campaign.rig, reason) for block, reason in rejected))


def _hit_for_report(block: Block, rig: Rig, reason: str) -> ReportedHit:
    force = to_signals(block, rig).force
    return ReportedHit(block.name, block.drive_point, force, block.rate_hz, accepted=not reason, reason=reason)
