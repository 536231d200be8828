"""The budget of a gap on its page: where it comes from, part by part."""

from modallab.core.budget import Budget, BudgetRow
from modallab.core.diagnosis import Diagnosis
from modallab.core.digits import part_of
from modallab.reporting.bars import Bar, scaled_bars
from modallab.reporting.gap_page import captioned_picture, page_section, typeset_sentence
from modallab.reporting.markup import Markup, html_element, html_table

LEAST_SHARE = 0.005
"""Share of the gap below which a part is left out of the table."""
LONGEST = 12
"""Bars of a budget."""
COLOURS = {"tolerance": "measured", "effect": "warning", "model": "model", "noise": "soft"}
CAPTION = (
    "Shares of the squares of measured less simulated as the rig file describes the bench; the response of each record "
    "counts alike. Blue: deviations within the tolerances. Those whose shares cancel are summed in one row. "
    "Tolerances below half a percent are left out."
)


def budget_section(diagnosis: Diagnosis) -> Markup | None:
    """Bars of the largest parts, what to calibrate first, and the table; None where there is no budget."""
    budget = diagnosis.budget
    if budget is None or not budget.rows:
        return None
    largest = [
        Bar(typeset_sentence(r.said), r.share, part_of(r.share), COLOURS[r.kind]) for r in _rows_shown(budget)[:LONGEST]
    ]
    first = (
        html_element("ul", *(html_element("li", typeset_sentence(line)) for line in budget.calibrate))
        if budget.calibrate
        else None
    )
    picture = captioned_picture(scaled_bars(largest, "Share of the gap of each part"), CAPTION)
    return page_section("Where it comes from", picture, first, _budget_table(budget), _usual_tolerances_note(budget))


def _rows_shown(budget: Budget) -> list[BudgetRow]:
    return [r for r in budget.rows if abs(r.share) > LEAST_SHARE or r.kind in ("model", "noise", "effect")]


def _budget_table(budget: Budget) -> Markup:
    head = ["part", "share", "deviation [σ]", "mostly in"]
    return html_table(
        "Budget of the gap", head, [_budget_row(r) for r in _rows_shown(budget)], numeric=(1, 2), class_="wide"
    )


def _budget_row(row: BudgetRow) -> list[str]:
    moved = "" if row.sigmas is None else f"{row.sigmas:+.1f}".replace("-", "\u2212")
    return [typeset_sentence(row.said), part_of(row.share), moved, _where_mostly(row)]


def _where_mostly(row: BudgetRow) -> str:
    """Test, channel, band and mode with the most of a part."""
    most = {division: max(by, key=lambda name: abs(by[name])) for division, by in row.by.items() if by}
    spoken = {"test": "{} test", "channel": "{}", "band": "{} Hz", "mode": "mode {}"}
    return ", ".join(spoken[division].format(name) for division, name in most.items()).replace("-", " to ")


def _usual_tolerances_note(budget: Budget) -> Markup | None:
    if not budget.usual:
        return None
    listed = ", ".join(f"{name} {value:g}" for name, value in budget.usual.items())
    return html_element("p", f"The rig file states no tolerances. A lab's usual ones stand for them: {listed}.")
