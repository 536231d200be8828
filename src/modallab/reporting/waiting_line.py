"""What a long computation is at and how far, shown to whoever waits for it: on standard error, never in the result."""

import sys
from collections.abc import Generator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from modallab.core.progress import report_progress_to


@contextmanager
def waiting_line(what: str, *, progress: bool = True) -> Generator[None]:
    """While this lasts, a line says what is being computed, how far it is, and for how long.

    Nothing is shown where nobody looks: into a file or a pipe, or without `progress`.

    Args:
        what: said until the computation itself says more.
        progress: False to show nothing.
    """
    console = Console(file=sys.stderr)
    if not progress or not (console.is_terminal or console.is_jupyter):
        yield
        return
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:3.0f} %"),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=console, transient=True) as bars:
        task = bars.add_task(what, total=1.0)
        with report_progress_to(lambda share, words: bars.update(task, completed=share, description=words or what)):
            yield
