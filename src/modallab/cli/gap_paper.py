"""`modallab gap paper`: Table 1 of the paper, and what explains each of its numbers."""

import argparse

from rich.table import Table

from modallab.cli.console import console_of, write_json
from modallab.core.digits import percent_text
from modallab.pipelines.paper import PaperExplained, explain_paper


def run(arguments: argparse.Namespace) -> int:
    """Print the table with what explains it."""
    found, console = explain_paper(), console_of(arguments)
    console.print(_modes_table(found))
    console.print(_beams_table(found))
    for line in found.said:
        console.print(line, markup=False, highlight=False)
    if arguments.json is not None:
        write_json(arguments.json, found.model_dump(mode="json"))
    return 0


def _modes_table(found: PaperExplained) -> Table:
    table = Table("printed", "damping", "line", "read without window", "under Hann", title="Table 1")
    for mode in found.modes:
        line = f"{mode.line}{'' if mode.on_line else ' (between)'}"
        plain, hann = (f"{100 * low:.2f} to {100 * high:.2f} %" for low, high in (mode.plain, mode.hann))
        table.add_row(f"{mode.printed_hz} Hz", percent_text(mode.printed_damping, 3), line, plain, hann)
    return table


def _beams_table(found: PaperExplained) -> Table:
    table = Table("beam with", "number", "mode 1", "mode 2", "mode 3", "lines off at worst")
    for beam in found.explanations:
        number = "" if beam.best is None else f"{beam.best:.3g}"
        table.add_row(beam.name, number, *(f"{f:.2f} Hz" for f in beam.frequency_hz), f"{beam.worst_lines:.2f}")
    return table
