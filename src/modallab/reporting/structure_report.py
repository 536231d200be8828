"""The report of a structure held against its modal model: one HTML file that a person understands at once."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from modallab.core.digits import percent_text, probability_text, significant_digits
from modallab.core.effect import NamedChannel
from modallab.core.frf import Frf
from modallab.core.modal_diagnosis import FoundChange, ModalDiagnosis, PartOfGap
from modallab.core.rig import Rig
from modallab.formats.atomic import write_text
from modallab.gap.modal.diagnosis import ComparisonOutcome
from modallab.gap.words.effects import change_with_place, effect_phrase, numbers_of, place_of_change, position_of_change
from modallab.gap.words.verdicts import sentence_by_model
from modallab.reporting.figures import style
from modallab.reporting.figures.log_bars import BarRow, BarScale, log_bars
from modallab.reporting.figures.structure_curves import structure_curves
from modallab.reporting.figures.structure_picture import MarkedPlaces, structure_picture
from modallab.reporting.gap_candidates import captioned_picture, page_section, typeset_sentence, whole_page
from modallab.reporting.markup import Markup, html_element, html_table
from modallab.reporting.sections.section import captioned_figure

_SHARE = BarScale("rms of measured less predicted [% of the response]", 0.1, 10.0, "{:.2g} %".format)
"""From a thousandth of the response."""
_NAMES = ("as it came", "within tolerances", "with the change")
_COLOURS = (style.SOFT, style.MEASURED, style.SECOND)


@dataclass(frozen=True, eq=False, slots=True)
class StructureGap:
    """What the report shows.

    Attributes:
        rig: of the campaign, with all its points.
        explained: the comparison and what it came to.
        reference: what it is compared with, in words.
        records: mobility of the records that the bench's model was identified from; None where there is none.
        beside: what the campaign holds and nothing looked at, a sentence each.
    """

    rig: Rig
    explained: ComparisonOutcome
    reference: str
    records: Frf | None = None
    beside: tuple[str, ...] = ()

    @property
    def diagnosis(self) -> ModalDiagnosis:
        """What is said of it, as a document."""
        return self.explained.diagnosis


def write_structure_report(path: Path, gap: StructureGap) -> None:
    """Write the report. The file is whole or, after an error, as it was before.

    Raises:
        StorageError: the file can't be written.
    """
    text = render(gap)
    write_text(path, text)


def render(gap: StructureGap) -> str:
    """The whole page as text."""
    return whole_page(
        f"The gap of {gap.rig.name}",
        [typeset_sentence(sentence_by_model(gap.diagnosis)), *(typeset_sentence(note) for note in gap.diagnosis.notes)],
        _width_of_gap(gap),
        _place_of_gap(gap),
        _explanation_list(gap.diagnosis),
        _candidates_section(gap.explained),
        _curves_section(gap),
        _parts_section(gap.diagnosis),
        _not_compared_list(gap),
    )


def _width_of_gap(gap: StructureGap) -> Markup:
    found = gap.diagnosis
    rows = [
        ["as it came", percent_text(found.nominal), "–"],
        ["the best fit within the tolerances", percent_text(found.before), f"{found.strain_before:.2f}"],
    ]
    if found.effects:
        rows.append(["with the effects found", percent_text(found.after), f"{found.strain_after:.2f}"])
    head = ["the reference", "% of the response", "strain of the tolerances [σ]"]
    note = (
        f"The reference: {gap.reference}. Percentages are the rms of measured less predicted over the measured "
        "response, of all FRFs of both models, where each mode counts alike. The strain is the rms deviation of all "
        "numbers within their tolerances, and of unnamed causes: 1 is ordinary."
    )
    return html_element(
        "section",
        html_table("Measured less predicted", head, rows, numeric=(1, 2)),
        html_element("p", typeset_sentence(note)),
    )


def _place_of_gap(gap: StructureGap) -> Markup | None:
    if not gap.rig.points:
        return None
    found = gap.diagnosis.effects
    marked = _marked_picture(gap, found[0]) if found else None
    if found:
        at = position_of_change(found[0])
        place = "" if at is None else f", at ({', '.join(f'{x:.3f}' for x in at)}) m"
        caption = f"Stage: {found[0].stage}. The {change_with_place(found[0])}{place}."
    elif gap.diagnosis.verdict == "no_gap":
        caption = "No effect stands out: the residual lies within the tolerances."
    else:
        caption = "No place stands out: no candidate explains the gap."
    caption += " Filled points have a sensor."
    return page_section(
        "Where it lies",
        captioned_picture(html_element("div", structure_picture(gap.rig, marked), class_="drawn"), caption),
    )


def _marked_picture(gap: StructureGap, change: FoundChange) -> MarkedPlaces | None:
    at, label = position_of_change(change), effect_phrase(change)
    if at is not None:
        return MarkedPlaces(np.array([at]), label=label)
    places = {p.id: (p.x_m, p.y_m, p.z_m) for p in gap.rig.points}
    name = change.place.channel if isinstance(change.place, NamedChannel) else None
    channel = next((c for c in gap.rig.responses if c.name == name), None)
    if channel is None:
        driven = [places[p] for p in gap.explained.free.of.model.input_points if p in places]
        return MarkedPlaces(np.array(driven).reshape(-1, 3), label=label)
    if channel.point not in places:
        return None
    here = np.array(places[channel.point])
    moved = [change.parameters.get(axis, 0.0) for axis in ("dx", "dy", "dz")]
    return MarkedPlaces(here[None], here + moved if any(moved) else None, f"{channel.name}: {label}")


def _explanation_list(found: ModalDiagnosis) -> Markup | None:
    if not found.effects:
        return None
    tables = [
        html_table(
            f"{effect_phrase(c).capitalize()} {place_of_change(c)}, probability {probability_text(c.probability)}",
            ["", "value", "95 % interval"],
            numbers_of(c),
            numeric=(1, 2),
        )
        for c in found.effects
    ]
    return page_section("What causes it", *tables)


def _curves_section(gap: StructureGap) -> Markup:
    caption = (
        "Mobility at the outputs with the largest error, each at its worst driven point: identified from the "
        "records without the effect of their blocks, of the reference before and after its correction, and the "
        "residual "
        "of the correction."
    )
    if gap.records is not None:
        caption += (
            " Thin lines are the records: where a block ends before the ring-down, their peaks are lower and wider."
        )
    figure = structure_curves(gap.explained, gap.records)
    return page_section("Measurement and reference", captioned_figure(figure, "curves", caption, caption))


def _not_compared_list(gap: StructureGap) -> Markup:
    c = gap.explained.free.of
    low, high = c.s.imag[[0, -1]] / (2 * np.pi)
    axes = sorted({axis for _, axis in c.shapes.freedoms})
    sentences = [
        *gap.beside,
        f"Frequencies below {low:.4g} Hz and above {high:.4g} Hz.",
        "Two changes at once: candidates are single changes.",
        "A clamp: no candidate describes it.",
        "Amplitude-dependent effects: both models are linear.",
        f"Unmeasured motion: springs act along {', '.join(axes)} only, and a mass counts along these.",
    ]
    return page_section(
        "Not examined",
        html_element("ul", *(html_element("li", typeset_sentence(line)) for line in sentences)),
    )


def _candidates_section(explained: ComparisonOutcome) -> Markup | None:
    """Every explanation that was fitted, with its numbers, its probability and what it leaves; None without any."""
    listed = explained.ranked
    if not listed:
        return None
    found, judged = explained.diagnosis, explained.judged
    left = [c.gap for c in found.candidates]
    rows = [["no change", probability_text(judged.nothing), percent_text(found.before), ""]]
    rows += [
        [change_with_place(c), probability_text(c.probability), percent_text(gap), _numbers_of_change(c)]
        for c, gap in zip(listed, left, strict=True)
    ]
    rows.append(["an unnamed cause", probability_text(judged.unknown), "", f"most likely: {judged.where}"])
    head = ["explanation", "probability", "leaves", "numbers (95 %)"]
    known = found.verdict == "known"
    caption = (
        "The probabilities of all rows add up to 1. A cause that does not reduce the percentage may still "
        "reduce the strain of the tolerances, which counts too."
    )
    none = "" if known else " Here no cause was needed, or none was sufficient, whatever its probability."
    return page_section(
        "Other explanations" if known else "What was tried",
        html_table("The best of each kind, once fitted", head, rows, numeric=(1, 2), class_="wide"),
        html_element("p", caption + none),
    )


def _numbers_of_change(change: FoundChange) -> str:
    caption = (f"{name} {value}" + f" ({between})" * bool(between) for name, value, between in numbers_of(change))
    return ", ".join(caption)


def _parts_section(found: ModalDiagnosis) -> Markup | None:
    """Two figures: the gap of each mode and of each channel."""
    figures = [
        _budget_figure(parts, f"The gap {by}. {caption}", name, bool(found.effects))
        for parts, by, caption, name in (
            (found.by_mode, "about each mode of the bench", "Each line counts for its nearest mode.", "modes"),
            (found.by_channel, "of each channel", "Over all driven points.", "channels"),
        )
        if parts
    ]
    return page_section("Where it shrinks" if found.effects else "Where it is", *figures) if figures else None


def _budget_figure(parts: list[PartOfGap], caption: str, name: str, changed: bool) -> Markup:
    many = 3 if changed else 2
    rows = [BarRow(_part_label(p), tuple(100 * v for v in (p.nominal, p.before, p.after)[:many])) for p in parts]
    figure = log_bars(rows, _NAMES[:many], _COLOURS[:many], scale=_SHARE)
    return captioned_figure(figure, name, caption, caption, columns=1)


def _part_label(part: PartOfGap) -> str:
    return part.name if part.frequency_hz is None else f"{significant_digits(part.frequency_hz, 3)} Hz"
