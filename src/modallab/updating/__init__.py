"""A finite-element model beside a test: which modes are the same, and its parameters estimated from the test."""

from typing import TYPE_CHECKING

from modallab.core.lazy import lazily

if TYPE_CHECKING:
    from modallab.updating.beam_model import BeamModel
    from modallab.updating.correlation import Correlation, correlate
    from modallab.updating.posterior import update
    from modallab.updating.prior import Prior
    from modallab.updating.result import UpdatedParameters

__all__ = ["BeamModel", "Correlation", "Prior", "UpdatedParameters", "correlate", "update"]

__getattr__ = lazily(
    __name__,
    {
        "beam_model": ("BeamModel",),
        "correlation": ("Correlation", "correlate"),
        "posterior": ("update",),
        "prior": ("Prior",),
        "result": ("UpdatedParameters",),
    },
)
