"""The gap between twin and bench: how large, where, why, and how far it shrinks."""

from typing import TYPE_CHECKING

from modallab.core.lazy import lazily

if TYPE_CHECKING:
    from modallab.gap.design.distinguishability import Distinguishability, advice, distinguishability
    from modallab.gap.design.prediction import predict, predicted_campaign
    from modallab.gap.diagnosis import diagnose
    from modallab.gap.report.calibrated import diagnosed_twin
    from modallab.gap.words.verdicts import sentence

__all__ = [
    "Distinguishability",
    "advice",
    "diagnose",
    "diagnosed_twin",
    "distinguishability",
    "predict",
    "predicted_campaign",
    "sentence",
]

__getattr__ = lazily(
    __name__,
    {
        "design.distinguishability": ("Distinguishability", "advice", "distinguishability"),
        "design.prediction": ("predict", "predicted_campaign"),
        "report.calibrated": ("diagnosed_twin",),
        "diagnosis": ("diagnose",),
        "words.verdicts": ("sentence",),
    },
)
