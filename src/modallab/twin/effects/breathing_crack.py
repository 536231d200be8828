"""A crack that opens and closes."""

from dataclasses import replace

import numpy as np

from modallab.core.effects import Effect, EffectKind, Parameter, x_of
from modallab.core.rig import Beam, Rig
from modallab.twin.bench import Twin
from modallab.twin.candidate import FreeNumber, along_beam
from modallab.twin.effect_model import EffectModel, EffectSearch, SteppedLaw
from modallab.twin.nonlinear.element import NonlinearElement, NonlinearLaw

WIDTH = 0.045
"""Half width of the loss over L where nothing says more: 0.04 and 0.05 are both in use."""
NARROWEST, WIDEST = 0.025, 0.08
SHARES = tuple(
    float(v) for v in 1 / (1 + np.exp(-np.array([-3.5, -2.7, -2.1, -1.6, -1.2, -0.9, *np.arange(-0.6, 3.01, 0.12)])))
)
"""Worth a first look, so close together that the frequency of the lowest mode moves by few percent between two."""

FORMS = ((("all_modes", 1.0),), (("all_modes", 0.0),))
"""Whether a crack is felt by all modes of the beam, as in a continuum, or by those alone that a bench or model has."""


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    share, length = effect.parameters["EI_loss_open"], twin.structure.length_m
    all_modes = effect.parameters.get("all_modes", 0.0)
    width = effect.parameters.get("width", WIDTH) * length
    return replace(twin, element=NonlinearElement(NonlinearLaw.CRACK, x_of(effect, rig), (share, width, all_modes)))


def _slots(beam: Beam) -> tuple[FreeNumber, ...]:
    return (
        FreeNumber("EI_loss_open", "share", SHARES, high=0.97),
        # How far a crack weakens the beam beside it depends on the crack.
        FreeNumber("width", "log", (WIDTH,), low=NARROWEST, high=WIDEST, power=0.0),
        along_beam(),
    )


MODEL = EffectModel(
    kind=EffectKind(
        "breathing_crack",
        "structure",
        (Parameter("EI_loss_open", "", 1e-4, 0.95, spoken="loss of bending stiffness while open"),),
        "x",
        "a stiffness loss about x while the curvature is positive, none while it is negative",
        linear=False,
    ),
    rank=90,
    spoken="breathing crack",
    change=_change,
    moves_poles=True,
    once=False,
    search=EffectSearch(
        rank=90,
        slots=_slots,
        forms=FORMS,
        inexact=0.05,
        law=SteppedLaw(overtones="even", acts="couple"),
    ),
    experiment="Look for even overtones in the sine responses: a breathing crack makes even overtones at every level.",
)
