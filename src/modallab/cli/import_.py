"""`modallab import`: recordings of others as one campaign file."""

import argparse
from collections import Counter
from pathlib import Path

from rich.table import Table

from modallab.cli.console import console_of
from modallab.core.block import Block, Campaign
from modallab.formats.arrays.array_map import read_map
from modallab.formats.asked import ASKED
from modallab.formats.campaign.campaign_hdf5 import write_campaign
from modallab.formats.draft import assumptions, write_draft
from modallab.formats.importer import import_recordings
from modallab.formats.rig.rig_file import read_rig
from modallab.pipelines.results import holds_results_only, import_results
from modallab.reporting.waiting_line import waiting_line


def run(arguments: argparse.Namespace) -> int:
    """Read all sources, write the campaign, print what it holds."""
    arguments.sources = [file for source in arguments.sources for file in _files_of_pattern(source)]
    out: Path = arguments.out
    said = {name: getattr(arguments, one.called or name) for name, one in ASKED.items()}
    said["array_map"] = None if arguments.map is None else read_map(arguments.map)
    console = console_of(arguments)
    if arguments.rig is None and holds_results_only(arguments.sources[0]):
        for line in import_results(arguments.sources[0], out):
            console.print(line, markup=False, highlight=False)
        return 0
    with waiting_line("reading", progress=not arguments.hush):
        known = None if arguments.rig is None else read_rig(arguments.rig)
        campaign = import_recordings(arguments.sources, known, said)
    write_campaign(campaign, out)
    console.print(_contents_table(campaign))
    for note in campaign.provenance.get("notes", "").splitlines():
        console.print(f"note: {note}", markup=False, highlight=False)
    console.print(f"campaign: {out}", markup=False, highlight=False)
    if arguments.rig is None:
        drafted, notes = out.with_suffix(".rig.yaml"), assumptions(campaign.rig)
        write_draft(campaign.rig, drafted, notes)
        for note in notes:
            console.print(f"note: {note}", markup=False, highlight=False)
        console.print(f"rig: {drafted}, to be completed", markup=False, highlight=False)
    return 0


def _files_of_pattern(source: Path) -> list[Path]:
    """What a pattern stands for: the command prompt of Windows hands it on as it was typed."""
    if source.exists() or not any(mark in source.name for mark in "*?"):
        return [source]
    return sorted(source.parent.glob(source.name)) or [source]


def _contents_table(campaign: Campaign) -> Table:
    """One line for all blocks that are alike, one for each FRF matrix."""
    table = Table("blocks", "test", "channels", "rate Hz", "duration s", "units")
    for row, count in Counter(_contents_row(block) for block in campaign.blocks).items():
        table.add_row(str(count), *row)
    for frf in campaign.frfs:
        outputs, inputs, lines = frf.values.shape
        span = f"{lines} lines, {frf.frequency_hz[0]:g} to {frf.frequency_hz[-1]:g} Hz"
        table.add_row("FRF", f"{inputs} inputs", f"{outputs}", span, "", frf.quantity)
    return table


def _contents_row(block: Block) -> tuple[str, str, str, str, str]:
    units = {unit: [c for c, u in zip(block.channels, block.units, strict=True) if u == unit] for unit in block.units}
    named = [f"{unit} ({names[0] if len(names) == 1 else len(names)})" for unit, names in units.items()]
    return block.test, f"{len(block.channels)}", f"{block.rate_hz:g}", f"{block.duration_s:g}", ", ".join(named)
