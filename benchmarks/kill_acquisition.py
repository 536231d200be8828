"""Kills the acquisition process at random moments of a run and looks for every block it had acknowledged.

The client keeps the name, the CRC-32 and the order of what was acknowledged to it. After each kill the folder is opened
again; every acknowledged block must be there, with that CRC-32, and equal bit for bit to the same block of a run that
nobody killed (the simulated bench repeats itself by its seed).

    python benchmarks/kill_acquisition.py --kills 50
"""

import argparse
import random
import sys
import tempfile
import threading
import time
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path

import numpy as np

from modallab.acquisition.process.rig_process import RigProcess
from modallab.acquisition.process.run import record_run
from modallab.bench.loader import open_bench
from modallab.core.block import Block
from modallab.core.errors import BenchError
from modallab.core.events import BlockAcknowledged
from modallab.core.plan import ImpactPlan, Plan, SinePlan
from modallab.core.rig import Rig
from modallab.formats.rig.rig_file import read_rig
from modallab.storage import Store

URL = "sim://cantilever?seed=1&zeta=0.01"


def plans(hits: int, frequencies: int) -> tuple[Plan, ...]:
    """An impact test of so many hits at each of three points, and a sine test of so many frequencies."""
    return (
        ImpactPlan(points=(10, 6, 3), hits=hits),
        # Hardly any rest: about a third of this run's time goes into writing, so many kills fall into a write.
        SinePlan(frequencies_hz=tuple(3.0 + 0.5 * n for n in range(frequencies)), ramp_s=0.2, settle_s=0.3, wait_s=0.1),
    )


@dataclass
class Tally:
    """What was found over all kills."""

    kills: int = 0
    too_late: int = 0
    acknowledged: int = 0
    committed: int = 0
    wrong: list[str] = field(default_factory=list)


def main() -> int:
    """Kill, look, report; 0 if nothing was lost."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1, help="of the moments")
    parser.add_argument("--hits", type=int, default=5, help="at each point")
    parser.add_argument("--frequencies", type=int, default=100)
    arguments = parser.parse_args()
    chance = random.Random(arguments.seed)
    rig = read_rig(Path(str(resources.files("modallab.cli") / "link_rig.yaml")))
    tally, both = Tally(), plans(arguments.hits, arguments.frequencies)
    with tempfile.TemporaryDirectory() as folder:
        whole = [run_whole(rig, plan, Path(folder) / f"whole{n}") for n, plan in enumerate(both)]
        attempt = 0
        while tally.kills < arguments.kills:
            plan, (blocks, took_s) = both[attempt % 2], whole[attempt % 2]
            # A block of the run, then a moment until the next: so it falls into the run however busy the machine is.
            moment = (chance.randrange(len(blocks)), chance.uniform(0, took_s / len(blocks)))
            kill_once(rig, plan, Path(folder) / f"kill{attempt}", moment, blocks, tally)
            attempt += 1
    print(
        f"{tally.kills} kills during runs (and {tally.too_late} after the end): "
        f"{tally.acknowledged} blocks acknowledged, "
        f"{tally.committed} committed, {len(tally.wrong)} lost or different"
    )
    print(*tally.wrong, sep="\n")
    return 1 if tally.wrong else 0


def run_whole(rig: Rig, plan: Plan, folder: Path) -> tuple[dict[str, Block], float]:
    """All blocks of a run nobody kills, by name, and the seconds it took."""
    with Store(folder) as store:
        begin = time.monotonic()
        run = record_run(open_bench(URL, rig), rig, plan, store, lambda _: None)
        took_s = time.monotonic() - begin
        return {block.name: block for block in store.iterate_blocks(run, rejected=True)}, took_s


def kill_once(
    rig: Rig, plan: Plan, folder: Path, moment: tuple[int, float], whole: dict[str, Block], tally: Tally
) -> None:
    """Kill one run so many seconds after so many blocks, and compare what is left with what was acknowledged."""
    received: list[BlockAcknowledged] = []
    with RigProcess(URL, rig, folder) as process:
        timer = threading.Timer(moment[1], process.process.kill)
        try:
            for event in process.run(plan):
                if len(received) == moment[0] and timer.ident is None:
                    timer.start()
                if isinstance(event, BlockAcknowledged):
                    received.append(event)
        except BenchError:
            tally.kills += 1
        else:
            tally.too_late += 1
        timer.join()
    tally.acknowledged += len(received)
    compare(folder, received, whole, tally)


def compare(folder: Path, received: list[BlockAcknowledged], whole: dict[str, Block], tally: Tally) -> None:
    """Add to the tally what is lost or different in a folder."""
    with Store(folder) as store:
        for run in store.catalogue.runs():
            rows = {row.n: row for row in store.catalogue.blocks(run.id)}
            kept = {block.order: block for block in store.iterate_blocks(run.id, rejected=True)}
            tally.committed += len(kept)
            if run.state not in ("failed", "done"):
                tally.wrong.append(f"{run.id} is {run.state}")
            tally.wrong += [f"{run.id} {b.name} differs" for b in kept.values() if not same(b, whole[b.name])]
            for ack in received:
                if ack.n not in kept or rows[ack.n].crc32 != ack.crc32 or kept[ack.n].name != ack.name:
                    tally.wrong.append(f"{run.id} {ack.name} was acknowledged and is not there")


def same(one: Block, other: Block) -> bool:
    """Whether two blocks hold the same bits from the same place."""
    return one.first_sample == other.first_sample and bool(np.array_equal(one.samples, other.samples))


if __name__ == "__main__":
    sys.exit(main())
