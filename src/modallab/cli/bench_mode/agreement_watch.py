"""Compares what a run has recorded with the simulation, while the next record is made."""

from collections.abc import Callable
from threading import Condition, Thread

import numpy as np

from modallab.core.block import Campaign
from modallab.core.errors import ModallabError

LEAVE_S = 5.0
"""How long a comparison that is on may take once the session ends."""


class AgreementWatch:
    """Compares the latest records of a run each time it is notified; a request replaces one that waits."""

    def __init__(self, recorded: Callable[[str], Campaign], show: Callable[[str], None]) -> None:
        """Begin to wait for requests.

        Args:
            recorded: what a run has recorded so far.
            show: takes the sentence of each comparison, in a thread of its own.
        """
        self._recorded, self._show = recorded, show
        self._requested: str | None = None
        self._closed = False
        self._changed = Condition()
        self._thread = Thread(target=self._compare_all, name="agreement", daemon=True)
        self._thread.start()

    def request(self, run: str) -> None:
        """Compare this run with the simulation, as soon as the comparison before is done."""
        with self._changed:
            self._requested = run
            self._changed.notify()

    def close(self) -> None:
        """Begin no other comparison, and wait for the one that is on."""
        with self._changed:
            self._closed = True
            self._changed.notify()
        self._thread.join(LEAVE_S)

    def _compare_all(self) -> None:
        while (run := self._next()) is not None:
            self._compare(run)

    def _next(self) -> str | None:
        with self._changed:
            self._changed.wait_for(lambda: self._closed or self._requested is not None)
            run, self._requested = self._requested, None
            return None if self._closed else run

    def _compare(self, run: str) -> None:
        from modallab.gap.inference.agreement import agreement, latest

        try:
            self._show(agreement(latest(self._recorded(run))).sentence)
        except (ModallabError, np.linalg.LinAlgError):
            # Too little is recorded yet, or a record shows no mode: the next one is compared.
            return
