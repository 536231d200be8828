"""The simulated NI device server as a process of its own, with an operator who types."""

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, Self

from modallab.core.rig import Rig

START_S = 30


class NiServer:
    """Starts the server, and ends it by closing its standard input."""

    def __init__(self, rig: Rig, system: str, *options: str, device: str = "", virtual: bool = True) -> None:
        self._folder = tempfile.TemporaryDirectory()
        file = Path(self._folder.name) / "rig.json"
        file.write_text(rig.model_dump_json(), encoding="utf-8")
        command = [sys.executable, "-m", "modallab_simulators.ni_daqmx_server", "--rig", str(file), "--system", system]
        self.process = subprocess.Popen(
            [*command, *options], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1
        )
        reported = self._answer()
        self.port: int = reported["port"]
        self.generator: str = reported.get("generator", "")
        self.target = f"127.0.0.1:{self.port}"
        name = device or ("Dev1" if system in ("6211", "4431") else "cDAQ1")
        said = [*(["virtual_time=1"] if virtual else []), *(["local=1"] if "--local" in options else [])]
        self.url = f"nidaqmx+grpc://{self.target}/{name}" + (f"?{'&'.join(said)}" if said else "")

    def say(self, line: str) -> dict[str, Any]:
        """What the operator types, and what comes back."""
        assert self.process.stdin is not None
        self.process.stdin.write(f"{line}\n")
        self.process.stdin.flush()
        answer = self._answer()
        assert "error" not in answer, answer
        return answer

    def close(self) -> None:
        """End the process."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.close()
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self.process.stdout.close()
        self._folder.cleanup()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _answer(self) -> dict[str, Any]:
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        assert line, f"the server ended with {self.process.wait()}"
        return json.loads(line)
