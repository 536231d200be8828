"""`modallab import`: recordings of others as one campaign file."""

import argparse
from collections import Counter
from pathlib import Path

from rich.table import Table

from modallab.cli.saying import console_of
from modallab.core.block import Block, Campaign
from modallab.core.errors import StorageError
from modallab.formats.campaign.campaign_hdf5 import campaign_file, write_campaign
from modallab.formats.importer import import_sources
from modallab.formats.options import ImportOptions
from modallab.formats.rig.rig_file import read_rig
from modallab.reporting.waiting import waiting


def run(arguments: argparse.Namespace) -> int:
    """Read all sources, write the campaign, print what it holds."""
    out: Path = arguments.out
    _reject_own_source(out, arguments.sources)
    options = ImportOptions(
        test=arguments.test, rate_hz=arguments.rate, drive_point=arguments.drive_point, volts=arguments.volts
    )
    with waiting("reading", progress=not arguments.hush):
        campaign = import_sources(arguments.sources, read_rig(arguments.rig), options)
    write_campaign(campaign, out)
    console = console_of(arguments)
    console.print(_contents(campaign))
    for note in campaign.provenance.get("notes", "").splitlines():
        console.print(f"note: {note}", markup=False, highlight=False)
    console.print(f"campaign: {out}", markup=False, highlight=False)
    return 0


def _reject_own_source(out: Path, sources: list[Path]) -> None:
    for source in sources:
        if out.exists() and source.exists() and campaign_file(source).samefile(out):
            raise StorageError(
                "is one of the sources and would be overwritten", where=str(out), remedy="give --out another name"
            )


def _contents(campaign: Campaign) -> Table:
    """One line for all blocks that are alike, one for each FRF matrix."""
    table = Table("blocks", "test", "channels", "rate Hz", "duration s", "units")
    for row, count in Counter(_row(block) for block in campaign.blocks).items():
        table.add_row(str(count), *row)
    for frf in campaign.frfs:
        outputs, inputs, lines = frf.values.shape
        span = f"{lines} lines, {frf.frequency_hz[0]:g} to {frf.frequency_hz[-1]:g} Hz"
        table.add_row("FRF", f"{inputs} inputs", f"{outputs}", span, "", frf.quantity)
    return table


def _row(block: Block) -> tuple[str, str, str, str, str]:
    units = {unit: [c for c, u in zip(block.channels, block.units, strict=True) if u == unit] for unit in block.units}
    named = [f"{unit} ({names[0] if len(names) == 1 else len(names)})" for unit, names in units.items()]
    return block.test, f"{len(block.channels)}", f"{block.rate_hz:g}", f"{block.duration_s:g}", ", ".join(named)
