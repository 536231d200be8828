"""When the process that asked for a run dies, the output is brought to zero and what was recorded is kept."""

import os
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

from modallab.acquisition.process.owner_link import TIMEOUT_S
from modallab.acquisition.process.rig_process import RigProcess
from modallab.core.errors import BenchError
from modallab.core.plan import SinePlan
from modallab.core.rig import Rig
from modallab.storage import Store

WITNESS = Path(__file__).parent / "witness"

OWNER = """
import sys
from pathlib import Path
from modallab.acquisition.process.rig_process import RigProcess
from modallab.core.plan import SinePlan
from modallab.core.rig import Rig

if __name__ == "__main__":
    rig = Rig.model_validate_json(Path(sys.argv[1]).read_text())
    rest = {{"wait_s": 0.1, "settle_timeout_s": 0.1}}
    long = SinePlan(frequencies_hz=(10.0, 20.0), block_s=0.064, ramp_s=0.02, settle_s={settle}, **rest)
    with RigProcess("witness://bench", rig, Path(sys.argv[2])) as process:
        for event in process.run(long):
            pass
"""


def waited_for(log: Path, what: str, after: int, within_s: float = 30.0) -> list[str]:
    end = time.monotonic() + within_s
    while time.monotonic() < end:
        lines = log.read_text().splitlines() if log.exists() else []
        if any(line.startswith(what) for line in lines[after:]):
            return lines
        time.sleep(0.01)
    raise AssertionError(f"no {what} in {lines}")


def start_owner(tmp_path: Path, rig: Rig, settle_s: float) -> tuple[subprocess.Popen[bytes], Path]:
    (tmp_path / "owner.py").write_text(OWNER.format(settle=settle_s))
    (tmp_path / "rig.json").write_text(rig.model_dump_json())
    log = tmp_path / "witness.log"
    environment = os.environ | {
        "PYTHONPATH": os.pathsep.join([str(WITNESS), os.environ.get("PYTHONPATH", "")]),
        "WITNESS_LOG": str(log),
    }
    command = [sys.executable, str(tmp_path / "owner.py"), str(tmp_path / "rig.json"), str(tmp_path / "data")]
    return subprocess.Popen(command, env=environment), log


def test_the_output_is_zero_soon_after_the_owners_death(tmp_path: Path, link_rig: Rig) -> None:
    owner, log = start_owner(tmp_path, link_rig, settle_s=20.0)
    before = waited_for(log, "play", 0)
    killed = time.time()
    owner.kill()
    owner.wait()
    after = waited_for(log, "close", len(before))
    zeroed = next(line for line in after[len(before) :] if line.startswith("zero"))
    # The death is seen: to miss the owner's sign of life takes longer, and the burst ends later still.
    assert float(zeroed.split()[1]) - killed < TIMEOUT_S
    with Store(tmp_path / "data") as store:
        (run,) = store.catalogue.runs()
        assert run.state == "failed"
        assert run.reason == "interrupted: the process that requested the run has ended"


@pytest.mark.thorough("starts an owner with its rig process, and kills it")
def test_the_output_is_zeroed_at_start_up_and_at_the_end_of_a_good_run(tmp_path: Path, link_rig: Rig) -> None:
    owner, log = start_owner(tmp_path, link_rig, settle_s=0.05)
    assert owner.wait(60) == 0
    # What the supervisor does from outside is another matter.
    done = [word for line in log.read_text().splitlines() if not (word := line.split()[0]).startswith("outside")]
    assert done[:2] == ["open", "zero"]
    assert done.count("play") == 2
    assert "zero" in done[len(done) - 1 - done[::-1].index("play") :]
    assert done[-1] == "close"
    with Store(tmp_path / "data") as store:
        (run,) = store.catalogue.runs()
        assert run.state == "done"
        assert len(store.blocks(run.id)) == 2


@pytest.mark.parametrize(("url", "said"), [("free", "brought to 0 V from outside"), ("locked", "switch the amplifier")])
def test_when_the_rigs_process_is_killed_its_owner_zeroes_the_output(
    tmp_path: Path, link_rig: Rig, monkeypatch: pytest.MonkeyPatch, url: str, said: str
) -> None:
    monkeypatch.syspath_prepend(str(WITNESS))
    monkeypatch.setenv("WITNESS_LOG", str(tmp_path / "witness.log"))
    plan = SinePlan(frequencies_hz=(10.0,), block_s=0.064, ramp_s=0.02, settle_s=20.0, wait_s=0.1, settle_timeout_s=0.1)
    with RigProcess(f"witness://{url}", link_rig, tmp_path / "data") as process:
        events = process.run(plan)
        next(e for e in events if e.kind == "state" and e.state == "acquiring")
        waited_for(tmp_path / "witness.log", "play", 0)
        process.process.kill()
        with pytest.raises(BenchError, match=said):
            list(events)
    done = (tmp_path / "witness.log").read_text().split()
    assert ("outside-zero" in done) == (url == "free")


@pytest.mark.thorough("starts an owner with its rig process, and kills it")
@pytest.mark.parametrize("kills", [2])
def test_kills_at_random_moments_lose_nothing_that_was_acknowledged(kills: int) -> None:
    script = Path(__file__).parents[2] / "benchmarks" / "kill_acquisition.py"
    command = [sys.executable, str(script), "--kills", str(kills), "--hits", "2", "--frequencies", "12"]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert f"{kills} kills" in done.stdout
    assert "0 lost or different" in done.stdout


@pytest.mark.thorough("starts an owner with its rig process, and kills it")
@pytest.mark.parametrize("moment_s", [0.0, 0.1, 0.3])
def test_a_rigs_process_that_still_starts_ends_with_its_owner(tmp_path: Path, link_rig: Rig, moment_s: float) -> None:
    owner, _ = start_owner(tmp_path, link_rig, settle_s=20.0)
    while not (started := psutil.Process(owner.pid).children(recursive=True)) and owner.poll() is None:
        time.sleep(0.005)
    time.sleep(moment_s)
    started = psutil.Process(owner.pid).children(recursive=True)
    owner.kill()
    owner.wait()
    assert psutil.wait_procs(started, timeout=5.0)[1] == []
