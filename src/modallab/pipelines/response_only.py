"""Identifies the responses of a campaign alone, whatever drove them."""

import numpy as np
from numpy.typing import NDArray

from modallab.core.array_checks import check_signals
from modallab.core.block import Campaign
from modallab.core.errors import DataError
from modallab.core.model import ModalModel
from modallab.core.units import Test
from modallab.frf.joined import contiguous
from modallab.identification.response_only.covariances import TooShortError
from modallab.identification.response_only.modes import ResponseModes, response_modes
from modallab.pipelines.identify import Identified, Result
from modallab.signals.full_scale import overloaded
from modallab.signals.signals import to_signals_of

METHOD = "ssi_cov"
LEAST_PERIODS = 100.0
"""The lower edge of the band by itself: so many periods of it fit into the records."""
TOP = 0.4
"""Of the rate, the upper edge by itself: up to there the chain's anti-alias filters are flat."""
NO_FORCE = "From the responses alone: a force that excites all modes alike is assumed, and modal masses are not known."


def identify_responses(
    campaign: Campaign, test: Test | None = None, band_hz: tuple[float, float] | None = None
) -> Result:
    """The modal model of one test's responses, by covariance-driven subspace identification.

    Args:
        campaign: records of one test, or of the one that is named. Those that follow each other without a gap are one.
        test: which; None if there is only one.
        band_hz: where modes are looked for; None for 100 periods of the records up to 0.4 of their rate.

    Raises:
        DataError: no records, records of several tests, too short or damaged ones.
        IdentificationError: no mode.
    """
    blocks = campaign.blocks if test is None else campaign.of(test)
    tests = sorted({b.test for b in blocks})
    if len(tests) != 1:
        raise DataError(
            f"there are records of {', '.join(tests) or 'no'} tests",
            where=campaign.source,
            remedy="name the one whose responses are to be identified with --test",
        )
    for block in blocks:
        check_signals(block.samples, block.channels, f"{campaign.source}, record {block.name}")
    clean = [b for b in blocks if not overloaded(b, campaign.rig)]
    if not clean:
        raise DataError(
            f"all {len(blocks)} records run into the converter's full scale",
            where=campaign.source,
            remedy="lower the preamplifiers' gain and record again",
        )
    signals = to_signals_of(clean, campaign.rig)
    rate = signals[0].rate_hz
    records = [np.concatenate([s.responses for s in run], axis=1) for run in contiguous(signals)]
    seconds = sum(r.shape[1] for r in records) / rate
    band, found = _found(records, rate, band_hz, seconds)
    left = len(blocks) - len(clean)
    notes = (NO_FORCE, *((f"{left} records ran into the converter's full scale and were left out.",) if left else ()))
    return Result((Identified(blocks[0].test, _model(found, campaign, blocks[0].test, band, notes), None),), ())


def _found(
    records: list[NDArray[np.float64]], rate_hz: float, band_hz: tuple[float, float] | None, seconds: float
) -> tuple[tuple[float, float], ResponseModes]:
    """The band and its modes; by itself the band begins as low as the records are long enough for."""
    if band_hz is not None:
        return band_hz, response_modes(records, rate_hz, band_hz)
    low, top = LEAST_PERIODS / seconds, TOP * rate_hz
    while True:
        try:
            return (low, top), response_modes(records, rate_hz, (low, top))
        except TooShortError:
            if 2 * low >= top / 4:
                raise
            low *= 2


def _model(
    found: ResponseModes, campaign: Campaign, test: Test, band_hz: tuple[float, float], notes: tuple[str, ...]
) -> ModalModel:
    n, outputs = found.frequency_hz.size, campaign.rig.responses
    nothing = np.zeros((n, len(outputs), 0))
    unread = np.full(n, np.nan)
    return ModalModel(
        method=METHOD,
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
