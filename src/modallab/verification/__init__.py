"""The model against the measurement: regenerated through the same block, compared by FRAC."""

from typing import TYPE_CHECKING

from modallab.core.lazy import lazily

if TYPE_CHECKING:
    from modallab.verification.assessment import Assessment, assess_model
    from modallab.verification.comparison import Comparison, compare
    from modallab.verification.reservations import doubts, mismatch_warning, seen_by_one
    from modallab.verification.verify import frac, synthesised, verify_frf, verify_impact, verify_sine

__all__ = [
    "Assessment",
    "Comparison",
    "assess_model",
    "compare",
    "doubts",
    "frac",
    "mismatch_warning",
    "seen_by_one",
    "synthesised",
    "verify_frf",
    "verify_impact",
    "verify_sine",
]

__getattr__ = lazily(
    __name__,
    {
        "assessment": ("Assessment", "assess_model"),
        "comparison": ("Comparison", "compare"),
        "reservations": ("doubts", "seen_by_one", "mismatch_warning"),
        "verify": ("frac", "synthesised", "verify_frf", "verify_impact", "verify_sine"),
    },
)
