"""The modal model of recordings or FRFs."""

from collections.abc import Sequence
from pathlib import Path

from modallab.core.block import Campaign
from modallab.core.errors import DataError, IdentificationError
from modallab.core.units import FrfEstimator, Test
from modallab.identification.estimator import USUAL
from modallab.identification.options import USUAL_RESPONSE, IdentificationOptions, ResponseMethod
from modallab.notebook.arguments import band_of, frequencies_of
from modallab.notebook.measured_frf import MeasuredFrf, phase_increases
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
        measured: result of `simulate`, `load`, `frf` or `responses`; several recordings are set-ups of one test,
            and are joined.
        test: test to identify; None for all.
        band: (low, high) in Hz; None for the whole band of the data.
        method: name of the estimator.
        pick: frequencies in Hz of the modes to keep; others are left out.
        drop: frequencies in Hz of modes to leave out.
        refine: whether a maximum-likelihood search follows; None for the default of the method.
        frf: FRF estimator for random drives, chirps, and several hits at each point. H1 assumes noise on the
            responses, H2 on the force, Hv on both.
        response_only: whether to ignore the force and assume a random one; None: only if no force was measured.
            Shapes then have no scale: `modal.operating_shapes`, 1 at the largest.
        response_method: estimator for the responses alone.
        progress: show the progress, in a notebook or terminal.

    Raises:
        DataError: there are no records.
        IdentificationError: no mode was found, or a parameter is impossible.
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
        if any(phase_increases(frf) for frf in campaign.frfs):
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
    """The campaign of result of `simulate`, `load` or `frf`.

    Raises:
        DataError: it is neither.
    """
    if isinstance(measured, Recording | MeasuredFrf):
        return measured.campaign
    if isinstance(measured, Campaign):
        return measured
    hint = f"ml.load({str(measured)!r})" if isinstance(measured, str | Path) else "ml.frf(f, H) for arrays"
    raise DataError(f"{type(measured).__name__} is no recording", remedy=f"give a result of ml.load: {hint}")
