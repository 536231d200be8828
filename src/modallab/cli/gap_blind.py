"""`modallab gap blind`: trials whose truth is sealed until all are answered."""

import argparse
import os
from collections.abc import Generator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context
from pathlib import Path
from typing import Any, cast

from pydantic import ValidationError
from rich.console import Console
from rich.table import Table

from modallab.blind.measured.draw import MeasuredRequest
from modallab.blind.measured.score import MeasuredOutcome
from modallab.blind.outcome import BlindOutcome
from modallab.blind.page import render
from modallab.blind.request import BlindRequest
from modallab.blind.run import blind_folder, run_blind_trials
from modallab.cli.options import require_option
from modallab.core.digits import percent_text, probability_text
from modallab.core.discovery import optional_package
from modallab.core.errors import PlanError
from modallab.core.field_errors import error_sentences
from modallab.core.progress import report_progress_to
from modallab.formats.atomic import write_text
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.formats.rig.rig_file import read_rig


def run(arguments: argparse.Namespace) -> int:
    """Make, seal, answer and open trials, or answer the campaigns of a folder."""
    if arguments.on is not None:
        return _run_on_frfs(arguments)
    require_option("--on", rig=arguments.rig, band=arguments.band)
    console, out, folder = Console(), cast("Path", arguments.out), cast("Path | None", arguments.folder)
    if folder is None:
        require_option("--folder", truth=arguments.truth)
    with (
        console.status("blind trials") as status,
        report_progress_to(lambda share, words: status.update(f"{share:.0%} {words}")),
        _pool(arguments) as pool,
    ):
        found = (
            run_blind_trials(out, _request(arguments), pool)
            if folder is None
            else blind_folder(folder, arguments.truth, out, pool)
        )
    if isinstance(found, str):
        console.print(f"answers written, no truth read: SHA-256 {found}", markup=False, soft_wrap=True)
        return 0
    write_text(out / "blind.json", found.model_dump_json(indent=1) + "\n")
    write_text(out / "blind.html", render(found))
    console.print(_table(found))
    console.print(f"written: {out / 'blind.json'}, {out / 'blind.html'}", markup=False, soft_wrap=True)
    return 0


def _run_on_frfs(arguments: argparse.Namespace) -> int:
    # Imported here: the other trials need no identification, which takes a second to load.
    from modallab.pipelines.structure_trials import trials_on

    console, out = Console(), cast("Path", arguments.out)
    rig = None if arguments.rig is None else read_rig(arguments.rig)
    none = arguments.none if arguments.none is not None else -(-arguments.trials // 4)
    with (
        console.status("blind trials") as status,
        report_progress_to(lambda share, words: status.update(f"{share:.0%} {words}")),
    ):
        found = trials_on(read_campaign(arguments.on, rig), out, _measured_request(arguments, none))
    write_text(out / "blind.json", found.model_dump_json(indent=1) + "\n")
    for table in tables_of(found):
        console.print(table)
    console.print(f"written: {out / 'blind.json'}", markup=False, soft_wrap=True)
    return 0


def _measured_request(arguments: argparse.Namespace, none: int) -> MeasuredRequest:
    band_hz = None if arguments.band is None else tuple(arguments.band)
    try:
        return MeasuredRequest(trials=arguments.trials, none=none, seed=arguments.seed, band_hz=band_hz)
    except ValidationError as error:
        raise PlanError(
            "; ".join(error_sentences(error)), remedy="correct the options of modallab gap blind"
        ) from error


def _request(arguments: argparse.Namespace) -> BlindRequest:
    effects = tuple(name for name in (arguments.effects or "").split(",") if name)
    none = arguments.none if arguments.none is not None else -(-arguments.trials // 4)
    try:
        return BlindRequest(
            trials=arguments.trials,
            none=none,
            pairs=arguments.pairs,
            seed=arguments.seed,
            effects=effects,
            tolerances=arguments.tolerances,
            later=not arguments.no_later,
        )
    except ValidationError as error:
        raise PlanError(
            "; ".join(error_sentences(error)), remedy="correct the options of modallab gap blind"
        ) from error


@contextmanager
def _pool(arguments: argparse.Namespace) -> Generator[Executor]:
    if arguments.scheduler is not None:
        distributed: Any = optional_package("distributed", "a Dask scheduler")
        with distributed.Client(arguments.scheduler) as client:
            yield client.get_executor(pure=False)
        return
    # Spawned, not forked: what diagnoses knows nothing of what the process that draws has in its memory.
    workers = arguments.workers or os.cpu_count() or 1
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        yield pool


def tables_of(found: MeasuredOutcome) -> tuple[Table, Table]:
    """The figures of semi-real trials, and the trials one by one."""
    shares = Table("figure", "share", "trials", title=f"{len(found.trials)} trials on {found.campaign}")
    for figure in found.figures:
        if figure.value is not None:
            shares.add_row(figure.name, percent_text(figure.value), str(figure.count))
    each = Table("true effect", "size, SI", "place", "diagnosed", "size, SI", "place", "probability")
    for t in found.trials:
        numbers = ("" if v is None else f"{v:.3g}" for v in (t.value, t.said_value))
        done, said = numbers
        each.add_row(
            t.effect,
            done,
            t.place,
            t.said,
            said,
            t.said_place,
            probability_text(t.probability) if t.probability else "",
        )
    return each, shares


def _table(found: BlindOutcome) -> Table:
    table = Table("figure", "value", "trials", title=f"{found.trials} trials")
    for figure in found.figures:
        if figure.value is not None:
            table.add_row(figure.name, f"{figure.value:.3g}", str(figure.count))
    table.add_row("calibration error of the probabilities", f"{found.calibration_error:.3g}", "")
    return table
