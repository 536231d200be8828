"""Kills or freezes what drives a 60 s burst, in the middle of it, and times how long the output goes on.

The output is that of a simulated NI device in a server of its own. Without `--local` the burst outlives its client, as
with NI's device server; with it the burst stops midway when its client dies or is frozen and the output holds its last
value, as with the driver on one's own machine.

Who is hit: the acquisition process; with `--group` the whole process group of the owner, which the supervisor has left;
with `--also-supervisor` the owner, the acquisition process and the supervisor, so that nobody is left who could do
anything: then the device's watchdog is left, or, with `--no-watchdog`, the burst's own end. `--freeze` stops instead
of killing.

    python benchmarks/kill_shaker.py --kills 50
    python benchmarks/kill_shaker.py --kills 50 --group --local --freeze
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
from collections.abc import Callable
from contextlib import suppress
from importlib.resources import files
from pathlib import Path

import numpy as np
import psutil

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "helpers"))

from ni_server import NiServer

from modallab.acquisition.process.output_watch import DIED, FROZEN
from modallab.acquisition.process.rig_process import RigProcess
from modallab.acquisition.process.trip import TripLatch
from modallab.bench.loader import open_output
from modallab.core.errors import ModallabError
from modallab.core.hardware import Excitation
from modallab.core.plan import SinePlan
from modallab.core.rig import Rig
from modallab.formats.rig.rig_file import parse_rig

OUTPUTS = {"9215": "cDAQ1Mod4/ao0", "6211": "Dev1/ao0"}
LIMIT_S = 0.5
WATCHDOG_MARGIN_S = 0.1
"""Past a watchdog's own time: to look at the output takes that long."""
HELD_S = 5.0
"""At the value it holds for so long, and for longer than a watchdog waits, an output is left there for good."""
ATTEMPTS = 4
"""Bursts more than twice those wanted that are begun at most: a busy machine's own guards end some."""
WAIVED = "this is a simulation"


def long_burst(seconds: float) -> SinePlan:
    """One burst of so many seconds, with hardly anything before it."""
    block, ramp = 0.128, 0.3
    return SinePlan(
        frequencies_hz=(19.53125,), ramp_s=ramp, settle_s=seconds - block - ramp - 0.11, block_s=block,
        wait_s=0.2, settle_timeout_s=0.2,
    )  # fmt: skip


class Trial:
    """One server, and one kill after the other."""

    def __init__(self, server: NiServer, output: str, rig: Rig, plan: SinePlan, how: argparse.Namespace) -> None:
        self.server, self.output, self.rig, self.plan, self.how = server, output, rig, plan, how
        self.signal = signal.SIGSTOP if how.freeze else signal.SIGKILL
        self.noted: list[str] = []
        """What each supervisor wrote down of what it saw."""

    def once(self, folder: Path) -> float:
        """Seconds from the kill until the output has been at 0 V for 10 ms; infinite if it never came there."""
        return self.with_owner(folder) if self.how.group or self.how.also_supervisor else self.alone(folder)

    def alone(self, folder: Path) -> float:
        """The acquisition process is hit; its owner and the supervisor live."""
        with RigProcess(self.server.url, self.rig, folder) as process:
            _ = process.info
            runner = threading.Thread(target=drain, args=(process, self.plan), daemon=True)
            runner.start()
            self.wait_for_volts(lambda: not runner.is_alive())
            assert process.process.pid is not None
            os.kill(process.process.pid, self.signal)
            took = self.time_to_zero()
            os.kill(process.process.pid, signal.SIGKILL)
            runner.join(10)
        return took

    def with_owner(self, folder: Path) -> float:
        """The owner is hit too, and where that is asked for the supervisor."""
        folder.mkdir()
        (folder / "rig.json").write_text(self.rig.model_dump_json())
        (folder / "plan.json").write_text(self.plan.model_dump_json())
        command = [sys.executable, __file__, "--own", self.server.url, "--folder", str(folder)]
        owner = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, start_new_session=True)
        try:
            assert owner.stdout is not None
            pids = json.loads(owner.stdout.readline())
            self.wait_for_volts(lambda: owner.poll() is not None)
            if self.how.also_supervisor:
                for pid in (pids["supervisor"], owner.pid, pids["rig"]):
                    os.kill(pid, self.signal)
            else:
                os.killpg(owner.pid, self.signal)
            took = self.time_to_zero()
        finally:
            # Nobody is left in the group where all of it has ended by itself.
            with suppress(ProcessLookupError):
                os.killpg(owner.pid, signal.SIGKILL)
            owner.communicate()
        wait_until(lambda: not psutil.pid_exists(pids["supervisor"]) or self.how.also_supervisor, 60.0)
        if self.how.also_supervisor:
            self.give_back(pids["supervisor"])
        trip = TripLatch(folder / "data", self.server.url).read()
        self.noted.append("nothing" if trip is None else trip.what)
        return took

    def give_back(self, supervisor: int) -> None:
        """Nobody was left to do it."""
        if psutil.pid_exists(supervisor):
            os.kill(supervisor, signal.SIGKILL)
        handle = open_output(self.server.url, self.rig)
        assert handle is not None
        handle.release()
        handle.close()

    def wait_for_volts(self, ended: Callable[[], bool]) -> None:
        """Until the burst is on; whose owner has ended before that will play none."""

        def plays() -> bool:
            if ended():
                raise TimeoutError("who was to play it has ended")
            return self.server.say("levels 0.1")[self.output] > 0.4

        # Asked too often, the device has no time left to play.
        wait_until(plays, 120.0, 0.05)
        # Anywhere in a period.
        time.sleep(np.random.default_rng().uniform(0.0, 0.1))

    def time_to_zero(self) -> float:
        # However long a burst takes: one that is late is counted as late.
        began = time.monotonic()
        while self.server.say("levels 0.01")[self.output] != 0.0:
            if self.how.local and time.monotonic() - began > max(HELD_S, self.how.watchdog_s):
                return float("inf")
            time.sleep(0.002)
        return time.monotonic() - began - 0.01


def own(url: str, folder: Path) -> None:
    """What the owner does that is hit: run the plan, and say who else is there."""
    rig = Rig.model_validate_json((folder / "rig.json").read_text())
    plan = SinePlan.model_validate_json((folder / "plan.json").read_text())
    with RigProcess(url, rig, folder / "data") as process:
        assert process.supervisor is not None
        print(json.dumps({"supervisor": process.supervisor.process.pid, "rig": process.process.pid}), flush=True)
        drain(process, plan)


def drain(process: RigProcess, plan: SinePlan) -> None:
    try:
        for _ in process.run(plan):
            pass
    except ModallabError as error:
        if "ended (exit code" not in str(error):
            print(error, file=sys.stderr)


def wait_until(happened, patience_s: float, pause_s: float = 0.002) -> None:
    deadline = time.monotonic() + patience_s
    while not happened():
        if time.monotonic() > deadline:
            raise TimeoutError(f"not within {patience_s} s")
        time.sleep(pause_s)


def excitation_of(how: argparse.Namespace) -> Excitation | None:
    if how.no_watchdog:
        return Excitation(watchdog_waived=WAIVED) if how.local else None
    return Excitation(watchdog_s=how.watchdog_s) if how.also_supervisor or how.local else None


def others_s(how: argparse.Namespace) -> float:
    """How long after a hit nobody but the supervisor can have ended the output: half of what the next guard waits."""
    excitation = excitation_of(how)
    watchdog_s = excitation.watchdog_s if excitation is not None else None
    return (watchdog_s or how.burst_s) / 2


def limit_of(how: argparse.Namespace) -> float:
    if how.also_supervisor:
        return how.burst_s if how.no_watchdog else how.watchdog_s + WATCHDOG_MARGIN_S
    return LIMIT_S


def report(took: list[float], how: argparse.Namespace) -> int:
    limit, reached = limit_of(how), [t for t in took if np.isfinite(t)]
    good = sum(t <= limit for t in took)
    word = "a freeze" if how.freeze else "kill -9"
    times = f"median {np.median(reached):.3f} s, longest {max(reached):.3f} s" if reached else "never"
    held = f"; {len(took) - len(reached)} held their last value for good" if len(reached) < len(took) else ""
    print(f"{good} of {len(took)} at 0 V within {limit:g} s of {word}; {times}{held}")
    return 0 if good == len(took) else 1


def by_whom(took: list[float], noted: list[str], how: argparse.Namespace) -> int:
    """By what the supervisor wrote down, and before the next guard: neither depends on how busy the machine is."""
    saw = FROZEN if how.freeze else DIED
    good = sum(t < others_s(how) and what == saw for t, what in zip(took, noted, strict=True))
    said = "; ".join(f"{t:.3f} s, {what}" for t, what in zip(took, noted, strict=True))
    print(f"{good} of {len(took)} at 0 V by the supervisor, before any other guard: {said}")
    return 0 if good == len(took) else 1


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--group", action="store_true", help="the whole process group of the owner")
    parser.add_argument("--also-supervisor", action="store_true")
    parser.add_argument("--freeze", action="store_true", help="stop it (SIGSTOP), do not kill it")
    parser.add_argument("--local", action="store_true", help="as with the driver on one's own machine")
    parser.add_argument("--watchdog-s", type=float, default=0.4, help="of the device, where it is what is left")
    parser.add_argument("--no-watchdog", action="store_true")
    parser.add_argument("--burst-s", type=float, default=59.9)
    parser.add_argument("--by-whom", action="store_true", help="judge by who ended the output, not by how soon")
    parser.add_argument("--own", default="", help=argparse.SUPPRESS)
    parser.add_argument("--folder", type=Path, help=argparse.SUPPRESS)
    how = parser.parse_args()
    if how.by_whom and (how.also_supervisor or not how.group):
        parser.error("--by-whom asks what the supervisor did when the owner's group was hit: with --group")
    if how.own:
        own(how.own, how.folder)
        return 0
    rig = parse_rig((files("modallab.cli") / "link_rig.yaml").read_text(encoding="utf-8"), "the demo's rig")
    rig = rig.model_copy(update={"excitation": excitation_of(how)})
    # A device without a watchdog, where one may do without.
    system = "6211" if how.local and how.no_watchdog else "9215"
    options = ["--pace", *(["--local"] if how.local else [])]
    with NiServer(rig, system, *options, virtual=False) as server, tempfile.TemporaryDirectory() as folder:
        server.say("preamplifiers sine")
        trial = Trial(server, OUTPUTS[system], rig, long_burst(how.burst_s), how)
        took: list[float] = []
        for n in range(2 * how.kills + ATTEMPTS):
            if len(took) == how.kills:
                break
            try:
                took.append(trial.once(Path(folder) / str(n)))
            except TimeoutError as error:
                # A machine so busy that a guard ended the burst before anybody was killed says nothing on kills.
                print(f"not counted, no burst to be killed in: {error}", flush=True)
            else:
                print(f"{len(took)}: {took[-1]:.3f} s", flush=True)
    return by_whom(took, trial.noted, how) if how.by_whom else report(took, how)


if __name__ == "__main__":
    sys.exit(main())
