"""What an identification is looked at by: measured and regenerated mobility, and the stabilisation diagram."""

import numpy as np
from numpy.typing import NDArray

from modallab.core.block import Campaign
from modallab.core.documents.models import CurvesView, DiagramView, TestCurves
from modallab.pipelines.diagram import diagram_of
from modallab.pipelines.identify import Identified, Result

DIGITS = 6
"""Significant ones: these are to be drawn."""


def curves_of(campaign: Campaign, result: Result) -> CurvesView:
    """The curves of every test that has a model, in the order of the models."""
    return CurvesView(tests=tuple(_curves(campaign, item) for item in result.identified))


def _curves(campaign: Campaign, item: Identified) -> TestCurves:
    model, verification = item.model, item.verification
    diagram = diagram_of(campaign, item)
    drawn = None if isinstance(diagram, str) else diagram
    return TestCurves(
        test=model.test,
        outputs=model.outputs,
        output_points=model.output_points,
        input_points=model.input_points,
        frequency_hz=np.zeros(0) if verification is None else verification.measured.frequency_hz,
        measured=None if verification is None else _complex(verification.measured.values),
        regenerated=None if verification is None else _complex(verification.regenerated.values),
        diagram=None
        if drawn is None
        else DiagramView(
            order=drawn.order.astype(float),
            frequency_hz=_short(drawn.frequency_hz),
            damping_ratio=_short(drawn.damping_ratio),
            standing=drawn.standing.astype(float),
            held_hz=_short(drawn.held_hz),
            line_hz=_short(drawn.line_hz),
            cmif=_short(drawn.cmif),
        ),
        without_diagram=diagram if isinstance(diagram, str) else "",
    )


def _complex(values: NDArray[np.complex128]) -> NDArray[np.complex128]:
    return _short(values.real) + 1j * _short(values.imag)


def _short(values: NDArray[np.float64]) -> NDArray[np.float64]:
    flat = [float(f"{value:.{DIGITS}g}") for value in values.ravel().tolist()]
    return np.array(flat, dtype=np.float64).reshape(values.shape)
