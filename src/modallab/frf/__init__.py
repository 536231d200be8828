"""Every frequency response function begins as scaled, mean-free blocks: steps A, B and C of the paper."""

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

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


class _Callable(ModuleType):
    """This package once it is imported, under a name that it shares with a function: `modallab.frf(f, H)`."""

    def __call__(self, f: Any, H: Any, inputs: Any = None, outputs: Any = None, quantity: Any = "inertance") -> Any:
        """As `modallab.notebook.measured.frf`: FRFs from arrays."""
        return import_module("modallab.notebook.measured").frf(f, H, inputs, outputs, quantity)


# Importing it puts it in the place of the function, for whoever writes `import modallab as ml; ml.frf(...)`.
sys.modules[__name__].__class__ = _Callable

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
