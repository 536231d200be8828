"""A simulation compared with the bench, as a page."""

from pathlib import Path

from modallab.core.diagnosis import Found
from modallab.core.digits import probability
from modallab.core.effects import kind_of
from modallab.formats.atomic import write_text
from modallab.gap.simulations.compare import Compared
from modallab.gap.words.effects import of_parameter, place_of
from modallab.gap.words.verdicts import sentence_of_simulation
from modallab.reporting.gap_candidates import channel_bars
from modallab.reporting.gap_page import page, section
from modallab.reporting.markup import Markup, table, tag
from modallab.twin.effects import model_of


def write_simulation_report(path: Path, found: Compared) -> None:
    """Write the page. The file is whole or, after an error, as it was before.

    Raises:
        StorageError: the file can't be written.
    """
    text = page(
        f"A simulation of {found.rig}", sentence_of_simulation(found), _effects(found), _channels(found), _notes(found)
    )
    write_text(path, text)


def _effects(found: Compared) -> Markup | None:
    rows = [_row("the bench alone", f) for f in found.lacks]
    rows += [_row("the simulation alone", f) for f in found.has]
    for pair in found.differs:
        rows += [_row("the bench", pair.bench), _row("the simulation", pair.simulation)]
    if not rows:
        return None
    head = ["who has it", "effect", "numbers", "place", "probability"]
    return section("What parts them", table("Effects", head, rows, numeric=(4,)))


def _row(whose: str, found: Found) -> list[str]:
    numbers = ", ".join(f"{p.name} = {of_parameter(found, p)[0]}" for p in kind_of(found.effect).parameters)
    return [whose, model_of(found.effect).spoken, numbers, place_of(found)[0], probability(found.probability)]


def _channels(found: Compared) -> Markup:
    caption = (
        f"The gap of each channel on {len(found.records)} records, before: as the simulation is, and after: corrected. "
        "Nothing is fitted. 1 is noise alone."
    )
    return section("Channel by channel", channel_bars(found.by_channel, found.after_by_channel, "channels", caption))


def _notes(found: Compared) -> Markup:
    return section("Beside that", tag("ul", *(tag("li", note) for note in found.notes)))
