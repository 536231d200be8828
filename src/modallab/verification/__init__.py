"""The model against the measurement: regenerated through the same block, compared by FRAC."""

from typing import TYPE_CHECKING

from modallab.core.lazy import lazily

if TYPE_CHECKING:
    from modallab.verification.assessment import Assessment, assessed
    from modallab.verification.comparison import Comparison, compare
    from modallab.verification.reservations import doubts, seen_by_one, unmatched
    from modallab.verification.verify import frac, synthesised, verify_frf, verify_impact, verify_sine

__all__ = [
    "Assessment",
    "Comparison",
    "assessed",
    "compare",
    "doubts",
    "frac",
    "seen_by_one",
    "synthesised",
    "unmatched",
    "verify_frf",
    "verify_impact",
    "verify_sine",
]

__getattr__ = lazily(
    __name__,
    {
        "assessment": ("Assessment", "assessed"),
        "comparison": ("Comparison", "compare"),
        "reservations": ("doubts", "seen_by_one", "unmatched"),
        "verify": ("frac", "synthesised", "verify_frf", "verify_impact", "verify_sine"),
    },
)
