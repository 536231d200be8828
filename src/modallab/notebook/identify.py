"""The modal model of recordings or FRFs."""

from collections.abc import Sequence
from pathlib import Path

from modallab.core.block import Campaign
from modallab.core.errors import DataError, IdentificationError
from modallab.core.units import FrfEstimator, Test
from modallab.identification.estimator import USUAL
from modallab.identification.options import USUAL_RESPONSE, IdentificationOptions, ResponseMethod
from modallab.notebook.arguments import band_of, frequencies_of
from modallab.notebook.measured_frf import MeasuredFrf, phase_rises
from modallab.notebook.model import Model
from modallab.notebook.recording import Recording
from modallab.pipelines.response_only import identify_chosen
from modallab.pipelines.response_setups import identify_response_setups
from modallab.pipelines.setups import identify_setups
from modallab.reporting.waiting_line import waiting_line


def identify(
    measured: Recording | MeasuredFrf | list[Recording] | tuple[Recording, ...],
    test: Test | None = None,
    *,
    band: tuple[float, float] | None = None,
    method: str = USUAL,
    pick: tuple[float, ...] = (),
    drop: tuple[float, ...] = (),
    refine: bool | None = None,
    frf: FrfEstimator = "H1",
    response_only: bool | None = None,
    response_method: ResponseMethod = USUAL_RESPONSE,
    progress: bool = True,
) -> Model:
    """The modal model of recordings or FRFs.

    Args:
        measured: what `simulate`, `load`, `frf` or `responses` gave; several recordings are set-ups of one test, and
            are joined.
        test: only this test; None for all there are.
        band: in Hz; None for all that the data hold.
        method: name of the estimator.
        pick: frequencies in Hz of the modes to keep, by hand; the others are left out.
        drop: frequencies in Hz of modes to leave out.
        refine: whether a maximum-likelihood search follows; None for what is usual with the method.
        frf: how FRFs are made of blocks. H2 takes the force for noisy and the responses for exact. Hv stands between
            it and H1. For random drives, chirps, and several hits at each point.
        response_only: whether the force is left out, and taken for random; None for where none was measured. Shapes
            then have no scale: `modal.operating_shapes`, 1 at the largest.
        response_method: how modes of the responses alone are found.
        progress: show how far it is, where somebody looks.

    Raises:
        DataError: there is nothing to identify.
        IdentificationError: no mode stands out, or a parameter that cannot be.
    """
    options = IdentificationOptions(
        method=method,
        band_hz=band_of(band),
        pick_hz=frequencies_of(pick, "pick"),
        drop_hz=frequencies_of(drop, "drop"),
        refine=refine,
        frf=frf,
    )
    if isinstance(measured, list | tuple):
        with waiting_line("identifying", progress=progress):
            return _join_setups(measured, options, test, response_only, response_method)
    campaign = campaign_in(measured)
    try:
        with waiting_line("identifying", progress=progress):
            result = identify_chosen(campaign, options, test, response_only=response_only, method=response_method)
            return Model(campaign, result)
    except IdentificationError as error:
        if any(phase_rises(frf) for frf in campaign.frfs):
            raise IdentificationError(
                f"{error.what}; and the phase of H rises through its peaks, which is wrong for exp(+i omega t)",
                remedy="give H.conj()",
            ) from error
        raise


def _join_setups(
    measured: Sequence[Recording],
    options: IdentificationOptions,
    test: Test | None,
    response_only: bool | None,
    method: ResponseMethod,
) -> Model:
    campaigns = [campaign_in(one) for one in measured]
    alone = all(c.rig.force is None for c in campaigns) if response_only is None else response_only
    if alone:
        merged = identify_response_setups(campaigns, options, test, method)
        return Model(merged.campaign, merged.result)
    joined = identify_setups(campaigns, options)
    return Model(joined.campaign, joined.result)


def campaign_in(measured: object) -> Campaign:
    """The campaign of what `simulate`, `load` or `frf` gave.

    Raises:
        DataError: it is neither.
    """
    if isinstance(measured, Recording | MeasuredFrf):
        return measured.campaign
    if isinstance(measured, Campaign):
        return measured
    hint = f"ml.load({str(measured)!r})" if isinstance(measured, str | Path) else "ml.frf(f, H) for arrays"
    raise DataError(f"{type(measured).__name__} is no recording", remedy=f"give what ml.load gives: {hint}")
