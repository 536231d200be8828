"""The machine is kept awake while a test drives, by a command that ends with the process that asked."""

import os
import subprocess
import sys
from pathlib import Path

import psutil
import pytest

from modallab.acquisition.process.child import prevent_sleep

INHIBIT = """#!/bin/sh
echo "$@" > "{log}"
for option; do case "$option" in --*) shift;; *) break;; esac; done
exec "$@"
"""


@pytest.fixture
def inhibitor(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A system that holds sleep off, and writes down what it was asked."""
    script, log = tmp_path / "systemd-inhibit", tmp_path / "asked"
    script.write_text(INHIBIT.format(log=log))
    script.chmod(0o755)
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    return log


def holders() -> list[psutil.Process]:
    # A shell that says that it holds, and becomes `cat`.
    return [child for child in psutil.Process().children() if child.name() in ("sh", "cat")]


def test_sleep_is_held_off_for_as_long_as_the_test_drives(inhibitor: Path) -> None:
    with prevent_sleep() as said:
        assert said == "this machine is kept awake"
        assert holders()
    assert not holders()
    assert "--what=sleep:idle" in inhibitor.read_text()
    assert "--mode=block" in inhibitor.read_text()


def test_where_it_cannot_be_held_off_the_notice_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setenv("PATH", str(tmp_path))
    with prevent_sleep() as said:
        assert "could NOT be kept awake (there is no systemd-inhibit)" in said


def test_one_that_is_rejected_is_no_success(inhibitor: Path) -> None:
    script = inhibitor.parent / "systemd-inhibit"
    script.write_text("#!/bin/sh\nexit 1\n")
    with prevent_sleep() as said:
        assert "systemd-inhibit was rejected" in said


def test_it_ends_with_the_process_however_that_ends(inhibitor: Path) -> None:
    code = (
        "import os\nfrom modallab.acquisition.process.child import prevent_sleep\n"
        "import psutil\n"
        "with prevent_sleep():\n"
        "    print(psutil.Process().children()[0].pid, flush=True)\n"
        "    os.kill(os.getpid(), 9)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == -9
    psutil.wait_procs([psutil.Process(int(done.stdout))] if psutil.pid_exists(int(done.stdout)) else [], timeout=5)
    assert not psutil.pid_exists(int(done.stdout))
