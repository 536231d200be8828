"""Ctrl-C ends what takes long at once: one sentence, no traceback, no file half written, no process left."""

import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest
import stopped_by_ctrl_c

AGAIN = pytest.mark.thorough("begins whole commands, and stops them")
LONG = 120
"""Of patience, on however busy a machine; none of the commands would have ended by itself so soon after its sign."""


@pytest.mark.parametrize(
    ("nth", "command", "left"),
    [
        pytest.param(2, "identify {small} --json models.json", "models.json", marks=AGAIN),
        pytest.param(3, "gap diagnose {small} --json gap.json", "gap.json", marks=AGAIN),
        (1, "import {small}/campaign.h5 --rig {small}/rig.yaml --out new.h5", "new.h5"),
        pytest.param(2, "demo --out new", "new/report.html", marks=AGAIN),
    ],
    ids=["identify", "diagnose", "import", "demo"],
)
def test_ctrl_c_ends_a_command_in_good_order(nth: int, command: str, left: str, small: Path, tmp_path: Path) -> None:
    script = [sys.executable, stopped_by_ctrl_c.__file__, str(nth), *command.format(small=small).split()]
    with subprocess.Popen(
        script, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    ) as child:
        _, said = child.communicate(timeout=LONG)
    assert said == "modallab: stopped by the operator\n"
    assert child.returncode == 130
    assert not (tmp_path / left).exists()
    end = time.monotonic() + LONG
    while left_over := _living(child.pid):
        assert time.monotonic() < end, f"still there: {left_over}"
        time.sleep(0.05)


def _living(group: int) -> list[str]:
    """Names of the processes of a group where the system shows them as files.

    Without those that have ended and wait to be taken note of.
    """
    found: list[str] = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            name, _, rest = stat.read_text().rpartition(")")
            state, _, own_group = rest.split()[:3]
            if int(own_group) == group and state not in "ZX":
                found.append(name)
    return found
