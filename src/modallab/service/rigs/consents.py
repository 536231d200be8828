"""What may begin by itself: only in memory, so that no crash of whatever leaves a consent behind."""

import time
from dataclasses import dataclass
from threading import Lock

from modallab.core.documents.queue import ConsentRequest, ConsentView
from modallab.core.documents.rigs import Lease


@dataclass(frozen=True, slots=True)
class Consent:
    """A lease-holder's word.

    Attributes:
        lease: id of the lease it was given under.
        operator: name of the operator.
        drive: whether tests that move the output may start.
        at_bench: whether impact tests may start.
        items: items of the queue that it covers.
        process: the rig's process when it was given.
        until_s: by the monotonic clock.
    """

    lease: str
    operator: str
    drive: bool
    at_bench: bool
    items: frozenset[str]
    process: int | None
    until_s: float

    @property
    def remaining_s(self) -> float:
        """For so long, if nothing ends it."""
        return self.until_s - time.monotonic()

    @property
    def view(self) -> ConsentView:
        """For whoever asks."""
        items = tuple(sorted(self.items))
        return ConsentView(
            operator=self.operator,
            drive=self.drive,
            at_bench=self.at_bench,
            items=items,
            remaining_s=self.remaining_s,
        )


class RigConsents:
    """Those of all rigs, and the rigs that were stopped in an emergency. From any thread; waits for nothing."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._given: dict[str, Consent] = {}
        self._stopped: set[str] = set()

    def give(self, rig: str, new: ConsentRequest, items: frozenset[str], lease: Lease, process: int | None) -> Consent:
        """Keep one; it takes the place of an earlier one."""
        until_s = time.monotonic() + new.for_s
        consent = Consent(lease.id, lease.operator, new.drive, new.at_bench, items, process, until_s)
        with self._lock:
            self._given[rig] = consent
        return consent

    def get(self, rig: str) -> Consent | None:
        """The one of a rig; None if there is none, or its time is over."""
        with self._lock:
            consent = self._given.get(rig)
        return None if consent is None or consent.remaining_s <= 0 else consent

    def withdraw(self, rig: str) -> None:
        """From now on nothing begins by itself."""
        with self._lock:
            self._given.pop(rig, None)

    def stop(self, rig: str) -> None:
        """The rig is stopped in an emergency."""
        with self._lock:
            self._given.pop(rig, None)
            self._stopped.add(rig)

    def take_stopped(self) -> set[str]:
        """The rigs that were stopped since the last look."""
        with self._lock:
            stopped, self._stopped = self._stopped, set()
        return stopped
