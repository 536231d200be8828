"""What an identification is looked at by: measured and regenerated mobility, and the stabilisation diagram."""

import numpy as np
from numpy.typing import NDArray

from modallab.core.block import Campaign
from modallab.core.documents.models import CurvesView, DiagramView, TestCurves
from modallab.core.errors import ModallabError
from modallab.core.frf import Frf
from modallab.core.units import BROADBAND
from modallab.frf.broadband import blocks_of_one_level, broadband_frf
from modallab.frf.estimate import group_by_point
from modallab.identification.estimate import estimate_poles
from modallab.identification.estimator import USUAL, find_estimator
from modallab.identification.impact import start_frf
from modallab.identification.selection.diagram import StabilisationData, stabilisation_diagram
from modallab.identification.sine import START, highest_order, stepped_start
from modallab.identification.start.stabilisation import StabilityLimits
from modallab.modification.deflection import deviation_of_frf
from modallab.pipelines.identify import CampaignResult, IdentifiedTest, usable_blocks

DIGITS = 6
"""Significant ones: these are to be drawn."""


def curves_of(campaign: Campaign, result: CampaignResult) -> CurvesView:
    """The curves of every test that has a model, in the order of the models."""
    return CurvesView(tests=tuple(_curves_of_item(campaign, item) for item in result.identified))


def _curves_of_item(campaign: Campaign, item: IdentifiedTest) -> TestCurves:
    model, verification = item.model, item.verification
    diagram = diagram_of(campaign, item)
    drawn = None if isinstance(diagram, str) else diagram
    return TestCurves(
        test=model.test,
        outputs=model.outputs,
        output_points=model.output_points,
        input_points=model.input_points,
        frequency_hz=np.zeros(0) if verification is None else verification.measured.frequency_hz,
        measured=None if verification is None else _complex_as_lists(verification.measured.values),
        sigma=None if verification is None else _rounded_values(deviation_of_frf(verification.measured)),
        regenerated=None if verification is None else _complex_as_lists(verification.regenerated.values),
        diagram=None
        if drawn is None
        else DiagramView(
            order=drawn.order.astype(float),
            frequency_hz=_rounded_values(drawn.frequency_hz),
            damping_ratio=_rounded_values(drawn.damping_ratio),
            standing=drawn.standing.astype(float),
            held_hz=_rounded_values(drawn.held_hz),
            line_hz=_rounded_values(drawn.line_hz),
            cmif=_rounded_values(drawn.cmif),
        ),
        without_diagram=diagram if isinstance(diagram, str) else "",
    )


def _complex_as_lists(values: NDArray[np.complex128]) -> NDArray[np.complex128]:
    return _rounded_values(values.real) + 1j * _rounded_values(values.imag)


def _rounded_values(values: NDArray[np.float64]) -> NDArray[np.float64]:
    flat = [float(f"{value:.{DIGITS}g}") for value in values.ravel().tolist()]
    return np.array(flat, dtype=np.float64).reshape(values.shape)


def diagram_of(campaign: Campaign, item: IdentifiedTest, frf: Frf | None = None) -> StabilisationData | str:
    """The diagram, or why there is none.

    Args:
        campaign: the recordings.
        item: a test's model; one of an estimator without orders is drawn beside the poles of the usual one.
        frf: the FRF, if it came as such.
    """
    try:
        seen, order, tolerance = _diagram_of_item(campaign, item, frf)
        # What has no orders is drawn beside the poles of one that has.
        method = item.model.method if find_estimator(item.model.method).order is not None else USUAL
        return stabilisation_diagram(seen, estimate_poles(seen, method, order, tolerance).orders, tolerance)
    except ModallabError as error:
        return error.what


def _diagram_of_item(
    campaign: Campaign, item: IdentifiedTest, frf: Frf | None
) -> tuple[Frf, int | None, StabilityLimits | None]:
    if frf is not None:
        return frf, None, None
    if item.source == "impact":
        signals, rig, _ = usable_blocks(campaign, campaign.of("impact"))
        return start_frf(group_by_point(signals), rig, item.model.band_hz), None, None
    if item.source in BROADBAND:
        signals, rig, _ = usable_blocks(campaign, campaign.of(item.source))
        return broadband_frf(blocks_of_one_level(signals), rig, item.model.band_hz), None, None
    signals, rig, _ = usable_blocks(campaign, campaign.of("sine"))
    seen = stepped_start(signals, rig, item.model.band_hz)
    return seen, highest_order(seen), START
