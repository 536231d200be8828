"""Questions to a scheduler, given up the moment it is known to be gone."""

import asyncio
import time
from collections.abc import Callable, Coroutine
from concurrent.futures import TimeoutError as NotYetError
from typing import Any

from distributed import Client

LOOK_S = 0.1
ASK_S = 60.0
"""A busy machine was never seen to need a third of it for an answer; a scheduler that is frozen needs for ever."""


class SchedulerLostError(ConnectionError):
    """The scheduler did not answer, and will not."""


def ask(
    client: Client, question: Coroutine[Any, Any, Any], alive: Callable[[], bool], patience_s: float = ASK_S
) -> Any:
    """The answer to `question`, which is asked by the client's own loop.

    Dask itself would go on knocking for ten seconds at the door of a scheduler whose process has ended.

    Raises:
        SchedulerLostError: `alive` says so meanwhile, or there was no answer for `patience_s`.
        OSError: the connection broke.
    """
    # Its types do not say which loop it runs on.
    loop: Any = client.loop
    asked = asyncio.run_coroutine_threadsafe(question, loop.asyncio_loop)
    end = time.monotonic() + patience_s
    try:
        while not asked.done():
            if not alive():
                raise SchedulerLostError("the scheduler ended while it was asked")
            if time.monotonic() > end:
                raise SchedulerLostError(f"the scheduler has not answered for {patience_s:g} s")
            try:
                return asked.result(LOOK_S)
            except NotYetError:
                continue
        return asked.result()
    finally:
        asked.cancel()
