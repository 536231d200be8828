"""Modal parameters from blocks and FRFs: step D of the paper."""

from typing import TYPE_CHECKING

from modallab.core.lazy import lazy_getattr

if TYPE_CHECKING:
    from modallab.identification.estimate import PoleEstimate, estimate_poles
    from modallab.identification.estimator import Estimator, ModelOrder, estimator_names, find_estimator
    from modallab.identification.frf_model import identify_frf
    from modallab.identification.impact import default_band, identify_impact
    from modallab.identification.likelihood.fit import LikelihoodFit
    from modallab.identification.model.modal_model import receptance_of_model
    from modallab.identification.options import IdentificationOptions
    from modallab.identification.selection.criteria import auto_mac, comac, mac, mpc, mpd
    from modallab.identification.selection.diagram import StabilisationData, stabilisation_diagram
    from modallab.identification.sine import identify_sine
    from modallab.identification.start.bands import cmif, mmif
    from modallab.identification.start.stabilisation import OrderPoles, StabilityLimits, StablePole, stable_poles

__all__ = [
    "Estimator",
    "IdentificationOptions",
    "LikelihoodFit",
    "ModelOrder",
    "OrderPoles",
    "PoleEstimate",
    "StabilisationData",
    "StabilityLimits",
    "StablePole",
    "auto_mac",
    "cmif",
    "comac",
    "default_band",
    "estimate_poles",
    "estimator_names",
    "find_estimator",
    "identify_frf",
    "identify_impact",
    "identify_sine",
    "mac",
    "mmif",
    "mpc",
    "mpd",
    "receptance_of_model",
    "stabilisation_diagram",
    "stable_poles",
]

__getattr__ = lazy_getattr(
    __name__,
    {
        "estimate": ("PoleEstimate", "estimate_poles"),
        "estimator": ("Estimator", "ModelOrder", "estimator_names", "find_estimator"),
        "frf_model": ("identify_frf",),
        "impact": ("default_band", "identify_impact"),
        "likelihood.fit": ("LikelihoodFit",),
        "model.modal_model": ("receptance_of_model",),
        "options": ("IdentificationOptions",),
        "selection.criteria": ("auto_mac", "comac", "mac", "mpc", "mpd"),
        "selection.diagram": ("StabilisationData", "stabilisation_diagram"),
        "sine": ("identify_sine",),
        "start.bands": ("cmif", "mmif"),
        "start.stabilisation": ("OrderPoles", "StablePole", "StabilityLimits", "stable_poles"),
    },
)
