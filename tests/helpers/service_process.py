"""The service as a process of its own, started as anyone would start it."""

import os
import re
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Self

import httpx

from modallab.client import Client

START_S = 300.0
COMMAND = Path(sys.executable).with_name("modallab")


class ServiceProcess:
    """Starts `modallab serve` on free ports, and ends it."""

    def __init__(
        self,
        data: Path,
        *options: str,
        bench: str = "",
        env: Mapping[str, str] | None = None,
        start_new_session: bool = False,
    ) -> None:
        self.data = data
        self._log = (data.parent.parent / f"{data.parent.name}-{data.name}.log").open("a+")
        self._options = [*(["--bench", bench] if bench else []), *options]
        self._env = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"} | dict(env or {})
        self._apart = start_new_session
        self.said: list[str] = []
        self._start("0")

    def kill_and_restart(self, between: Callable[[], object] = lambda: None) -> None:
        """End it as a power cut would, and start it again where it was; `between` is called while it is gone."""
        self.process.kill()
        self.process.wait()
        self.client.close()
        if self.process.stdout is not None:
            self.process.stdout.close()
        between()
        self._start(self.url.rpartition(":")[2])

    def _start(self, port: str) -> None:
        command = [str(COMMAND), "serve", "--data", str(self.data), "--port", port, "--stop-port", "0"]
        self.process = subprocess.Popen(
            [*command, *self._options],
            stdout=subprocess.PIPE,
            stderr=self._log,
            text=True,
            start_new_session=self._apart,
            env=self._env,
        )
        try:
            self.url = self._said(r"serves at (https?://\S+)/,")
            self.stop_url = self._said(r"POST (https?://\S+)")
            self._said(r"(rig):")
            self.token = (self.data / "token").read_text().strip()
            ca = self.data / "tls" / "cert.pem"
            self.client = Client(self.url, self.token, "tester", timeout_s=120.0, ca=ca if ca.exists() else None)
            self.rig = self._ready()
        except BaseException:
            self.close()
            raise

    @property
    def log(self) -> str:
        """What the service wrote on standard error."""
        self._log.seek(0)
        return self._log.read()

    def close(self) -> None:
        """End it in good order; if it does not leave, kill it."""
        if hasattr(self, "client"):
            self.client.close()
        if self.process.poll() is None:
            self.process.terminate()
            try:
                self.process.wait(30)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        if self.process.stdout is not None:
            self.process.stdout.close()
        self._log.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _said(self, pattern: str) -> str:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self.said.append(line)
            found = re.search(pattern, line)
            if found:
                return found[1]
        raise AssertionError(f"the service ended with {self.process.wait()}: {self.log}")

    def _ready(self) -> str:
        end = time.monotonic() + START_S
        while True:
            try:
                rig = self.client.rigs()[0].id
                self.client.wait_until_idle(rig, START_S)
                return rig
            except httpx.TransportError:
                if time.monotonic() > end:
                    raise
                time.sleep(0.1)
