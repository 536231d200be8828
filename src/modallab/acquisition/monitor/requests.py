"""What an owner may want of a running test besides its end: pause, once more, drop, accept."""

from dataclasses import dataclass
from queue import Empty, SimpleQueue
from threading import Event as Flag

from modallab.core.documents.runs import Repeat


@dataclass(frozen=True, slots=True)
class DropBlock:
    """A block no longer counts; in an impact test the hit is asked for again.

    The run knows its blocks by the names of their records, and not by the numbers that an operator's `Drop` carries.
    """

    block: str
    reason: str = "dropped by the operator"


@dataclass(frozen=True, slots=True)
class AcceptBlock:
    """A rejected hit counts all the same; it is not asked for again."""

    block: str
    reason: str = "accepted at the bench"
    operator: str = ""


Request = Repeat | DropBlock | AcceptBlock


@dataclass(slots=True)
class Excitation:
    """Whether a burst may be on, as the test says it: no sign of life then means more than at rest."""

    on: bool = False


class Requests:
    """Filled by the thread that hears the owner, looked at by the test between blocks or bursts."""

    def __init__(self) -> None:
        self._paused = Flag()
        self._requests: SimpleQueue[Request] = SimpleQueue()

    @property
    def paused(self) -> bool:
        """Whether the test should pause."""
        return self._paused.is_set()

    def pause(self) -> None:
        """From the next boundary on, do nothing but watch."""
        self._paused.set()

    def resume(self) -> None:
        """Go on."""
        self._paused.clear()

    def ask(self, request: Request) -> None:
        """Queue a request."""
        self._requests.put(request)

    def take(self) -> list[Request]:
        """The requests since the last look, in order."""
        found: list[Request] = []
        while True:
            try:
                found.append(self._requests.get_nowait())
            except Empty:
                return found

    def forget(self) -> None:
        """A new run begins: what was requested of the last one is no request of this one."""
        self.resume()
        self.take()
