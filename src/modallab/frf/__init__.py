"""Every frequency response function begins as scaled, mean-free blocks: steps A, B and C of the paper."""

from typing import TYPE_CHECKING

from modallab.core.lazy import lazily

if TYPE_CHECKING:
    from modallab.frf.estimate import convert, group_by_point, impact_frf
    from modallab.frf.local_polynomial import local_polynomial_frf
    from modallab.frf.mass_cancellation import without_mass, without_mass_in
    from modallab.frf.references import Estimate, estimate_frf
    from modallab.frf.segments import Stretches, stretches
    from modallab.frf.stepped import stepped_frf

__all__ = [
    "Estimate",
    "Stretches",
    "convert",
    "estimate_frf",
    "group_by_point",
    "impact_frf",
    "local_polynomial_frf",
    "stepped_frf",
    "stretches",
    "without_mass",
    "without_mass_in",
]

__getattr__ = lazily(
    __name__,
    {
        "estimate": ("convert", "group_by_point", "impact_frf"),
        "local_polynomial": ("local_polynomial_frf",),
        "mass_cancellation": ("without_mass", "without_mass_in"),
        "references": ("Estimate", "estimate_frf"),
        "segments": ("Stretches", "stretches"),
        "stepped": ("stepped_frf",),
    },
)
