"""What keeps a queued run from beginning: looked at before it begins, and shown to whoever waits for it."""

from modallab.acquisition.process.trip import Trip
from modallab.core.documents.queue import ConsentView, QueueItem
from modallab.service.rigs.control import ControllerState


def why_not_begun(item: QueueItem, state: ControllerState, trip: Trip | None, consent: ConsentView | None) -> str:
    """Why an item cannot begin now; "" if it can.

    A shaker never starts by itself unless who holds the lease has consented to this very item, and an impact test waits
    until he says that he is at the bench.
    """
    if trip is not None:
        return f"the rig is tripped: {trip.what}; look at the bench, and reset it"
    if state.state != "idle":
        return f"run {state.run} is on" if state.run else f"the rig is {state.state}"
    if consent is None:
        return f"nobody who holds the lease has consented to it{_unless_consented(item)}"
    if item.id not in consent.items:
        return f"{consent.operator}'s consent was given before it was queued{_unless_consented(item)}"
    if item.drives and not consent.drive:
        return f"{consent.operator} has not consented to tests that move the output"
    if not item.drives and not consent.at_bench:
        return f"{consent.operator} has not said that he is at the bench, and the test needs its operator"
    return ""


def _unless_consented(item: QueueItem) -> str:
    need = "tests that drive" if item.drives else "impact tests, at the bench"
    return f"; give one for {need}, with the lease"
