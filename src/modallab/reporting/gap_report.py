"""The report of a diagnosis: one HTML file that a person understands at once."""

from pathlib import Path

from modallab.core.block import Campaign
from modallab.core.diagnosis import BudgetRow, Diagnosis
from modallab.core.effects import kind_of
from modallab.formats.atomic import replacing
from modallab.gap.report.summary import in_percent, place_in_words, sentence
from modallab.gap.revisions.history import history
from modallab.reporting.described_section import described_section
from modallab.reporting.figures.gap_curves import gap_curves
from modallab.reporting.figures.gap_pictures import bench_picture, budget_bars, pair_bars, shrink_bar
from modallab.reporting.gap_page import captioned, page, section
from modallab.reporting.markup import Markup, table, tag
from modallab.reporting.revisions_report import revisions_section
from modallab.reporting.sections.section import plate
from modallab.twin.effects import model_of

LEAST_SHARE = 0.005
"""Share of the gap below which a part is left out of the table."""


def write_gap_report(path: Path, diagnosis: Diagnosis, campaign: Campaign) -> None:
    """Write the report. The file is whole or, after an error, as it was before.

    Raises:
        StorageError: the file can't be written.
    """
    text = render(diagnosis, campaign)
    with replacing(path) as draft:
        draft.write_text(text, encoding="utf-8", newline="\n")


def render(diagnosis: Diagnosis, campaign: Campaign) -> str:
    """The whole page as text."""
    return page(
        f"The gap of {campaign.rig.name}",
        (sentence(diagnosis), in_percent(diagnosis.gap)),
        _place(diagnosis, campaign),
        _effects(diagnosis),
        described_section(diagnosis),
        _shrink(diagnosis),
        _curves(diagnosis, campaign),
        _budget(diagnosis),
        _evidence(diagnosis),
        _split(diagnosis),
        _revisions(campaign),
        _next(diagnosis),
    )


def _place(diagnosis: Diagnosis, campaign: Campaign) -> Markup:
    where = diagnosis.where
    if where.stage is None:
        said = "Nothing stands out: what is left is noise."
    else:
        channels = ", ".join(where.channels) if where.channels else "no single channel"
        at = f", {where.x_m:.3f} m from the clamp" if where.x_m is not None else ""
        said = f"Stage: {where.stage}{at}. Channels: {channels}. Seen in: {' and '.join(where.tests) or 'no test'}."
    why = tag("ul", *(tag("li", w) for w in where.why)) if where.why else None
    return section("Where it lies", captioned(bench_picture(campaign.rig, where), said), why)


def _effects(diagnosis: Diagnosis) -> Markup | None:
    if not diagnosis.effects:
        return None
    rows: list[list[str]] = []
    for found in diagnosis.effects:
        kind = kind_of(found.effect)
        for parameter in kind.parameters:
            low, high = found.interval.get(parameter.name, (float("nan"), float("nan")))
            rows.append(
                [
                    model_of(found.effect).spoken,
                    f"{parameter.name} {f'({parameter.unit})' if parameter.unit else ''}",
                    f"{found.parameters[parameter.name]:.5g}",
                    f"{low:.5g} to {high:.5g}",
                    f"{found.probability:.2f}",
                ]
            )
        if not kind.parameters:
            rows.append([model_of(found.effect).spoken, place_in_words(found), "", "", f"{found.probability:.2f}"])
    head = ["effect", "parameter", "value", "95 % interval", "probability"]
    return section("What causes it", table("Effects judged present", head, rows, numeric=(2, 3, 4)))


def _shrink(diagnosis: Diagnosis) -> Markup | None:
    shrink = diagnosis.shrink
    if shrink.closed is None:
        return None
    said = (
        f"Share of the reducible gap that the effect closes on {len(shrink.held_out)} records no fit has seen: from "
        f"{shrink.before:.3g} to {shrink.after:.3g} noise units. The whisker is the 95 % interval by bootstrap."
    )
    return section("How far it shrinks", captioned(shrink_bar(shrink), said))


def _curves(diagnosis: Diagnosis, campaign: Campaign) -> Markup | None:
    figure = gap_curves(diagnosis, campaign)
    if figure is None:
        return None
    said = (
        "Measured; simulated before, as the rig file has the bench; simulated after, with all that was found; and what "
        "is left between the last and the measurement. The channel, the hits and the sine are those that are off most."
    )
    return section("What was measured, and what was simulated", plate(figure, "curves", said, said))


def _mostly(row: BudgetRow) -> str:
    """Test, channel, band and mode with the most of a part."""
    most = {division: max(by, key=lambda name: abs(by[name])) for division, by in row.by.items() if by}
    spoken = {"test": "{}", "channel": "{}", "band": "{} Hz", "mode": "mode {}"}
    return ", ".join(spoken[division].format(name) for division, name in most.items())


def _budget(diagnosis: Diagnosis) -> Markup | None:
    budget = diagnosis.budget
    if budget is None or not budget.rows:
        return None
    rows = [
        [r.said, "" if r.sigmas is None else f"{r.sigmas:+.1f}", f"{r.share:.1%}", _mostly(r)]
        for r in budget.rows
        if abs(r.share) > LEAST_SHARE or r.kind in ("model", "noise", "effect")
    ]
    head = ["part", "moved (sigma)", "share", "mostly in"]
    said = (
        "Shares of the squares of measured less simulated as the rig file has the bench, the response of each record "
        "counting alike. A negative share works against the others; parts below half a percent are left out."
    )
    picture = captioned(budget_bars(budget), said)
    usual = ", ".join(f"{name} {value:g}" for name, value in budget.usual.items())
    stands = (
        tag("p", f"The rig file states no tolerances. A lab's usual ones stand for them: {usual}.") if usual else None
    )
    first = tag("ul", *(tag("li", line) for line in budget.calibrate)) if budget.calibrate else None
    return section(
        "Where it comes from", picture, first, table("Budget of the gap", head, rows, numeric=(1, 2)), stands
    )


def _evidence(diagnosis: Diagnosis) -> Markup | None:
    if not diagnosis.candidates:
        return None
    rows = [
        [" and ".join(c.effects).replace("_", " "), f"{c.gap:.2f}", f"{c.probability:.3f}"]
        for c in diagnosis.candidates
    ]
    head = ["explanation", "gap it leaves (noise units)", "probability"]
    return section("The candidates", table("Explanations that were fitted to the end", head, rows, numeric=(1, 2)))


def _split(diagnosis: Diagnosis) -> Markup:
    gap = diagnosis.gap
    picture = pair_bars(gap.by_channel, gap.after_by_channel)
    said = (
        "Rms residual of each channel in noise units, on a logarithmic scale: before, and with the effects; 1 is noise."
    )
    bands = [[f"{k} Hz", f"{v:.1%}"] for k, v in gap.by_band.items()]
    tests = [[k, f"{v:.3g}"] for k, v in {**gap.by_test, **gap.by_level, **gap.by_order}.items()]
    return section(
        "The residual, before and after",
        captioned(picture, said),
        tag(
            "div",
            table("Share of the squares by band, before", ["band", "share"], bands, numeric=(1,)),
            table("Gap by test, level and time, before", ["part", "noise units"], tests, numeric=(1,)),
            class_="pair",
        ),
    )


def _revisions(campaign: Campaign) -> Markup | None:
    return revisions_section(history(campaign.rig)) if campaign.rig.revisions else None


def _next(diagnosis: Diagnosis) -> Markup:
    notes = tag("ul", *(tag("li", n) for n in diagnosis.notes)) if diagnosis.notes else None
    return section("What to do next", tag("p", diagnosis.next_experiment), notes)
