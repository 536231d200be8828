"""What all workers import is compiled by the first of them: where all begin at once, each compiles most of it."""

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

COMPILED_S = 120.0
"""A first worker that takes longer is not waited for: it may have died."""


@contextmanager
def compiled_once(config: pytest.Config) -> Iterator[None]:
    """Imports of the first worker first, then those of all others."""
    worker = os.environ.get("PYTEST_XDIST_WORKER")
    if worker is None:
        yield
        return
    done = Path(config.getoption("basetemp")).parent / "compiled"
    end = time.monotonic() + COMPILED_S
    while worker != "gw0" and not done.exists() and time.monotonic() < end:
        time.sleep(0.1)
    try:
        yield
    finally:
        done.touch()
