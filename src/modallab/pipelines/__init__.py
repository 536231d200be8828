"""Jobs a worker can do: pure functions of a campaign and parameters."""

from typing import TYPE_CHECKING

from modallab.core.lazy import lazily

if TYPE_CHECKING:
    from modallab.pipelines.assess import assess_frf, assess_impact, assess_sine
    from modallab.pipelines.diagram import diagram_of
    from modallab.pipelines.identify import Identified, Result, Unidentified, identify_campaign
    from modallab.pipelines.job_kinds import campaigns_of, kinds
    from modallab.pipelines.known_modes import with_known_modes, with_modes
    from modallab.pipelines.model_file import model_document, read_models, write_models
    from modallab.pipelines.parameters import DiagnoseParameters, IdentifyParameters, ReportParameters, parse_parameters
    from modallab.pipelines.report import report_content, truth_of

__all__ = [
    "DiagnoseParameters",
    "Identified",
    "IdentifyParameters",
    "ReportParameters",
    "Result",
    "Unidentified",
    "assess_frf",
    "assess_impact",
    "assess_sine",
    "campaigns_of",
    "diagram_of",
    "identify_campaign",
    "kinds",
    "model_document",
    "parse_parameters",
    "read_models",
    "report_content",
    "truth_of",
    "with_known_modes",
    "with_modes",
    "write_models",
]

__getattr__ = lazily(
    __name__,
    {
        "assess": ("assess_frf", "assess_impact", "assess_sine"),
        "diagram": ("diagram_of",),
        "identify": ("Identified", "Result", "Unidentified", "identify_campaign"),
        "job_kinds": ("campaigns_of", "kinds"),
        "known_modes": ("with_known_modes", "with_modes"),
        "model_file": ("model_document", "read_models", "write_models"),
        "parameters": ("DiagnoseParameters", "IdentifyParameters", "ReportParameters", "parse_parameters"),
        "report": ("report_content", "truth_of"),
    },
)
