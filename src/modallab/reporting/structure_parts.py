"""What a structure's diagnosis tried, and its gap channel by channel and mode by mode, before and after."""

from modallab.core.digits import percent_text, probability_text, significant_digits
from modallab.core.modal_diagnosis import FoundChange, ModalDiagnosis, PartOfGap
from modallab.gap.modal.diagnosis import ComparisonOutcome
from modallab.gap.words.effects import numbers_of, spoken_change
from modallab.reporting.figures import style
from modallab.reporting.figures.log_bars import BarRow, BarScale, log_bars
from modallab.reporting.gap_page import page_section
from modallab.reporting.markup import Markup, html_element, html_table
from modallab.reporting.sections.section import captioned_figure

SHARE = BarScale("rms of measured less predicted [% of the response]", 0.1, 10.0, "{:.2g} %".format)
"""From a thousandth of the response."""
NAMES = ("as it came", "within tolerances", "with the change")
COLOURS = (style.SOFT, style.MEASURED, style.SECOND)


def candidates_section(explained: ComparisonOutcome) -> Markup | None:
    """Every explanation that was fitted, with its numbers, its probability and what it leaves; None without any."""
    listed = explained.ranked
    if not listed:
        return None
    found, judged = explained.diagnosis, explained.judged
    left = [c.gap for c in found.candidates]
    rows = [["no change", probability_text(judged.nothing), percent_text(found.before), ""]]
    rows += [
        [spoken_change(c), probability_text(c.probability), percent_text(gap), _numbers_of_change(c)]
        for c, gap in zip(listed, left, strict=True)
    ]
    rows.append(["something without a name", probability_text(judged.unknown), "", f"most likely in {judged.where}"])
    head = ["explanation", "probability", "leaves", "numbers (95 %)"]
    known = found.verdict == "known"
    caption = (
        "Probabilities are of all that stands here, and add up to 1. One that leaves the percentage as it is may still "
        "relieve the tolerances, which count as well."
    )
    none = "" if known else " Here none was needed, or none was enough, however probable it is beside the others."
    return page_section(
        "What else might explain it" if known else "What was tried",
        html_table("The best of each kind, once fitted", head, rows, numeric=(1, 2), class_="wide"),
        html_element("p", caption + none),
    )


def _numbers_of_change(change: FoundChange) -> str:
    caption = (f"{name} {value}" + f" ({between})" * bool(between) for name, value, between in numbers_of(change))
    return ", ".join(caption)


def parts_section(found: ModalDiagnosis) -> Markup | None:
    """Two figures: the gap of each mode and of each channel."""
    changed = found.after != found.before
    figures = [
        _budget_figure(parts, f"The gap {by}. {caption}", name, changed)
        for parts, by, caption, name in (
            (found.by_mode, "about each mode of the bench", "Each line counts for the mode nearest to it.", "modes"),
            (found.by_channel, "of each channel", "Over all driven points.", "channels"),
        )
        if parts
    ]
    return page_section("Where it shrinks", *figures) if figures else None


def _budget_figure(parts: list[PartOfGap], caption: str, name: str, changed: bool) -> Markup:
    many = 3 if changed else 2
    rows = [BarRow(_part_label(p), tuple(100 * v for v in (p.nominal, p.before, p.after)[:many])) for p in parts]
    figure = log_bars(rows, NAMES[:many], COLOURS[:many], scale=SHARE)
    return captioned_figure(figure, name, caption, caption, columns=1)


def _part_label(part: PartOfGap) -> str:
    return part.name if part.frequency_hz is None else f"{significant_digits(part.frequency_hz, 3)} Hz"
