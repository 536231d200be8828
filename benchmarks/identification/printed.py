"""What a command of a benchmark prints, such as a peer in an environment of its own."""

import json
import os
import subprocess
from typing import Any


def printed(command: list[str]) -> dict[str, Any]:
    """The JSON of its last line, or the reason why there is none as `failed`."""
    env = os.environ | {"QT_QPA_PLATFORM": "offscreen"}
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=env)
    if done.returncode:
        return {"failed": done.stderr.strip().splitlines()[-1] if done.stderr.strip() else "killed"}
    return dict(json.loads(done.stdout.splitlines()[-1]))
