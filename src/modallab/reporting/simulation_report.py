"""A simulation compared with the bench, as a page."""

from pathlib import Path

from modallab.core.diagnosis import FoundEffect
from modallab.core.digits import probability_text
from modallab.core.effects import kind_of
from modallab.formats.atomic import write_text
from modallab.gap.simulations.compare import SimulationComparison
from modallab.gap.words.effects import parameter_in_words, place_of
from modallab.gap.words.verdicts import sentence_of_simulation
from modallab.reporting.gap_candidates import channel_bars, page_section, whole_page
from modallab.reporting.markup import Markup, html_element, html_table
from modallab.twin.effects import model_of


def write_simulation_report(path: Path, found: SimulationComparison) -> None:
    """Write the page. The file is whole or, after an error, as it was before.

    Raises:
        StorageError: the file can't be written.
    """
    text = whole_page(
        f"A simulation of {found.rig}",
        sentence_of_simulation(found),
        _effects_table(found),
        _channels_table(found),
        _notes_list(found),
    )
    write_text(path, text)


def _effects_table(found: SimulationComparison) -> Markup | None:
    rows = [_effect_row("the bench alone", f) for f in found.lacks]
    rows += [_effect_row("the simulation alone", f) for f in found.has]
    for pair in found.differs:
        rows += [_effect_row("the bench", pair.bench), _effect_row("the simulation", pair.simulation)]
    if not rows:
        return None
    head = ["who has it", "effect", "numbers", "place", "probability"]
    return page_section("What parts them", html_table("Effects", head, rows, numeric=(4,)))


def _effect_row(whose: str, found: FoundEffect) -> list[str]:
    numbers = ", ".join(f"{p.name} = {parameter_in_words(found, p)[0]}" for p in kind_of(found.effect).parameters)
    return [whose, model_of(found.effect).spoken, numbers, place_of(found)[0], probability_text(found.probability)]


def _channels_table(found: SimulationComparison) -> Markup:
    caption = (
        f"The gap of each channel on {len(found.records)} records, before and after the correction. Nothing "
        "is fitted. 1 is noise alone."
    )
    return page_section(
        "Channel by channel", channel_bars(found.by_channel, found.after_by_channel, "channels", caption)
    )


def _notes_list(found: SimulationComparison) -> Markup:
    return page_section("Beside that", html_element("ul", *(html_element("li", note) for note in found.notes)))
