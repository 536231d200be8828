"""One campaign answered in a process of its own, with a limit on its processor seconds."""

import importlib
import math
import resource
import signal
import time
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

from corpus.campaigns import Entry
from corpus.made import made
from corpus.processes import context
from corpus.results import Row
from corpus.rows import row_of, truth_of
from modallab.core.errors import DataError

PATIENCE = 20.0
"""Times the limit after which a process is ended that uses no processor: by the clock, making the campaign included."""


def engine_of(path: str) -> Callable[..., Any]:
    """The function that an import path `module:function` names."""
    module, _, name = path.partition(":")
    return getattr(importlib.import_module(module), name)


def answered(entry: Entry, engine: str, limit_s: float) -> Row:
    """The row of a campaign; where there is no diagnosis, its verdict says `over limit` or `error`.

    Raises:
        DataError: the campaign cannot be made.
    """
    here, there = context().Pipe(duplex=False)
    process = context().Process(target=_answer, args=(there, entry, engine, limit_s), daemon=True)
    process.start()
    there.close()
    messages = _received(here, PATIENCE * limit_s)
    process.join(10.0)
    process.kill()
    process.join()
    if not messages or isinstance(messages[0], str):
        why = messages[0] if messages else f"its process ended with {process.exitcode}"
        raise DataError(
            f"could not be made: {why}", where=entry.id, remedy="see the folder or the seed of the campaign"
        )
    return messages[0] | (messages[1] if len(messages) > 1 else _ended(process.exitcode, limit_s))


def _received(here: Connection, patience_s: float) -> list[Any]:
    """What a process sends: the truth once the campaign is made, then the row."""
    found: list[Any] = []
    end = time.monotonic() + patience_s
    try:
        while len(found) < 2 and here.poll(max(end - time.monotonic(), 0.0)):
            found.append(here.recv())
    except EOFError:
        pass
    return found


def _ended(code: int | None, limit_s: float) -> Row:
    if code in (-signal.SIGXCPU, -signal.SIGKILL):
        return {"verdict": "over limit", "right": 0, "seconds": limit_s}
    return {"verdict": "error", "right": 0, "error": f"the process ended with {code}"}


def _answer(out: Connection, entry: Entry, engine: str, limit_s: float) -> None:
    try:
        function, given = engine_of(engine), made(entry)
    except Exception as error:
        out.send(f"{type(error).__name__}: {error}")
        return
    out.send(truth_of(entry, given))
    _limit(limit_s)
    begun = _processor_seconds()
    try:
        said = function(given.campaign, given.reference)
        out.send(row_of(entry, given, said, _processor_seconds() - begun))
    except Exception as error:
        seconds = round(_processor_seconds() - begun, 2)
        out.send({"verdict": "error", "right": 0, "seconds": seconds, "error": f"{type(error).__name__}: {error}"})


def _processor_seconds() -> float:
    """Of this process and of those it has begun and seen end."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def _limit(seconds: float) -> None:
    end = math.ceil(time.process_time() + seconds)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_CPU, (end, end + 10))
