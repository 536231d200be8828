"""A run that was asked for and has not begun yet: who asked waits for its name, or for why there is none."""

from concurrent.futures import Future
from concurrent.futures import TimeoutError as NotYetError
from threading import Lock

from modallab.core.errors import ModallabError
from modallab.service.errors import RigUnavailableError
from modallab.service.rigs.control import StartRun


class RequestedRun:
    """An order, and whose it is. Nobody would know of a run that begins when its asker was answered that it did not."""

    def __init__(self, order: StartRun, operator: str) -> None:
        self.order = order
        self.operator = operator
        self.begun: Future[str] = Future()
        self.again = False
        """Whether the rig's process ended before it could begin, so that this is the second try."""
        self._lock = Lock()
        self._on_its_way = self._given_up = False

    def wait(self, patience_s: float) -> str:
        """The run's name, once it has begun.

        Raises:
            RigUnavailableError: it has not; if it is not being tried just now it will not be.
            ModallabError: what kept it from beginning.
        """
        try:
            return self.begun.result(patience_s)
        except NotYetError as error:
            with self._lock:
                self._given_up = not self._on_its_way
            raise RigUnavailableError(
                f"the run had not begun after {patience_s:g} s",
                where=self.order.rig,
                remedy="ask again when the rig is idle" if self._given_up else "look at the campaign's list of runs",
            ) from error

    def claim(self) -> bool:
        """Whether it is still requested; it is on its way then."""
        with self._lock:
            self._on_its_way = not self._given_up
            return self._on_its_way

    def put_back(self) -> None:
        """It could not be tried, and will be once more."""
        with self._lock:
            self._on_its_way, self.again = False, True

    def reject(self, error: ModallabError) -> None:
        """It cannot begin."""
        self.begun.set_exception(error)
