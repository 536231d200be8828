"""The part of the client that concerns the queue of a rig."""

from collections.abc import Sequence

from modallab.client.connection import Connection, RenewedLease
from modallab.core.documents.queue import ConsentNew, QueueItem, QueueItemNew, QueueOrder, QueueReason, QueueView
from modallab.core.plan import Plan


class QueueCalls(Connection):
    """Runs that wait for others."""

    def queue(self, rig: str, *, ended: bool = False) -> QueueView:
        """What goes on and what waits at a rig; with `ended` what has ended too."""
        return self._get(QueueView, f"/rigs/{rig}/queue", {"ended": "true"} if ended else {})

    def queue_run(self, rig: str, campaign: str, plan: Plan, note: str = "") -> QueueItem:
        """Queue a run behind the others; needs no lease."""
        return self._post(QueueItem, f"/rigs/{rig}/queue", QueueItemNew(campaign=campaign, plan=plan, note=note))

    def reorder_queue(self, rig: str, items: Sequence[str]) -> QueueView:
        """Have all that waits run in this order."""
        return self._put(QueueView, f"/rigs/{rig}/queue/order", QueueOrder(items=tuple(items)))

    def skip_queued(self, rig: str, item: str, reason: str = "") -> QueueItem:
        """Take an item out that waits."""
        return self._post(QueueItem, f"/rigs/{rig}/queue/{item}/skip", QueueReason(reason=reason))

    def pause_queue(self, rig: str, reason: str = "") -> QueueView:
        """Have nothing begin; a run that is on goes on."""
        return self._post(QueueView, f"/rigs/{rig}/queue/pause", QueueReason(reason=reason))

    def resume_queue(self, rig: str, lease: RenewedLease) -> QueueView:
        """Let it go on."""
        return self._post(QueueView, f"/rigs/{rig}/queue/resume", None, lease)

    def consent(self, rig: str, lease: RenewedLease, *, drive: bool = False, at_bench: bool = False) -> QueueView:
        """Let what waits now begin by itself: with `drive` tests that move the output, with `at_bench` impact tests."""
        new = ConsentNew(drive=drive, at_bench=at_bench)
        return self._put(QueueView, f"/rigs/{rig}/queue/consent", new, lease)

    def withdraw_consent(self, rig: str) -> QueueView:
        """Let nothing begin by itself."""
        return self._delete(QueueView, f"/rigs/{rig}/queue/consent")
