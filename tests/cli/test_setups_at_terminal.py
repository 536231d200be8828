"""Set-ups at the terminal: it says what to move, waits for the key, and shows one model of all."""

import subprocess
import sys
from pathlib import Path

import pytest

from modallab.cli.demo import demo_rig
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.formats.rig.rig_file import write_rig

pytestmark = pytest.mark.thorough("records tests with two set-ups")

BENCH = "sim://cantilever?seed=1&zeta=0.05&bad_hits=0"
PLAN = "{kind: impact, points: [10], hits: 1, setups: [{name: left}, {name: right, points: {a01: 3, a02: 4}}]}\n"
START = "import sys; from modallab.cli import main; sys.exit(main(sys.argv[1:]))"


def command(folder: Path) -> list[str]:
    rig = demo_rig()
    channels = [rig.channels[n].model_copy(update={"index": i}) for i, n in enumerate((0, 1, 2, 10))]
    write_rig(rig.model_copy(update={"channels": tuple(channels)}), folder / "rig.yaml")
    (folder / "plan.yaml").write_text(PLAN, encoding="utf-8")
    words = ["--rig", "rig.yaml", "--plan", "plan.yaml", "--bench", BENCH, "--data", "d", "--mute"]
    return [sys.executable, "-u", "-c", START, "campaign", "run", *words, "--out", "s.h5", "--report", "s.html"]


def test_sensors_are_moved_at_the_terminal_and_one_model_shown(tmp_path: Path) -> None:
    with subprocess.Popen(
        command(tmp_path), stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=tmp_path
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        for line in process.stdout:
            if "move: set-up right: a01 from 1 to 3, a02 from 2 to 4; then press p" in line:
                break
        process.stdin.write("p\n")
        process.stdin.flush()
        said = process.stdout.read()
    assert process.returncode == 0, said
    assert "set-up right: agrees with left" in said
    assert read_campaign(tmp_path / "s-right.h5").rig.channels[1].point == 3
    assert "a01@3" in (tmp_path / "s.html").read_text(encoding="utf-8")


def test_where_no_key_can_come_it_says_so(tmp_path: Path) -> None:
    done = subprocess.run(
        command(tmp_path), stdin=subprocess.DEVNULL, capture_output=True, text=True, cwd=tmp_path, check=False
    )
    assert done.returncode == 2
    assert "no key can confirm the move" in done.stderr
