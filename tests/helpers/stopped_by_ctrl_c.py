"""Runs a command of modallab and presses Ctrl-C, as a terminal does, at its n-th sign of progress: a script."""

import os
import signal
import sys
from collections.abc import Callable

from modallab.cli import console, main
from modallab.core.documents.pages import EventView
from modallab.core.progress import report_progress_to


def ctrl_c_at(nth: int) -> Callable[[], None]:
    """What is to be called at every sign of progress."""
    seen = 0

    def sign() -> None:
        nonlocal seen
        seen += 1
        if seen == nth:
            # A terminal sends it to all processes.
            os.killpg(0, signal.SIGINT)

    return sign


def pressed(nth: int, argv: list[str]) -> int:
    """Run the command; its exit code."""
    sign = ctrl_c_at(nth)
    shown = console.ProgressDisplay.notify

    def notify(display: console.ProgressDisplay, event: EventView) -> None:
        shown(display, event)
        if event.kind == "progress":
            sign()

    console.ProgressDisplay.notify = notify  # type: ignore[method-assign]
    with report_progress_to(lambda _share, _words: sign()):
        return main(argv)


if __name__ == "__main__":
    # A shell has what it runs in the background ignore Ctrl-C.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    sys.exit(pressed(int(sys.argv[1]), sys.argv[2:]))
