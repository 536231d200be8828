"""Whether a busy machine makes the service believe that its REST process is frozen, while a sine test drives.

Beside the service, processes that never rest, and a client that asks all the time. A false alarm aborts the run.

    python benchmarks/heartbeat.py --busy 8 --minutes 5
"""

import argparse
import multiprocessing
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "helpers"))

from service_process import ServiceProcess

from modallab.core.documents.runs import AbortRun
from modallab.core.plan import SinePlan

DRIVE = SinePlan(frequencies_hz=tuple(19.0 + n / 4 for n in range(400)), settle_s=2.0, ramp_s=0.5, wait_s=0.5)
ENDED = ("done", "failed", "aborted")


def never_rest() -> None:
    while True:
        pass


def watch(service: ServiceProcess, minutes: float) -> tuple[int, int]:
    """(times the run was aborted by itself, requests answered)."""
    lab, alarms, asked = service.client, 0, 0
    campaign = lab.create_campaign("busy", service.rig).id
    end = time.monotonic() + 60 * minutes
    with lab.take_lease(service.rig, "Ada", ttl_s=3600) as lease:
        while time.monotonic() < end:
            run = lab.start_run(campaign, DRIVE, lease).id
            while (view := lab.run(run)).state not in ENDED and time.monotonic() < end:
                asked += 1
            if view.state in ENDED:
                alarms += 1
                trip = lab.rig(service.rig).trip
                print(f"{view.state}: {view.reason}; {trip.reason if trip else 'not tripped'}", flush=True)
                lab.reset_rig(service.rig, lease, "false alarm")
                lab.wait_until_idle(service.rig)
            else:
                lab.command_run(run, AbortRun(), lease)
    return alarms, asked


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--busy", type=int, default=8)
    parser.add_argument("--minutes", type=float, default=5.0)
    arguments = parser.parse_args()
    bench = "sim://cantilever?seed=1&zeta=0.05&pace=1"
    with (
        tempfile.TemporaryDirectory() as folder,
        ServiceProcess(Path(folder) / "data", "--no-jobs", bench=bench) as service,
    ):
        busy = [multiprocessing.Process(target=never_rest, daemon=True) for _ in range(arguments.busy)]
        for process in busy:
            process.start()
        try:
            alarms, asked = watch(service, arguments.minutes)
        finally:
            for process in busy:
                process.kill()
                process.join()
    print(f"{arguments.busy} busy processes, {arguments.minutes:g} min, {asked} requests: {alarms} false alarms")
    return 0 if alarms == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
