"""A process beside the rig's own, with a handle of its own to the output: how it is started, asked and ended."""

import multiprocessing
import os
import pickle
import time
from multiprocessing.connection import Connection
from pathlib import Path
from threading import Lock

from modallab.acquisition.process.output_watch import BEAT_S, Sign
from modallab.bench.loader import has_output, open_output
from modallab.core.child_process import start_child_process
from modallab.core.errors import BenchError, ModallabError
from modallab.core.rig import Rig

SUPERVISE = "modallab.acquisition.process.output_watch:supervise_output"
READY_S = 30.0
LEAVE_S = 5.0
RELEASE_S = 20.0
"""To give back what a dead process held, on a busy machine; killed earlier, it would stay reserved."""
OWNERLESS_S = 30.0
"""From its owner's death on; longer than the rig's process, which it watches, and the release of what that held."""


class HeartbeatPipe:
    """The rig process's end: it says that it works, at most once in BEAT_S, and that it rests."""

    def __init__(self, connection: Connection | None) -> None:
        self._connection = connection
        self._said_s = 0.0
        self._sign: Sign = "idle"
        self._send(os.getpid())

    def report_running(self, *, driving: bool) -> None:
        """A test is on, with or without a burst, and all is well."""
        sign: Sign = "driving" if driving else "working"
        if sign != self._sign or time.monotonic() - self._said_s >= BEAT_S:
            self._said_s = time.monotonic()
            self._say(sign)

    def report_idle(self) -> None:
        """No test is on: no sign of life means nothing."""
        self._said_s = 0.0
        self._say("idle")

    def _say(self, sign: Sign) -> None:
        self._sign = sign
        self._send(sign)

    def _send(self, message: Sign | int) -> None:
        if self._connection is None:
            return
        try:
            self._connection.send(message)
        except OSError:
            # Without a supervisor a burst still ends by itself, and a watchdog needs none.
            self._connection = None


class OutputSupervisor:
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
        self.process, self._life = start_child_process(
            f"supervisor of {rig.name}",
            SUPERVISE,
            (watched, theirs),
            pickle.dumps((url, rig, data_folder)),
            grace_s=OWNERLESS_S,
            daemon=True,
        )
        # Only the other processes may hold these ends, or their deaths would not be heard.
        watched.close()
        theirs.close()
        self._expect_ready()

    def zero_output(self) -> None:
        """Emergency stop: bring the output to 0 V, whatever the rig's process does.

        Raises:
            BenchError: the supervisor is gone, or could not do it.
        """
        with self._sending:
            try:
                self._connection.send("zero")
                answer = self._connection.recv() if self._connection.poll(LEAVE_S) else BenchError("no answer")
            except (EOFError, OSError) as error:
                raise _output_lost_error() from error
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

    def close_own_copy(self) -> None:
        """The rig's process has its end of the life line: this copy must go, or its death would not be heard."""
        self.life_line.close()

    def _expect_ready(self) -> None:
        try:
            answer = self._connection.recv() if self._connection.poll(READY_S) else BenchError("no answer")
        except (EOFError, OSError) as error:
            raise _output_lost_error() from error
        if isinstance(answer, ModallabError):
            self.process.join(LEAVE_S)
            raise answer


def start_supervisor(url: str, rig: Rig, data_folder: Path) -> tuple[OutputSupervisor | None, str]:
    """A supervisor for a bench whose output outlives its process and that the rig allows to drive, and what to say.

    Without one only what is finite is relied on: a burst's own end and a watchdog where there is one. The second value
    says so, in words for the operator, before anything is driven.
    """
    if rig.shaker_point is None or not has_output(url):
        return None, "the output ends with the process that drives it"
    try:
        return OutputSupervisor(url, rig, data_folder), "a supervisor has its own handle to the output"
    except ModallabError as error:
        watchdog = rig.excitation.watchdog_s if rig.excitation is not None else None
        left = (
            f"the device's watchdog ({watchdog:g} s)" if watchdog else "the burst's own end, where there is a server,"
        )
        return None, f"there is NO supervisor ({error.what}): if the acquisition dies, only {left} ends the output"


def _output_lost_error() -> BenchError:
    return BenchError(
        "the supervisor of the output has ended",
        remedy="switch the amplifier off; an active burst ends within the rig's max_burst_s",
    )


def zero_output_of_dead_process(url: str, rig: Rig) -> str:
    """Bring the output to 0 V when the process that drove it is dead; what came of it, for the end of a sentence.

    Empty where no output outlives its process.
    """
    try:
        output = open_output(url, rig)
        if output is None:
            return ""
        try:
            output.zero()
        finally:
            output.close()
    except Exception as error:
        return f"; the output could not be brought to 0 V from here, switch the amplifier off: {error}"
    return "; the output was brought to 0 V from outside"
