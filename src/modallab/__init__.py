"""modallab: drives a modal test bench, identifies its modal model, and diagnoses the sim-to-real gap.

`import modallab as ml` is for people at a notebook: `ml.simulate`, `ml.load`, `ml.frf`, `ml.identify`, `ml.diagnose`.
"""

from typing import TYPE_CHECKING

from modallab.core.lazy import lazy_getattr

if TYPE_CHECKING:
    from modallab.core.documents.forces import ImpulseForce, RandomForce, SineForce, SweepForce
    from modallab.formats.fem.matrix_model import MatrixModel
    from modallab.modification.attachments import Element, RigidLink, TunedAbsorber
    from modallab.modification.coupled import CouplingToStructure
    from modallab.notebook.correlated import Correlated, CorrelatedModes, UpdatedModel
    from modallab.notebook.driven import driven
    from modallab.notebook.gap import Agreement, GapFound, agreement, diagnose
    from modallab.notebook.identify import identify
    from modallab.notebook.measured import MeasuredFrf, frf
    from modallab.notebook.model import Model
    from modallab.notebook.predicted_motion import PredictedMotion
    from modallab.notebook.put_to_use import ChangedModel, ModelUses
    from modallab.notebook.recording import Recording, load, responses
    from modallab.notebook.shown import DisplayedResult
    from modallab.notebook.simulate import simulate
    from modallab.notebook.twin import DiagnosedTwin
    from modallab.notebook.understood import DeflectionShape, ModelBehaviour
    from modallab.updating.prior import Prior

__version__ = "0.1.0"

__all__ = [
    "Agreement",
    "ChangedModel",
    "Correlated",
    "CorrelatedModes",
    "CouplingToStructure",
    "DeflectionShape",
    "DiagnosedTwin",
    "DisplayedResult",
    "Element",
    "GapFound",
    "ImpulseForce",
    "MatrixModel",
    "MeasuredFrf",
    "Model",
    "ModelBehaviour",
    "ModelUses",
    "PredictedMotion",
    "Prior",
    "RandomForce",
    "Recording",
    "RigidLink",
    "SineForce",
    "SweepForce",
    "TunedAbsorber",
    "UpdatedModel",
    "__version__",
    "agreement",
    "diagnose",
    "driven",
    "frf",
    "identify",
    "load",
    "responses",
    "simulate",
]

__getattr__ = lazy_getattr(
    __name__,
    {
        "core.documents.forces": ("ImpulseForce", "RandomForce", "SineForce", "SweepForce"),
        "modification.attachments": ("Element", "RigidLink", "TunedAbsorber"),
        "modification.coupled": ("CouplingToStructure",),
        "notebook.understood": ("DeflectionShape", "ModelBehaviour"),
        "notebook.shown": ("DisplayedResult",),
        "notebook.predicted_motion": ("PredictedMotion",),
        "notebook.put_to_use": ("ChangedModel", "ModelUses"),
        "notebook.gap": ("Agreement", "GapFound", "agreement", "diagnose"),
        "notebook.measured": ("MeasuredFrf", "frf"),
        "notebook.model": ("Model",),
        "notebook.identify": ("identify",),
        "notebook.correlated": ("Correlated", "CorrelatedModes", "UpdatedModel"),
        "updating.prior": ("Prior",),
        "formats.fem.matrix_model": ("MatrixModel",),
        "notebook.recording": ("Recording", "load", "responses"),
        "notebook.driven": ("driven",),
        "notebook.simulate": ("simulate",),
        "notebook.twin": ("DiagnosedTwin",),
    },
)


def __dir__() -> list[str]:
    return __all__
