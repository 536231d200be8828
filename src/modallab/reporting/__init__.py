"""Figures, pages and tables for people: step E of the paper."""

from typing import TYPE_CHECKING

from modallab.core.lazy import lazily

if TYPE_CHECKING:
    from modallab.reporting.content import Hit, Outcome, ReportContent, Truth
    from modallab.reporting.figures.resolution import readings
    from modallab.reporting.gap_report import write_gap_report
    from modallab.reporting.report import write_report
    from modallab.reporting.table import modal_table

__all__ = ["Hit", "Outcome", "ReportContent", "Truth", "modal_table", "readings", "write_gap_report", "write_report"]

__getattr__ = lazily(
    __name__,
    {
        "content": ("Hit", "Outcome", "ReportContent", "Truth"),
        "figures.resolution": ("readings",),
        "gap_report": ("write_gap_report",),
        "report": ("write_report",),
        "table": ("modal_table",),
    },
)
