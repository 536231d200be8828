"""Kills the acquisition process in the middle of a 60 s burst and times how long the output goes on.

The output is that of a simulated NI device in a server of its own, which outlives its client: what the client started
goes on. `--also-supervisor` kills the supervisor and the process that owns both as well, so that nobody is left who
could do anything; then the device's watchdog is left, or, with `--no-watchdog`, the burst's own end.

    python benchmarks/kill_shaker.py --kills 50
"""

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from importlib.resources import files
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "helpers"))

from ni_server import NiServer

from modallab.acquisition.process.rig_process import RigProcess
from modallab.bench.loader import open_output
from modallab.core.errors import ModallabError
from modallab.core.hardware import Excitation
from modallab.core.plan import SinePlan
from modallab.core.rig import Rig
from modallab.formats.rig.rig_file import parse_rig

OUTPUT = "cDAQ1Mod4/ao0"
LIMIT_S = 0.5
WATCHDOG_MARGIN_S = 0.1
"""Past a watchdog's own time: to look at the output takes that long."""


def long_burst(seconds: float) -> SinePlan:
    """One burst of so many seconds, with hardly anything before it."""
    block, ramp = 0.128, 0.3
    return SinePlan(
        frequencies_hz=(19.53125,), ramp_s=ramp, settle_s=seconds - block - ramp - 0.11, block_s=block,
        wait_s=0.2, settle_timeout_s=0.2,
    )  # fmt: skip


def kill_once(server: NiServer, rig: Rig, plan: SinePlan, folder: Path) -> float:
    """Seconds from the kill of the acquisition process until the output has been at 0 V for 10 ms."""
    with RigProcess(server.url, rig, folder) as process:
        _ = process.info
        runner = threading.Thread(target=drain, args=(process, plan), daemon=True)
        runner.start()
        wait_until(lambda: server.say("levels 0.1")[OUTPUT] > 0.4, 30.0)
        process.process.kill()
        took = time_to_zero(server)
        runner.join(10)
    return took


def kill_all(server: NiServer, rig: Rig, plan: SinePlan, folder: Path) -> float:
    """The same, with the supervisor and the owner killed at once too."""
    folder.mkdir()
    (folder / "rig.json").write_text(rig.model_dump_json())
    (folder / "plan.json").write_text(plan.model_dump_json())
    command = [sys.executable, __file__, "--own", server.url, "--folder", str(folder)]
    owner = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        assert owner.stdout is not None
        pids = json.loads(owner.stdout.readline())
        wait_until(lambda: server.say("levels 0.1")[OUTPUT] > 0.4, 30.0)
        for pid in (pids["supervisor"], owner.pid, pids["rig"]):
            os.kill(pid, signal.SIGKILL)
        took = time_to_zero(server)
    finally:
        owner.kill()
        owner.communicate()
    # Nobody was left to give the inputs back.
    handle = open_output(server.url, rig)
    assert handle is not None
    handle.release()
    handle.close()
    return took


def own(url: str, folder: Path) -> None:
    """What the owner does that is killed: run the plan, and say whom else to kill."""
    rig = Rig.model_validate_json((folder / "rig.json").read_text())
    plan = SinePlan.model_validate_json((folder / "plan.json").read_text())
    with RigProcess(url, rig, folder / "data") as process:
        assert process.supervisor is not None
        print(json.dumps({"supervisor": process.supervisor.process.pid, "rig": process.process.pid}), flush=True)
        drain(process, plan)


def time_to_zero(server: NiServer) -> float:
    # However long it takes: one that is late is counted as late.
    began = time.monotonic()
    while server.say("levels 0.01")[OUTPUT] != 0.0:
        time.sleep(0.002)
    return time.monotonic() - began - 0.01


def drain(process: RigProcess, plan: SinePlan) -> None:
    try:
        for _ in process.run(plan):
            pass
    except ModallabError as error:
        if "ended (exit code" not in str(error):
            print(error, file=sys.stderr)


def wait_until(happened, patience_s: float) -> None:
    deadline = time.monotonic() + patience_s
    while not happened():
        if time.monotonic() > deadline:
            raise TimeoutError(f"not within {patience_s} s")
        time.sleep(0.002)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--also-supervisor", action="store_true")
    parser.add_argument("--watchdog-s", type=float, default=0.4, help="of the device, where it is what is left")
    parser.add_argument("--no-watchdog", action="store_true")
    parser.add_argument("--burst-s", type=float, default=59.9)
    parser.add_argument("--own", default="", help=argparse.SUPPRESS)
    parser.add_argument("--folder", type=Path, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.own:
        own(arguments.own, arguments.folder)
        return 0
    rig = parse_rig((files("modallab.cli") / "link_rig.yaml").read_text(encoding="utf-8"), "the demo's rig")
    if arguments.also_supervisor and not arguments.no_watchdog:
        rig = rig.model_copy(update={"excitation": Excitation(watchdog_s=arguments.watchdog_s)})
    plan = long_burst(arguments.burst_s)
    with NiServer(rig, "9215", "--pace", virtual=False) as server, tempfile.TemporaryDirectory() as folder:
        server.say("preamplifiers sine")
        once = kill_all if arguments.also_supervisor else kill_once
        took: list[float] = []
        for n in range(2 * arguments.kills):
            if len(took) == arguments.kills:
                break
            try:
                took.append(once(server, rig, plan, Path(folder) / str(n)))
            except TimeoutError as error:
                # A machine so busy that a guard ended the burst before anybody was killed says nothing on kills.
                print(f"not counted, no burst to be killed in: {error}", flush=True)
            else:
                print(f"{len(took)}: {took[-1]:.3f} s", flush=True)
    limit = arguments.burst_s if arguments.no_watchdog else LIMIT_S
    if arguments.also_supervisor and not arguments.no_watchdog:
        limit = arguments.watchdog_s + WATCHDOG_MARGIN_S
    good = sum(t <= limit for t in took)
    print(
        f"{good} of {len(took)} at 0 V within {limit} s of kill -9;"
        f" median {np.median(took):.3f} s, longest {max(took):.3f} s"
    )
    return 0 if good == len(took) else 1


if __name__ == "__main__":
    sys.exit(main())
