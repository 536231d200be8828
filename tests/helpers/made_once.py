"""What several tests only read is made once a test run, whichever of pytest's worker processes asks first."""

import io
import os
import time
from collections.abc import Callable
from contextlib import chdir, redirect_stderr, redirect_stdout
from pathlib import Path

import pytest
from twin_campaign import built, link

from modallab.cli import main
from modallab.formats.campaign.campaign_hdf5 import write_campaign
from modallab.formats.rig.rig_file import write_rig

MADE_S = 300.0


def made_once(factory: pytest.TempPathFactory, name: str, make: Callable[[Path], None]) -> Path:
    """The folder that `make` filled; a worker that asks while another makes it waits for it."""
    base = factory.getbasetemp()
    folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / name
    made = folder / "made"
    try:
        folder.mkdir()
    except FileExistsError:
        end = time.monotonic() + MADE_S
        while not made.exists():
            assert time.monotonic() < end, f"no other worker made {folder}: its own test says why"
            time.sleep(0.1)
    else:
        make(folder)
        made.touch()
    return folder


def write_small(folder: Path) -> None:
    """The campaign of `twin_campaign.built`, as a command reads it."""
    rig = link()
    write_campaign(built(rig), folder / "campaign.h5")
    write_rig(rig, folder / "rig.yaml")


def record_demo(folder: Path) -> None:
    """`modallab demo --out demo`, with its usual seed, in a folder, and what it printed as `printed.txt` beside."""
    printed = io.StringIO()
    with pytest.MonkeyPatch.context() as patch, chdir(folder), redirect_stdout(printed), redirect_stderr(printed):
        patch.setenv("COLUMNS", "80")
        assert main(["demo", "--out", "demo", "--seed", "1"]) == 0
    (folder / "printed.txt").write_text(printed.getvalue(), encoding="utf-8")
