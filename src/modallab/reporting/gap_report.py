"""The report of a diagnosis: one HTML file that a person understands at once."""

from pathlib import Path

from modallab.core.block import Campaign
from modallab.core.budget import Budget, BudgetRow
from modallab.core.diagnosis import Diagnosis, FoundEffect, ResponseShare
from modallab.core.digits import probability_text, share_text, three_digits
from modallab.core.effect import x_m_of
from modallab.core.effects import kind_of
from modallab.core.rig import Rig
from modallab.formats.atomic import write_text
from modallab.gap.revisions import revision_history
from modallab.gap.words.effects import FROM_CLAMP, effect_names, interval_m, parameter_in_words, place_of
from modallab.gap.words.learned import numbers_of_description
from modallab.gap.words.verdicts import share_of_response, unexplained_sentence, verdict_sentence
from modallab.reporting.figures.gap_curves import gap_curves
from modallab.reporting.figures.gap_pictures import bench_picture
from modallab.reporting.gap_candidates import (
    candidates_section,
    captioned_picture,
    page_section,
    residual_section,
    shrinkage_bar,
    shrinkage_section,
    typeset_sentence,
    whole_page,
)
from modallab.reporting.markup import Bar, Markup, html_element, html_table, scaled_bars
from modallab.reporting.revisions_report import revisions_section
from modallab.reporting.sections.section import captioned_figure
from modallab.twin.effect_model import NoChange
from modallab.twin.effects import model_of

_LEAST_SHARE = 0.005
"""Share of the gap below which a part is left out of the table."""
_LONGEST = 12
"""Bars of a budget."""
_COLOURS = {"tolerance": "measured", "effect": "warning", "model": "model", "noise": "soft"}
_CAPTION = (
    "Shares of the squares of measured less simulated from the rig file; all records have equal "
    "weight. Blue: deviations within the tolerances. Deviations whose shares cancel are summed in one row. Tolerances "
    "below half a percent are left out."
)


def write_gap_report(path: Path, diagnosis: Diagnosis, campaign: Campaign) -> None:
    """Write the report. The file is whole or, after an error, as it was before.

    Raises:
        StorageError: the file can't be written.
    """
    text = render(diagnosis, campaign)
    write_text(path, text)


def render(diagnosis: Diagnosis, campaign: Campaign) -> str:
    """The whole page as text."""
    return whole_page(
        f"The gap of {campaign.rig.name}",
        typeset_sentence(verdict_sentence(diagnosis, _channel_names(campaign.rig))),
        _width_of_gap(diagnosis),
        _place_of_gap(diagnosis, campaign.rig),
        _effects_section(diagnosis, campaign.rig),
        described_section(diagnosis),
        shrinkage_section(diagnosis),
        _next_step_section(diagnosis),
        _curves_section(diagnosis, campaign),
        _budget_section(diagnosis),
        candidates_section(diagnosis),
        residual_section(diagnosis),
        _revisions_section(campaign),
    )


def _width_of_gap(diagnosis: Diagnosis) -> Markup:
    """The gap in both its measures: noise units, and percent of the response."""
    gap = diagnosis.gap
    rows = [
        ["simulated from the rig file", "–", *_resonant_and_other(gap.share_nominal)],
        ["the best fit within its tolerances", three_digits(gap.before), *_resonant_and_other(gap.share_before)],
    ]
    if diagnosis.effects:
        rows.append(["with the effects found", three_digits(gap.after), *_resonant_and_other(gap.share_after)])
    head = ["simulation", "noise units", "% at resonance", "% away from it"]
    widths = html_table("Measured less simulated", head, rows, numeric=(1, 2, 3))
    note = (
        "In noise units, 1 is noise alone. The percentages are of the response: the median over all records, without "
        "their noise. "
    )
    return html_element("section", widths, html_element("p", note + typeset_sentence(unexplained_sentence(gap))))


def _resonant_and_other(share: ResponseShare | None) -> tuple[str, str]:
    """At resonance and away from it."""
    at, away = (None, None) if share is None else (share.at_resonance, share.away)
    return share_of_response(at), share_of_response(away)


def _place_of_gap(diagnosis: Diagnosis, rig: Rig) -> Markup:
    where = diagnosis.where
    within = None
    if where.stage is None:
        caption = "No effect stands out: the residual lies within noise and tolerances."
    else:
        placed = [
            place_of(f, _channel_names(rig)) for f in diagnosis.effects if x_m_of(f.place) == where.x_m is not None
        ]
        at = f", {where.x_m:.3f} m from the clamp" if where.x_m is not None else ""
        if placed:
            at = f", {placed[0][0]}" + (f" (95 %: {placed[0][1]})" if placed[0][1] else "")
            within = next(filter(None, map(interval_m, diagnosis.effects)), None)
        channels = f" Channels: {', '.join(where.channels)}." if where.channels else ""
        tests = f" Seen in the {' and the '.join(where.tests)} test." if where.tests else ""
        caption = f"Stage: {where.stage}{at}.{channels}{tests}"
    why = html_element("ul", *(html_element("li", typeset_sentence(w)) for w in where.why)) if where.why else None
    picture = html_element("div", bench_picture(rig, where, within), class_="drawn")
    return page_section("Where it lies", captioned_picture(picture, typeset_sentence(caption)), why)


def _channel_names(rig: Rig) -> list[str]:
    return [c.name for c in rig.channels]


def _effects_section(diagnosis: Diagnosis, rig: Rig) -> Markup | None:
    if not diagnosis.effects:
        return None
    tables = [_effect_table(found, rig) for found in diagnosis.effects]
    return page_section("What causes it", html_element("div", *tables, class_="pair" if len(tables) > 1 else ""))


def _effect_table(found: FoundEffect, rig: Rig) -> Markup:
    """A table of one effect: its place and its numbers, each with its interval."""
    place, interval = place_of(found, _channel_names(rig))
    tail = FROM_CLAMP
    rows = [["place" + tail * place.endswith(tail), place.removesuffix(tail), interval]] if place else []
    rows += [
        [p.in_words, *map(typeset_sentence, parameter_in_words(found, p))] for p in kind_of(found.effect).parameters
    ]
    caption = f"{model_of(found.effect).spoken}, probability {probability_text(found.probability)}"
    return html_table(caption[0].upper() + caption[1:], ["", "value", "95 % interval"], rows, numeric=(1, 2))


def _curves_section(diagnosis: Diagnosis, campaign: Campaign) -> Markup | None:
    figure = gap_curves(diagnosis, campaign)
    if figure is None:
        return None
    caption = (
        "Measurement, simulation from the rig file, simulation with the effects found, and the residual of the last. "
        "The residual is below the curves of an FRF, and in a separate panel for a record. Channels, hits and sine "
        "are those with the widest gap."
    )
    absent = [f.effect for f in diagnosis.effects if isinstance(model_of(f.effect).change, NoChange)]
    if absent:
        caption += f" No simulation contains {effect_names(absent)}, which stays in the residual."
    return page_section("Measured and simulated", captioned_figure(figure, "curves", caption, caption))


def _revisions_section(campaign: Campaign) -> Markup | None:
    return revisions_section(revision_history(campaign.rig)) if campaign.rig.revisions else None


def _next_step_section(diagnosis: Diagnosis) -> Markup:
    notes = (
        html_element("ul", *(html_element("li", typeset_sentence(n)) for n in diagnosis.notes))
        if diagnosis.notes
        else None
    )
    return page_section("What to do next", html_element("p", typeset_sentence(diagnosis.next_experiment)), notes)


def described_section(diagnosis: Diagnosis) -> Markup | None:
    """What the gap behaves like, its numbers and how far it closes it; None where nothing describes it."""
    described = diagnosis.described
    if described is None:
        return None
    rows = numbers_of_description(described)
    shrink = described.shrink
    caption = (
        f"Share of the reducible gap that this closes on {len(shrink.held_out)} held-out records: from "
        f"{three_digits(shrink.before)} to {three_digits(shrink.after)} noise units. This is no cause: other causes "
        "may behave alike."
    )
    others = [
        html_element("li", f"{other.says}: leaves {three_digits(other.gap)} noise units")
        for other in described.alternatives
    ]
    return page_section(
        "Description of the unnamed cause",
        html_element("p", f"The gap behaves like {described.says.rstrip(',')}."),
        html_table("A learned element of the simulation", ["number", "value", "95 % interval"], rows, numeric=(1,)),
        captioned_picture(shrinkage_bar("with the learned element", shrink), caption),
        html_element("p", model_of(described.elements[0].element).experiment),
        html_element("ul", *others) if others else None,
    )


def _budget_section(diagnosis: Diagnosis) -> Markup | None:
    """Bars of the largest parts, what to calibrate first, and the table; None where there is no budget."""
    budget = diagnosis.budget
    if budget is None or not budget.rows:
        return None
    largest = [
        Bar(typeset_sentence(r.said), r.share, share_text(r.share), _COLOURS[r.kind])
        for r in _rows_shown(budget)[:_LONGEST]
    ]
    first = (
        html_element("ul", *(html_element("li", typeset_sentence(line)) for line in budget.calibrate))
        if budget.calibrate
        else None
    )
    picture = captioned_picture(scaled_bars(largest, "Share of the gap of each part"), _CAPTION)
    return page_section("Causes of the gap", picture, first, _budget_table(budget), _usual_tolerances_note(budget))


def _rows_shown(budget: Budget) -> list[BudgetRow]:
    return [r for r in budget.rows if abs(r.share) > _LEAST_SHARE or r.kind in ("model", "noise", "effect")]


def _budget_table(budget: Budget) -> Markup:
    head = ["part", "share", "deviation [σ]", "mostly in"]
    return html_table(
        "Budget of the gap", head, [_budget_row(r) for r in _rows_shown(budget)], numeric=(1, 2), class_="wide"
    )


def _budget_row(row: BudgetRow) -> list[str]:
    moved = "" if row.sigmas is None else f"{row.sigmas:+.1f}".replace("-", "\u2212")
    return [typeset_sentence(row.said), share_text(row.share), moved, _where_mostly(row)]


def _where_mostly(row: BudgetRow) -> str:
    """Test, channel, band and mode with the most of a part."""
    most = {division: max(by, key=lambda name: abs(by[name])) for division, by in row.by.items() if by}
    spoken = {"test": "{} test", "channel": "{}", "band": "{} Hz", "mode": "mode {}"}
    return ", ".join(spoken[division].format(name) for division, name in most.items()).replace("-", " to ")


def _usual_tolerances_note(budget: Budget) -> Markup | None:
    if not budget.usual:
        return None
    listed = ", ".join(f"{name} {value:g}" for name, value in budget.usual.items())
    return html_element("p", f"The rig file states no tolerances. Those of an ordinary lab are used: {listed}.")
