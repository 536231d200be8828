"""Stops a burst at random moments, in every way there is while the device answers, and looks at the output's trace.

Ways: the bench's own `zero`, `stop` and `close`; the second handle of the supervisor; the death of the acquisition
process, with a server that keeps the burst; the simulated cantilever's `zero`.

    python benchmarks/stop_ramp.py --stops 20
"""

import argparse
import os
import signal
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from functools import partial
from importlib.resources import files
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "helpers"))

from ni_server import NiServer
from stop_trace import HOLD, RATE_HZ, Stop, seen

from modallab.acquisition.process.rig_process import RigProcess
from modallab.bench.loader import open_bench, open_output
from modallab.bench.protocol import AcquisitionRequest, Burst
from modallab.core.errors import ModallabError
from modallab.core.plan import SinePlan
from modallab.core.rig import Rig
from modallab.formats.rig.rig_file import parse_rig
from modallab_simulators.cantilever.excitation import BurstOutput

FREQUENCIES_HZ = (5.0, 20.0, 110.0, 450.0)
LEVELS_V = (0.1, 1.0, 5.0)
MOST_PER_MS = 0.05
MOST_V_HZ = 700.0
"""The rig's slew limit over 2 pi, with some room."""
TRACE_S = 0.4

Stopper = Callable[[NiServer, Rig, Burst, float], Stop]


def traced(server: NiServer, burst: Burst) -> Stop:
    time.sleep(0.1)
    volts = np.array(server.say(f"trace {TRACE_S} {RATE_HZ}")["volts"])
    return seen(volts, burst.frequency_hz, burst.amplitude_v)


def by_bench(way: str, server: NiServer, rig: Rig, burst: Burst, after_s: float) -> Stop:
    bench = open_bench(server.url, rig)
    try:
        bench.configure(AcquisitionRequest("sine", 2000.0))
        bench.start()
        bench.play(burst)
        bench.read(round(2000 * after_s), 5.0)
        getattr(bench, way)()
        return traced(server, burst)
    finally:
        bench.close()


def by_supervisor(server: NiServer, rig: Rig, burst: Burst, after_s: float) -> Stop:
    bench, handle = open_bench(server.url, rig), open_output(server.url, rig)
    assert handle is not None
    try:
        bench.configure(AcquisitionRequest("sine", 2000.0))
        bench.start()
        bench.play(burst)
        bench.read(round(2000 * after_s), 5.0)
        handle.zero()
        return traced(server, burst)
    finally:
        handle.close()
        bench.close()


def by_death(server: NiServer, rig: Rig, burst: Burst, after_s: float) -> Stop:
    plan = SinePlan(
        frequencies_hz=(burst.frequency_hz,), levels_v={"one": burst.amplitude_v}, ramp_s=burst.ramp_s, settle_s=18.0,
        block_s=0.256, wait_s=0.2, settle_timeout_s=0.2, rate_hz=2000.0,
    )  # fmt: skip
    with tempfile.TemporaryDirectory() as folder, RigProcess(server.url, rig, Path(folder)) as process:
        runner = threading.Thread(target=drain, args=(process, plan))
        runner.start()
        while server.say("levels 0.05")["cDAQ1Mod4/ao0"] == 0.0:
            time.sleep(0.01)
        time.sleep(after_s)
        assert process.process.pid is not None
        os.kill(process.process.pid, signal.SIGKILL)
        time.sleep(0.2)
        found = traced(server, burst)
        runner.join()
    return found


def by_cantilever(server: NiServer, rig: Rig, burst: Burst, after_s: float) -> Stop:
    times = np.arange(0.0, after_s + 0.2, 1 / RATE_HZ)
    # It falls at once, where a device holds for a moment: the hold is put in for the same look at it.
    volts = BurstOutput(burst, 0.0, 0.0).cut(after_s).volts(times)
    stop = int(np.searchsorted(times, after_s))
    return seen(np.insert(volts, stop, np.full(2 * HOLD, volts[stop])), burst.frequency_hz, burst.amplitude_v)


def drain(process: RigProcess, plan: SinePlan) -> None:
    try:
        for _ in process.run(plan):
            pass
    except ModallabError:
        return


WAYS: dict[str, Stopper] = {
    "zero": partial(by_bench, "zero"),
    "stop": partial(by_bench, "stop"),
    "close": partial(by_bench, "close"),
    "supervisor": by_supervisor,
    "death": by_death,
    "simulated bench": by_cantilever,
}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stops", type=int, default=20, help="of each way")
    parser.add_argument("--ways", nargs="*", choices=sorted(WAYS), default=sorted(WAYS))
    parser.add_argument("--seed", type=int, default=1)
    how = parser.parse_args()
    rng = np.random.default_rng(how.seed)
    rig = parse_rig((files("modallab.cli") / "link_rig.yaml").read_text(encoding="utf-8"), "the demo's rig")
    good = True
    with NiServer(rig, "9215", "--pace", virtual=False) as server:
        server.say("preamplifiers sine")
        for way in how.ways:
            stops: list[Stop] = []
            for _ in range(how.stops):
                frequency_hz, level_v = float(rng.choice(FREQUENCIES_HZ)), float(rng.choice(LEVELS_V))
                burst = Burst(frequency_hz, min(level_v, MOST_V_HZ / frequency_hz), 0.2, 20.0)
                stops.append(WAYS[way](server, rig, burst, float(rng.uniform(0.05, 0.6))))
            within = sum(s.jump == 0 and s.per_ms <= MOST_PER_MS and s.end_v == 0 for s in stops)
            good = good and within == len(stops)
            print(
                f"{way}: {within} of {len(stops)} below {MOST_PER_MS:.0%} of the level a ms;"
                f" steepest {max(s.per_ms for s in stops):.2%}, largest jump {max(s.jump for s in stops):.2%},"
                f" stop to 0 V median {1e3 * float(np.median([s.took_s for s in stops])):.0f} ms,"
                f" longest {1e3 * max(s.took_s for s in stops):.0f} ms",
                flush=True,
            )
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
