"""A scheduler and workers as processes of their own, as they would run on other machines."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

HERE = str(Path(__file__).parent)


class Machines:
    """Starts Dask's own commands on the loopback, and ends all that it started."""

    def __init__(self, folder: Path, tls: Sequence[str] = ()) -> None:
        self._folder = folder
        self._tls = list(tls)
        self._all: list[subprocess.Popen[bytes]] = []
        self.address = ""

    def scheduler(self, port: int = 0) -> subprocess.Popen[bytes]:
        file = self._folder / f"scheduler-{len(self._all)}.json"
        options = ["--port", str(port), "--scheduler-file", str(file), "--no-dashboard"]
        if self._tls:
            options += ["--protocol", "tls"]
        process = self._start("dask_scheduler", "--host", "127.0.0.1", *options)
        deadline = time.monotonic() + 60
        while not file.exists() or not file.read_text():
            assert process.poll() is None
            assert time.monotonic() < deadline
            time.sleep(0.05)
        self.address = json.loads(file.read_text())["address"]
        return process

    def worker(self) -> subprocess.Popen[bytes]:
        options = ["--nthreads", "1", "--no-nanny", "--no-dashboard", "--host", "127.0.0.1"]
        return self._start("dask_worker", self.address, *options, "--local-directory", str(self._folder))

    def _start(self, command: str, *arguments: str) -> subprocess.Popen[bytes]:
        line = [sys.executable, "-m", f"distributed.cli.{command}", *arguments, *self._tls]
        # Workers import the kinds by name, as they do on a machine where modallab is installed.
        environment = os.environ | {"PYTHONPATH": HERE, "OPENBLAS_NUM_THREADS": "1"}
        no_output = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        process = subprocess.Popen(line, env=environment, cwd=self._folder, **no_output)
        self._all.append(process)
        return process

    def end(self) -> None:
        for process in self._all:
            process.kill()
        for process in self._all:
            process.wait(10)


@contextmanager
def machines(folder: Path, tls: Sequence[str] = ()) -> Iterator[Machines]:
    started = Machines(folder, tls)
    try:
        yield started
    finally:
        started.end()
