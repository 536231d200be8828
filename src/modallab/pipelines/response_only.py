"""Identifies the responses of a campaign alone, whatever drove them."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import Real
from modallab.core.block import Campaign
from modallab.core.errors import DataError, IdentificationError
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.core.units import Test
from modallab.frf.joined import contiguous_blocks
from modallab.identification.options import USUAL_RESPONSE, IdentificationOptions, ResponseMethod
from modallab.identification.response_only.covariances import TooShortError
from modallab.identification.response_only.looks import PLSCF, SSI_COV, PoleMethod
from modallab.identification.response_only.modes import ResponseModes, response_modes
from modallab.identification.response_only.periodic import lines_in_words
from modallab.pipelines.identify import CampaignResult, IdentifiedTest, identify_campaign
from modallab.pipelines.undamaged_records import undamaged_records
from modallab.signals.signals import to_signals_of
from modallab.verification.assessment import assess_model

POLES: dict[ResponseMethod, PoleMethod] = {"ssi_cov": SSI_COV, "plscf_spectra": PLSCF}
LEAST_PERIODS = 100.0
"""The lower edge of the band by itself: so many periods of it fit into the records."""
TOP = 0.4
"""Of the rate, the upper edge by itself: up to there the chain's anti-alias filters are flat."""
NO_FORCE = (
    "Identified from the responses alone, for a force that excites all modes alike. Shapes are unscaled, and modal "
    "masses "
    "are not known."
)


def identify_chosen(
    campaign: Campaign,
    options: IdentificationOptions,
    test: Test | None = None,
    *,
    response_only: bool | None = None,
    method: ResponseMethod = USUAL_RESPONSE,
) -> CampaignResult:
    """The models by force and responses, or that of the responses alone.

    Args:
        campaign: records or FRFs, and the rig.
        options: of the identification; for the responses alone only its band.
        test: only this test.
        response_only: whether the force is left out; None for where none was measured.
        method: how modes of the responses alone are found.

    Raises:
        IdentificationError: no mode, or options that the responses alone have no place for.
        DataError: nothing to identify, or damaged records.
    """
    alone = campaign.rig.force is None and bool(campaign.blocks) if response_only is None else response_only
    if not alone:
        return identify_campaign(campaign, options, test)
    if replace(options, band_hz=None) != IdentificationOptions():
        raise IdentificationError(
            "of the options of an identification, only the band applies to the responses alone",
            remedy="leave out method, order, refine, the kind of FRF, and picked or dropped modes",
        )
    return identify_responses(campaign, test, options.band_hz, method)


def identify_responses(
    campaign: Campaign,
    test: Test | None = None,
    band_hz: tuple[float, float] | None = None,
    method: ResponseMethod = USUAL_RESPONSE,
) -> CampaignResult:
    """The modal model of one test's responses.

    Args:
        campaign: records of one test, or of the one that is named. Those that follow each other without a gap are one.
        test: which; None if there is only one.
        band_hz: where modes are looked for; None for 100 periods of the records up to 0.4 of their rate.
        method: covariance-driven subspace identification, or pLSCF on half spectra.

    Raises:
        DataError: no records, records of several tests, too short or damaged ones.
        IdentificationError: no mode.
    """
    records, rate, name, rig, left_out = response_records(campaign, test)
    seconds = sum(r.shape[1] for r in records) / rate
    band, found = _find_response_modes(records, rate, band_hz, seconds, method)
    periodic = (lines_in_words(found.harmonics_hz),) if found.harmonics_hz.size else ()
    model = _response_model(found, rig, name, band, (NO_FORCE, *periodic, *left_out), method)
    return CampaignResult((IdentifiedTest(name, model, None, assess_model(model, (), (), found.confidence)),), ())


def response_records(campaign: Campaign, test: Test | None) -> tuple[list[Real], float, Test, Rig, tuple[str, ...]]:
    """Responses (outputs, samples) in SI, each as long as blocks follow each other, their rate, the test, the rig
    with their channels only, and notes.

    Raises:
        DataError: no records, records of several tests, or damaged ones.
    """
    blocks = campaign.blocks if test is None else campaign.of(test)
    tests = sorted({b.test for b in blocks})
    if len(tests) != 1:
        raise DataError(
            f"there are records of {', '.join(tests) or 'no'} tests",
            where=campaign.source,
            remedy="name the test to identify with --test",
        )
    clean, rig, left_out = undamaged_records(campaign, blocks, {channel.name for channel in campaign.rig.forces})
    signals = to_signals_of(clean, rig)
    records = [np.concatenate([s.responses for s in run], axis=1) for run in contiguous_blocks(signals)]
    return records, signals[0].rate_hz, blocks[0].test, rig, left_out


def _find_response_modes(
    records: list[Real],
    rate_hz: float,
    band_hz: tuple[float, float] | None,
    seconds: float,
    method: ResponseMethod,
) -> tuple[tuple[float, float], ResponseModes]:
    """The band and its modes; by itself the band begins as low as the records are long enough for."""
    poles_of = POLES[method]
    if band_hz is not None:
        return band_hz, response_modes(records, rate_hz, band_hz, poles_of)
    low, top = LEAST_PERIODS / seconds, TOP * rate_hz
    while True:
        try:
            return (low, top), response_modes(records, rate_hz, (low, top), poles_of)
        except TooShortError:
            if 2 * low >= top / 4:
                raise
            low *= 2


def _response_model(
    found: ResponseModes,
    rig: Rig,
    test: Test,
    band_hz: tuple[float, float],
    notes: tuple[str, ...],
    method: ResponseMethod,
) -> ModalModel:
    n, outputs = found.frequency_hz.size, rig.responses
    nothing = np.zeros((n, len(outputs), 0))
    unread = np.full(n, np.nan)
    return ModalModel(
        method=method,
        test=test,
        band_hz=band_hz,
        frequency_hz=found.frequency_hz,
        damping_ratio=found.damping_ratio,
        frequency_sigma_hz=found.frequency_sigma_hz,
        damping_sigma=found.damping_sigma,
        outputs=tuple(c.name for c in outputs),
        output_points=tuple(c.point for c in outputs),
        input_points=(),
        modal_constants=nothing.astype(np.complex128),
        modal_constant_sigma=nothing,
        residuals=np.zeros((0, len(outputs), 0)),
        shapes_unavailable="no force was measured, so that shapes have no scale",
        half_power=unread,
        half_power_floor=unread,
        notes=notes,
        operating_shapes=found.shapes,
        operating_shape_sigma=found.shape_sigma,
    )
