"""How many times faster than real time the simulated bench runs, in processor time of one thread.

    OPENBLAS_NUM_THREADS=1 python benchmarks/simulated_bench.py

Eleven channels, read in pieces of 100 ms as an acquisition does. `at rest` and `ringing`: nothing excites. `impact
test`: a hit every 4 s. `driven`: the shaker never pauses. `sine test`: 1 kHz, bursts of 11 s, 10 s of rest between.
"""

import argparse
import time
from collections.abc import Callable
from importlib.resources import files

from modallab.bench.protocol import AcquisitionRequest, Bench, Burst
from modallab.formats.rig.rig_file import parse_rig
from modallab_simulators.cantilever import open_bench

Procedure = Callable[[Bench, float, float], None]


def read(bench: Bench, rate_hz: float, seconds: float) -> None:
    for _ in range(round(10 * seconds)):
        bench.read(round(rate_hz / 10), 1.0)


def rest(bench: Bench, rate_hz: float, seconds: float) -> None:
    read(bench, rate_hz, seconds)


def ring(bench: Bench, rate_hz: float, seconds: float) -> None:
    bench.prompt_hit(10)
    read(bench, rate_hz, seconds)


def impact(bench: Bench, rate_hz: float, seconds: float) -> None:
    for _ in range(round(seconds / 4)):
        bench.prompt_hit(6)
        read(bench, rate_hz, 4)


def drive(bench: Bench, rate_hz: float, seconds: float) -> None:
    bench.play(Burst(20.0, 0.5, 1.0, seconds))
    read(bench, rate_hz, seconds)


def sine(bench: Bench, rate_hz: float, seconds: float) -> None:
    for _ in range(round(seconds / 21)):
        bench.play(Burst(20.0, 0.5, 1.0, 9.0))
        read(bench, rate_hz, 21)


PROCEDURES: dict[str, tuple[Procedure, AcquisitionRequest]] = {
    "at rest": (rest, AcquisitionRequest("impact", 2000.0)),
    "ringing": (ring, AcquisitionRequest("impact", 2000.0)),
    "impact test": (impact, AcquisitionRequest("impact", 2000.0)),
    "driven": (drive, AcquisitionRequest("impact", 2000.0)),
    "sine test": (sine, AcquisitionRequest("sine", 1000.0)),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=420.0, help="bench time a procedure")
    seconds = parser.parse_args().seconds
    path = files("modallab.cli") / "link_rig.yaml"
    rig = parse_rig(path.read_text(encoding="utf-8"), str(path))
    for name, (procedure, request) in PROCEDURES.items():
        bench = open_bench("sim://cantilever?seed=1", rig)
        bench.configure(request)
        bench.start()
        began = time.process_time()
        procedure(bench, request.rate_hz, seconds)
        print(f"{name:12} {request.rate_hz:6.0f} Hz  {seconds / (time.process_time() - began):7.0f} times real time")
        bench.close()


if __name__ == "__main__":
    main()
