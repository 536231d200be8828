"""modallab: drives a modal test bench, identifies its modal model, and diagnoses the sim-to-real gap.

`import modallab as ml` is for people at a notebook: `ml.simulate`, `ml.load`, `ml.frf`, `ml.identify`, `ml.diagnose`.
"""

from typing import TYPE_CHECKING

from modallab.core.lazy import lazy_getattr

if TYPE_CHECKING:
    from modallab.core.documents.model_use import ImpulseForce, RandomForce, SineForce, SweepForce
    from modallab.formats.fem.matrix_model import MatrixModel
    from modallab.modification.attachments import Element, RigidLink, TunedAbsorber
    from modallab.modification.coupled import CouplingToStructure
    from modallab.notebook.display import DisplayedResult
    from modallab.notebook.driven_records import driven
    from modallab.notebook.gap import Agreement, GapDiagnosis, agreement, diagnose
    from modallab.notebook.identify import identify
    from modallab.notebook.measured_frf import MeasuredFrf, frf
    from modallab.notebook.model import Model
    from modallab.notebook.model_behaviour import DeflectionShape, ModelBehaviour
    from modallab.notebook.model_comparison import CorrelatedModes, ModelComparison, UpdatedModel
    from modallab.notebook.model_predictions import ChangedModel, ModelPredictions
    from modallab.notebook.predicted_motion import PredictedMotion
    from modallab.notebook.recording import Recording, load, responses
    from modallab.notebook.simulate import simulate
    from modallab.notebook.twin import DiagnosedTwin
    from modallab.updating.result import Prior

__version__ = "0.1.0"

__all__ = [
    "Agreement",
    "ChangedModel",
    "CorrelatedModes",
    "CouplingToStructure",
    "DeflectionShape",
    "DiagnosedTwin",
    "DisplayedResult",
    "Element",
    "GapDiagnosis",
    "ImpulseForce",
    "MatrixModel",
    "MeasuredFrf",
    "Model",
    "ModelBehaviour",
    "ModelComparison",
    "ModelPredictions",
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
        "core.documents.model_use": ("ImpulseForce", "RandomForce", "SineForce", "SweepForce"),
        "modification.attachments": ("Element", "RigidLink", "TunedAbsorber"),
        "modification.coupled": ("CouplingToStructure",),
        "notebook.model_behaviour": ("DeflectionShape", "ModelBehaviour"),
        "notebook.display": ("DisplayedResult",),
        "notebook.predicted_motion": ("PredictedMotion",),
        "notebook.model_predictions": ("ChangedModel", "ModelPredictions"),
        "notebook.gap": ("Agreement", "GapDiagnosis", "agreement", "diagnose"),
        "notebook.measured_frf": ("MeasuredFrf", "frf"),
        "notebook.model": ("Model",),
        "notebook.identify": ("identify",),
        "notebook.model_comparison": ("ModelComparison", "CorrelatedModes", "UpdatedModel"),
        "updating.result": ("Prior",),
        "formats.fem.matrix_model": ("MatrixModel",),
        "notebook.recording": ("Recording", "load", "responses"),
        "notebook.driven_records": ("driven",),
        "notebook.simulate": ("simulate",),
        "notebook.twin": ("DiagnosedTwin",),
    },
)


def __dir__() -> list[str]:
    return __all__
