"""`modallab backup`, `restore` and `retention`: a data folder is copied, made again, or relieved of "
"old samples."""

import argparse
from datetime import timedelta
from pathlib import Path

from rich.console import Console

from modallab.core.errors import StorageError
from modallab.core.events import RunState
from modallab.jobs.table import METADATA as JOBS
from modallab.storage import Store
from modallab.storage.backup import CopiedData, back_up, restore_backup
from modallab.storage.campaigns import RetentionRule, find_removable, remove_samples
from modallab.storage.engine import ADDRESS, DATABASE


def run(arguments: argparse.Namespace) -> int:
    """Run the chosen one of the three."""
    return {"backup": _backup, "restore": _restore, "retention": _retention}[arguments.action](arguments)


def _backup(arguments: argparse.Namespace) -> int:
    require_data_folder(arguments.data)
    with Store(arguments.data) as store:
        _notify(back_up(store, arguments.out, [JOBS]), arguments.out)
    return 0


def _restore(arguments: argparse.Namespace) -> int:
    _notify(restore_backup(arguments.backup, arguments.out, arguments.database, [JOBS]), arguments.out)
    return 0


def _retention(arguments: argparse.Namespace) -> int:
    require_data_folder(arguments.data)
    days = arguments.older_than
    states: tuple[RunState, ...] = tuple(arguments.state or ("failed", "aborted"))
    rule = RetentionRule(timedelta(days=days), states, arguments.valid)
    console = Console()
    with Store(arguments.data) as store:
        found = find_removable(store, rule)
        for item in found:
            data = "valid" if item.run.valid else "invalid"
            line = f"{item.run.id}  {item.run.state}, {data}, {item.size / 1e6:.1f} MB"
            console.print(line, markup=False, highlight=False, soft_wrap=True)
        total = sum(item.size for item in found)
        if arguments.delete:
            remove_samples(store, found, f"retention: {', '.join(states)}, older than {days:g} days")
    done = "deleted" if arguments.delete else "deleted only with --delete"
    console.print(f"{len(found)} runs, {total / 1e6:.1f} MB: {done}", markup=False, highlight=False)
    return 0


def require_data_folder(folder: Path) -> None:
    """Reject what is no data folder: a store makes what it is given, and a command with a wrong one must not.

    Raises:
        StorageError: it is none.
    """
    if not ((folder / DATABASE).is_file() or (folder / ADDRESS).is_file()):
        raise StorageError(
            "is no data folder",
            where=str(folder),
            remedy=f"name a folder with {DATABASE} or {ADDRESS}; modallab serve and modallab campaign run make such "
            "a folder",
        )


def _notify(copied: CopiedData, out: Path) -> None:
    line = f"{copied.runs} runs, {copied.blocks} blocks, {copied.sample_bytes / 1e6:.1f} MB of samples: {out}"
    Console().print(line, markup=False, highlight=False, soft_wrap=True)
