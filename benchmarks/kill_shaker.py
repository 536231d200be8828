"""Kills the acquisition process in the middle of a 60 s burst and times how long the output goes on.

The output is that of a simulated NI device in a server of its own, which outlives its client: what the client started
goes on. `--also-supervisor` kills the supervisor first; then the device's watchdog is left, or, with `--no-watchdog`,
the burst's own end.

    python benchmarks/kill_shaker.py --kills 50
"""

import argparse
import sys
import tempfile
import threading
import time
from importlib.resources import files
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "helpers"))

from ni_server import NiServer

from modallab.acquisition.process import RigProcess
from modallab.backend.loader import open_output
from modallab.errors import ModallabError
from modallab.exchange.rig_file import parse_rig
from modallab.schema.hardware import Excitation
from modallab.schema.plan import SinePlan
from modallab.schema.rig import Rig

OUTPUT = "cDAQ1Mod4/ao0"
LIMIT_S = 0.5


def long_burst(seconds: float) -> SinePlan:
    """One burst of so many seconds, with hardly anything before it."""
    block, ramp = 0.128, 0.3
    return SinePlan(
        frequencies_hz=(19.53125,), ramp_s=ramp, settle_s=seconds - block - ramp - 0.11, block_s=block, rest_s=0.2
    )


def kill_once(server: NiServer, rig: Rig, plan: SinePlan, folder: Path, *, also_supervisor: bool) -> float:
    """Seconds from the kill until the output has been at 0 V for 10 ms."""
    with RigProcess(server.url, rig, folder) as process:
        _ = process.info
        runner = threading.Thread(target=drain, args=(process, plan), daemon=True)
        runner.start()
        wait_until(lambda: server.say("levels 0.1")[OUTPUT] > 0.4, 30.0)
        supervisor = process.supervisor
        assert supervisor is not None
        if also_supervisor:
            supervisor.process.kill()
            supervisor.process.join()
        process.process.kill()
        began = time.monotonic()
        wait_until(lambda: server.say("levels 0.01")[OUTPUT] == 0.0, 90.0)
        took = time.monotonic() - began - 0.01
        runner.join(10)
    if also_supervisor:
        # Nobody was left to give the inputs back.
        handle = open_output(server.url, rig)
        assert handle is not None
        handle.release()
        handle.close()
    return took


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
    parser.add_argument("--no-watchdog", action="store_true")
    parser.add_argument("--burst-s", type=float, default=59.9)
    arguments = parser.parse_args()
    rig = parse_rig((files("modallab.campaign") / "link_rig.yaml").read_text(encoding="utf-8"), "the demo's rig")
    if arguments.also_supervisor and not arguments.no_watchdog:
        rig = rig.model_copy(update={"excitation": Excitation(watchdog_s=0.3)})
    plan = long_burst(arguments.burst_s)
    with NiServer(rig, "9215", "--pace", virtual=False) as server, tempfile.TemporaryDirectory() as folder:
        server.say("preamplifiers sine")
        took = [
            kill_once(server, rig, plan, Path(folder) / str(n), also_supervisor=arguments.also_supervisor)
            for n in range(arguments.kills)
        ]
    good = sum(t <= LIMIT_S for t in took)
    print(
        f"{good} of {len(took)} at 0 V within {LIMIT_S} s of kill -9;"
        f" median {np.median(took):.3f} s, longest {max(took):.3f} s"
    )
    return 0 if good == len(took) or arguments.no_watchdog else 1


if __name__ == "__main__":
    sys.exit(main())
