"""Where processes come from: forked off one that has imported everything, so that none pays for it again."""

from functools import cache
from multiprocessing import get_context
from multiprocessing.context import ForkServerContext


@cache
def context() -> ForkServerContext:
    return get_context("forkserver")


def prepare(engine: str) -> None:
    """Import an engine once for all processes; call it before the first begins."""
    context().set_forkserver_preload(["corpus.answered", engine.partition(":")[0]])
