"""What a child process does that hears nothing."""

import time
from multiprocessing.connection import Connection


def sleep(_connection: Connection, seconds: float) -> None:
    time.sleep(seconds)
