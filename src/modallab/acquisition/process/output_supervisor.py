"""A process beside the rig's own, with a handle of its own to the output: it ends an excitation nobody answers for.

Some outputs go on when the process that drives them dies. The supervisor opens its handle before anything moves, and
then only waits: for the rig's process to die (the pipe between them breaks at once), for its sign of life to stay away
while a test is on, for the owner to die, or for an emergency stop.
"""

import multiprocessing
import signal
import time
from collections.abc import Callable
from functools import partial
from multiprocessing.connection import Connection, wait
from pathlib import Path
from threading import Lock
from typing import Literal

from modallab.acquisition.process.trip import TripLatch
from modallab.bench.loader import has_output, open_output
from modallab.bench.protocol import OutputHandle
from modallab.core.errors import BenchError, ModallabError
from modallab.core.rig import Rig

TIMEOUT_S = 1.0
"""A rig's process that is at work and says nothing for so long does not do its work."""

DIED = "the acquisition process died while it drove"
TIMED_OUT = f"the acquisition process said nothing for {TIMEOUT_S:g} s while it drove"

BEAT_S = 0.1
READY_S = 30.0
LEAVE_S = 5.0
RELEASE_S = 20.0
"""To give back what a dead process held, on a busy machine; killed earlier, it would stay reserved."""
TRIES = 3

Sign = Literal["driving", "working", "idle"]
Order = Literal["zero", "leave"]


class LifeLine:
    """The rig process's end: it says that it works, at most once in BEAT_S, and that it rests."""

    def __init__(self, connection: Connection | None) -> None:
        self._connection = connection
        self._said_s = 0.0
        self._sign: Sign = "idle"

    def working(self, *, driving: bool) -> None:
        """A test is on, with or without a burst, and all is well."""
        sign: Sign = "driving" if driving else "working"
        if sign != self._sign or time.monotonic() - self._said_s >= BEAT_S:
            self._said_s = time.monotonic()
            self._say(sign)

    def idle(self) -> None:
        """No test is on: a missing sign of life means nothing."""
        self._said_s = 0.0
        self._say("idle")

    def _say(self, sign: Sign) -> None:
        self._sign = sign
        if self._connection is None:
            return
        try:
            self._connection.send(sign)
        except OSError:
            # Without a supervisor a burst still ends by itself, and a watchdog needs none.
            self._connection = None


class Supervisor:
    """The owner's end."""

    def __init__(self, url: str, rig: Rig, data_folder: Path) -> None:
        """Start the process, and wait until it has its handle; the latch it trips is in `data_folder`.

        Raises:
            BenchError: the output cannot be had: then nothing should be driven either.
        """
        context = multiprocessing.get_context("spawn")
        watched, self.life_line = context.Pipe(duplex=False)
        self._connection, theirs = context.Pipe()
        self._sending = Lock()
        self.process = context.Process(
            target=supervise,
            args=(watched, theirs, url, rig, data_folder),
            name=f"supervisor of {rig.name}",
            daemon=True,
        )
        self.process.start()
        # Only the other processes may hold these ends, or their deaths would not be heard.
        watched.close()
        theirs.close()
        self._expect_ready()

    def zero(self) -> None:
        """Emergency stop: bring the output to 0 V, whatever the rig's process does.

        Raises:
            BenchError: the supervisor is gone, or could not do it.
        """
        with self._sending:
            try:
                self._connection.send("zero")
                answer = self._connection.recv() if self._connection.poll(LEAVE_S) else BenchError("no answer")
            except (EOFError, OSError) as error:
                raise _gone() from error
        if isinstance(answer, ModallabError):
            raise answer

    def close(self) -> None:
        """Let it bring the output to 0 V once more and leave."""
        self.life_line.close()
        try:
            with self._sending:
                self._connection.send("leave")
        except OSError:
            pass
        self.process.join(RELEASE_S)
        if self.process.is_alive():
            self.process.kill()
            self.process.join()
        self._connection.close()

    def handed_over(self) -> None:
        """The rig's process has its end of the life line: this copy must go, or its death would not be heard."""
        self.life_line.close()

    def _expect_ready(self) -> None:
        try:
            answer = self._connection.recv() if self._connection.poll(READY_S) else BenchError("no answer")
        except (EOFError, OSError) as error:
            raise _gone() from error
        if isinstance(answer, ModallabError):
            self.process.join(LEAVE_S)
            raise answer


def start_supervisor(url: str, rig: Rig, data_folder: Path) -> tuple[Supervisor | None, str]:
    """A supervisor for a bench whose output outlives its process and that the rig allows to drive, and what to say.

    Without one only what is finite is relied on: a burst's own end and a watchdog where there is one. The second value
    says so, in words for the operator, before anything is driven.
    """
    if rig.shaker_point is None or not has_output(url):
        return None, "the output ends with the process that drives it"
    try:
        return Supervisor(url, rig, data_folder), "a supervisor holds a handle of its own to the output"
    except ModallabError as error:
        watchdog = rig.excitation.watchdog_s if rig.excitation is not None else None
        left = f"the device's watchdog ({watchdog:g} s)" if watchdog else "the burst's own end"
        return None, f"there is NO supervisor ({error.what}): should the acquisition die, only {left} ends the output"


def supervise(watched: Connection, owner: Connection, url: str, rig: Rig, data_folder: Path) -> None:
    """What runs in the supervisor's process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        handle = open_output(url, rig)
    except ModallabError as error:
        owner.send(error)
        return
    if handle is None:
        owner.send(BenchError(f"{url} has no output to supervise"))
        return
    owner.send("ready")
    cause = None
    try:
        cause = _watch(watched, owner, handle, TripLatch(data_folder, url))
    finally:
        # The rig's process has left or died: nobody needs what it may still hold. To end the output comes first.
        _try(handle.release)
        if cause is not None:
            _try(cause)
        handle.close()


def _watch(watched: Connection, owner: Connection, handle: OutputHandle, latch: TripLatch) -> Callable[[], None] | None:
    """Wait until one of the two is gone, or asked to leave; returns what is left to do once the output is at 0 V."""
    heard_s = time.monotonic()
    sign: Sign = "idle"
    while True:
        ready = wait([watched, owner], timeout=BEAT_S)
        try:
            if watched in ready:
                sign = watched.recv()
                heard_s = time.monotonic()
        except (EOFError, OSError):
            return partial(latch.trip, "death", DIED) if sign == "driving" else None
        try:
            if owner in ready:
                order: Order = owner.recv()
                if order == "leave":
                    return None
                owner.send(_try(handle.zero))
        except (EOFError, OSError):
            # The rig's process hears of it too, and ends its run in good order.
            return None
        if sign != "idle" and time.monotonic() - heard_s > TIMEOUT_S:
            _try(handle.zero)
            if sign == "driving":
                _try(partial(latch.trip, "time-out", TIMED_OUT))
            sign = "idle"


def _try(call: Callable[[], None]) -> ModallabError | None:
    failed: ModallabError | None = None
    for _ in range(TRIES):
        try:
            call()
        except ModallabError as error:
            failed = error
        else:
            return None
    return failed


def _gone() -> BenchError:
    return BenchError(
        "the supervisor of the output is gone",
        remedy="switch the amplifier off; a burst that is on ends by itself within the rig's max_burst_s",
    )
