"""The simulated NI device server as a process of its own, with an operator who types."""

import json
import os
import select
import signal
import tempfile
from pathlib import Path
from typing import Any, Self

from warm_process import warm

from modallab.core.rig import Rig

PROGRAM = "modallab_simulators.ni_daqmx_server.__main__"
END_S = 10


class NiServer:
    """Starts the server, and ends it by closing its standard input."""

    def __init__(self, rig: Rig, system: str, *options: str, device: str = "", virtual: bool = True) -> None:
        self._folder = tempfile.TemporaryDirectory()
        file = Path(self._folder.name) / "rig.json"
        file.write_text(rig.model_dump_json(), encoding="utf-8")
        its_input, ours = os.pipe()
        output, its_output = os.pipe()
        self._pid = warm(PROGRAM).start(["--rig", str(file), "--system", system, *options], its_input, its_output)
        os.close(its_input)
        os.close(its_output)
        self._stdin, self._stdout = os.fdopen(ours, "w", buffering=1), os.fdopen(output)
        reported = self._answer()
        self.port: int = reported["port"]
        self.generator: str = reported.get("generator", "")
        self.target = f"127.0.0.1:{self.port}"
        name = device or ("Dev1" if system in ("6211", "4431") else "cDAQ1")
        said = [*(["virtual_time=1"] if virtual else []), *(["local=1"] if "--local" in options else [])]
        self.url = f"nidaqmx+grpc://{self.target}/{name}" + (f"?{'&'.join(said)}" if said else "")

    def say(self, line: str) -> dict[str, Any]:
        """What the operator types, and what comes back."""
        self._stdin.write(f"{line}\n")
        self._stdin.flush()
        answer = self._answer()
        assert "error" not in answer, answer
        return answer

    def close(self) -> None:
        """End the process."""
        self._stdin.close()
        ended, _, _ = select.select([self._stdout], [], [], END_S)
        if not ended:
            os.kill(self._pid, signal.SIGKILL)
        self._stdout.close()
        self._folder.cleanup()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _answer(self) -> dict[str, Any]:
        line = self._stdout.readline()
        assert line, "the server has ended"
        return json.loads(line)
