"""The gap between twin and bench: how large, where, why, and how far it shrinks."""

from typing import TYPE_CHECKING

from modallab.core.lazy import lazily

if TYPE_CHECKING:
    from modallab.gap.design.distinguishability import Distinguishability, advice, distinguishability
    from modallab.gap.design.prediction import diagnosed_twin, predict
    from modallab.gap.diagnosis import diagnose
    from modallab.gap.report.summary import sentence

__all__ = ["Distinguishability", "advice", "diagnose", "diagnosed_twin", "distinguishability", "predict", "sentence"]

__getattr__ = lazily(
    __name__,
    {
        "design.distinguishability": ("Distinguishability", "advice", "distinguishability"),
        "design.prediction": ("diagnosed_twin", "predict"),
        "diagnosis": ("diagnose",),
        "report.summary": ("sentence",),
    },
)
