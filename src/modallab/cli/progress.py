"""How far a session at the bench is, on the terminal."""

from typing import Self

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeElapsedColumn

from modallab.core.documents.pages import EventView


class Display:
    """Progress bars, one a run, and what the operator should know."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._bars = Progress(
            TextColumn("{task.description:<28}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            console=console,
        )
        self._tasks: dict[str, TaskID] = {}
        self._said = set[str]()

    def notify(self, event: EventView) -> None:
        """Show an event."""
        said = event.content
        if event.kind == "progress":
            if event.run not in self._tasks:
                self._tasks[event.run] = self._bars.add_task(said["what"], total=said["total"])
            self._bars.update(self._tasks[event.run], completed=said["done"], description=said["what"])
        elif event.kind == "hit_rejected":
            self._say(f"  hit at point {said['point']} rejected: {said['reason']}")
        elif event.kind in ("notice", "failed") and said["what"] not in self._said:
            # What holds of several runs is said once.
            self._said.add(said["what"])
            self._say(f"  {said['what']}")

    def _say(self, text: str) -> None:
        self._console.print(text, markup=False, highlight=False)

    def __enter__(self) -> Self:
        self._bars.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bars.stop()
