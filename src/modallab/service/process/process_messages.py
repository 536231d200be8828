"""Commands between the REST process and the supervisor: calls one way, answers the other, and a sign of life."""

import logging
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from multiprocessing.connection import Connection
from queue import Full, Queue
from threading import Event as Flag
from threading import Lock, Thread
from typing import Any

from modallab.core.errors import ModallabError
from modallab.service.errors import RigUnavailableError
from modallab.service.rigs.control import RigControl

LOG = logging.getLogger(__name__)
BEAT_S = 0.2
ANSWER_S = 30.0
CALLS = frozenset(name for name in vars(RigControl) if not name.startswith("_"))
"""What the REST process may have done."""


@dataclass(frozen=True, slots=True)
class ControlCall:
    """Do something; the answer carries the same number."""

    number: int
    name: str
    arguments: tuple[Any, ...]


@dataclass(frozen=True, slots=True)
class ControlAnswer:
    """What came of a call."""

    number: int
    value: Any = None
    error: ModallabError | None = None


@dataclass(frozen=True, slots=True)
class ProcessHeartbeat:
    """The REST process lives."""


@dataclass(frozen=True, slots=True)
class NewEvents:
    """There is something new in the log of events."""


class RemoteControl:
    """The REST process's end: its calls are those of `Control`, and their work is done in the supervisor."""

    def __init__(self, connection: Connection, gone: Callable[[], None]) -> None:
        """`gone` is called when the supervisor is."""
        self._connection = connection
        self._gone = gone
        self._sending = Lock()
        self._waiting: dict[int, Future[Any]] = {}
        self._number = 0
        self._lost = Flag()
        self.on_events: Callable[[], None] = _ignore
        Thread(target=self._hear, name="answers", daemon=True).start()
        Thread(target=self._beat, name="heartbeat", daemon=True).start()

    def __getattr__(self, name: str) -> Callable[..., Any]:
        """A call of `Control`, which is done in the supervisor."""
        if name not in CALLS:
            raise AttributeError(f"Control has no call {name!r}")
        return partial(self._call, name)

    def _call(self, name: str, *arguments: Any) -> Any:
        future: Future[Any] = Future()
        with self._sending:
            self._number += 1
            number = self._number
            self._waiting[number] = future
            try:
                self._connection.send(ControlCall(number, name, arguments))
            except OSError as error:
                raise _no_supervisor() from error
        try:
            return future.result(ANSWER_S)
        except TimeoutError as error:
            raise _no_supervisor() from error
        finally:
            self._waiting.pop(number, None)

    def _hear(self) -> None:
        try:
            while True:
                answer: ControlAnswer | NewEvents | None = self._connection.recv()
                if answer is None:
                    break
                if isinstance(answer, NewEvents):
                    self.on_events()
                    continue
                future = self._waiting.get(answer.number)
                if future is None:
                    continue
                if answer.error is not None:
                    future.set_exception(answer.error)
                else:
                    future.set_result(answer.value)
        except (EOFError, OSError):
            pass
        self._lost.set()
        for future in list(self._waiting.values()):
            future.set_exception(_no_supervisor())
        self._gone()

    def _beat(self) -> None:
        while not self._lost.wait(BEAT_S):
            try:
                with self._sending:
                    self._connection.send(ProcessHeartbeat())
            except OSError:
                return


class CallServer:
    """The supervisor's end: hears calls, has each done on a thread of its own, knows when it last heard anything."""

    def __init__(self, connection: Connection, control: RigControl) -> None:
        self._connection = connection
        self._control = control
        self._sending = Lock()
        self.received_s = time.monotonic()
        self.began = False
        self._gone_s: float | None = None
        self._new: Queue[NewEvents | None] = Queue(1)
        self._pool = ThreadPoolExecutor(max_workers=16, thread_name_prefix="call")
        for work in (self._hear, self._notify):
            Thread(target=work, name="calls", daemon=True).start()

    def _hear(self) -> None:
        try:
            while True:
                message: ControlCall | ProcessHeartbeat = self._connection.recv()
                self.received_s = time.monotonic()
                self.began = True
                if isinstance(message, ControlCall):
                    self._pool.submit(self._do, message)
        except (EOFError, OSError):
            self._gone_s = time.monotonic()
            self._pool.shutdown(wait=False)
            with suppress(Full):
                self._new.put_nowait(None)

    def new_events(self) -> None:
        """Say that there is something new in the log; who says so waits for nobody."""
        if self._gone_s is None and self.began:
            # One that waits already says all there is to say.
            with suppress(Full):
                self._new.put_nowait(NewEvents())

    def _notify(self) -> None:
        # A REST process that is frozen reads nothing, and the run that is on must not stand still with it.
        with suppress(OSError):
            while self._gone_s is None and (new := self._new.get()) is not None:
                with self._sending:
                    self._connection.send(new)

    @property
    def since_received_s(self) -> float:
        """Since it was heard last."""
        return time.monotonic() - self.received_s

    @property
    def end_message(self) -> str:
        """What is to be said of it once it has ended; before, ""."""
        gone_s = self._gone_s
        return "" if gone_s is None else f"the REST process has been gone for {time.monotonic() - gone_s:.1f} s"

    def _do(self, call: ControlCall) -> None:
        try:
            if call.name not in CALLS:
                raise ModallabError(f"there is no call {call.name!r}")
            answer = ControlAnswer(call.number, getattr(self._control, call.name)(*call.arguments))
        except ModallabError as error:
            answer = ControlAnswer(call.number, error=error)
        except Exception as error:
            LOG.exception("call %s", call.name)
            answer = ControlAnswer(call.number, error=ModallabError(f"unexpected {type(error).__name__}: {error}"))
        try:
            with self._sending:
                self._connection.send(answer)
        except OSError:
            return


def _ignore() -> None:
    """Nobody waits for events."""


def _no_supervisor() -> RigUnavailableError:
    return RigUnavailableError("the supervisor does not answer", remedy="look at the service's log")
