"""How much the gRPC route carries: real time for a while, every sample looked at.

Every input of the simulated devices hangs on a ramp of one nanovolt a sample, so that a lost or doubled sample is seen.

    python benchmarks/grpc_route.py --seconds 60                             # 11 channels at 2 kHz
    python benchmarks/grpc_route.py --channels 64 --rate 51200 --seconds 60
"""

import argparse
import resource
import sys
import time
from importlib.resources import files
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "helpers"))

from ni_server import NiServer

from modallab.bench.loader import open_bench
from modallab.bench.protocol import AcquisitionRequest
from modallab.core.rig import Rig
from modallab.formats.rig.rig_file import parse_rig

STEP_V = 1e-9


CARDS = ",".join(f"PXI1Slot{slot}" for slot in range(2, 6))


def rig_of(channels: int) -> Rig:
    rig = parse_rig((files("modallab.cli") / "link_rig.yaml").read_text(encoding="utf-8"), "the demo's rig")
    more = [
        rig.channels[1].model_copy(update={"index": n, "name": f"c{n:02d}", "range_v": 5.0}) for n in range(1, channels)
    ]
    first = rig.channels[0].model_copy(update={"range_v": 5.0})
    return rig.model_copy(update={"channels": (first, *more), "shaker_point": None})


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--channels", type=int, default=11)
    parser.add_argument("--rate", type=float, default=2000.0)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--chunk-s", type=float, default=0.1)
    arguments = parser.parse_args()
    rig = rig_of(arguments.channels)
    with NiServer(rig, "64", "--pace", "--cables", device=CARDS, virtual=False) as server:
        bench = open_bench(server.url, rig)
        delivery = bench.configure(AcquisitionRequest("impact", arguments.rate))
        bench.start()
        count, wrong, next_ = round(arguments.chunk_s * delivery.rate_hz), 0, 0
        began, busy = time.monotonic(), used()
        while next_ < arguments.seconds * delivery.rate_hz:
            chunk = bench.read(count, 10.0)
            ramp = np.rint(chunk.samples[[0, -1]] / STEP_V)
            wrong += int(np.any(np.diff(ramp, axis=1) != 1)) + (chunk.first_sample != next_)
            next_ += count
        took, share = time.monotonic() - began, used() - busy
        bench.close()
    server_share = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(
        f"{arguments.channels} channels at {delivery.rate_hz:g} Hz: {next_} samples each in {took:.1f} s,"
        f" {wrong} gaps; {100 * share / took:.0f} % of a core here,"
        f" {100 * (server_share.ru_utime + server_share.ru_stime) / took:.0f} % in the simulated server"
    )
    return 1 if wrong else 0


def used() -> float:
    mine = resource.getrusage(resource.RUSAGE_SELF)
    return mine.ru_utime + mine.ru_stime


if __name__ == "__main__":
    sys.exit(main())
