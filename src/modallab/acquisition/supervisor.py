"""A process beside the rig's own, with a handle of its own to the output: it ends an excitation nobody answers for.

Some outputs go on when the process that drives them dies. The supervisor opens its handle before anything moves, and
then only waits: for the rig's process to die (the pipe between them breaks at once), for its sign of life to stay away
while a test is on, for the owner to die, or for an emergency stop.
"""

import multiprocessing
import signal
import time
from collections.abc import Callable
from multiprocessing.connection import Connection, wait
from threading import Lock
from typing import Literal

from modallab.backend.loader import has_output, open_output
from modallab.backend.protocol import OutputHandle
from modallab.errors import BenchError, ModallabError
from modallab.schema.rig import Rig

SILENCE_S = 1.0
"""A rig's process that is at work and says nothing for so long does not do its work."""

BEAT_S = 0.1
READY_S = 30.0
LEAVE_S = 5.0
TRIES = 3

Sign = Literal["working", "idle"]
Order = Literal["zero", "leave"]


class LifeLine:
    """The rig process's end: it says that it works, at most once in BEAT_S, and that it rests."""

    def __init__(self, connection: Connection | None) -> None:
        self._connection = connection
        self._said_s = 0.0

    def working(self) -> None:
        """A test is on, and all is well."""
        if time.monotonic() - self._said_s >= BEAT_S:
            self._said_s = time.monotonic()
            self._say("working")

    def idle(self) -> None:
        """No test is on: silence means nothing."""
        self._said_s = 0.0
        self._say("idle")

    def _say(self, sign: Sign) -> None:
        if self._connection is None:
            return
        try:
            self._connection.send(sign)
        except OSError:
            # Without a supervisor a burst still ends by itself, and a watchdog needs none.
            self._connection = None


class Supervisor:
    """The owner's end."""

    def __init__(self, url: str, rig: Rig) -> None:
        """Start the process, and wait until it has its handle.

        Raises:
            BenchError: the output cannot be had: then nothing should be driven either.
        """
        context = multiprocessing.get_context("spawn")
        watched, self.life_line = context.Pipe(duplex=False)
        self._connection, theirs = context.Pipe()
        self._sending = Lock()
        self.process = context.Process(
            target=supervise, args=(watched, theirs, url, rig), name=f"supervisor of {rig.name}", daemon=True
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
        self.process.join(LEAVE_S)
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


def start_supervisor(url: str, rig: Rig) -> Supervisor | None:
    """A supervisor for a bench whose output outlives its process and that the rig allows to drive.

    None where there is nothing to supervise, or no second way to the output: then a burst's own end, a watchdog and
    the owner are left, and an emergency stop goes through the rig's process.
    """
    if rig.shaker_point is None or not has_output(url):
        return None
    try:
        return Supervisor(url, rig)
    except ModallabError:
        return None


def supervise(watched: Connection, owner: Connection, url: str, rig: Rig) -> None:
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
    try:
        _watch(watched, owner, handle)
    finally:
        # The rig's process has left or died: nobody needs what it may still hold.
        _try(handle.release)
        handle.close()


def _watch(watched: Connection, owner: Connection, handle: OutputHandle) -> None:
    heard_s, working = time.monotonic(), False
    while True:
        ready = wait([watched, owner], timeout=BEAT_S)
        try:
            if watched in ready:
                working = watched.recv() == "working"
                heard_s = time.monotonic()
            if owner in ready:
                order: Order = owner.recv()
                if order == "leave":
                    return
                owner.send(_try(handle.zero))
        except (EOFError, OSError):
            # One of the two is gone; so is the reason to go on.
            return
        if working and time.monotonic() - heard_s > SILENCE_S:
            _try(handle.zero)
            working = False


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
