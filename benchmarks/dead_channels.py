"""Lets a channel fail in the middle of a burst and times how long it takes to 0 V; no block of it may count.

    python benchmarks/dead_channels.py --trials 100

Each trial is a sine test of two bursts on the simulated bench, in real time. At a random moment of a random burst, from
a tenth of the full drive on to the end of the hold, the force or an accelerometer dies, freezes, is unplugged, clips,
or changes places with another. `--free` lets time be virtual: the same, counted in samples.
"""

import argparse
import tempfile
import time
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

import numpy as np

from modallab.acquisition.process.child import raise_priority
from modallab.acquisition.process.run import run_plan
from modallab.bench.loader import open_bench
from modallab.bench.protocol import Burst, SampleChunk
from modallab.core.errors import SafetyError
from modallab.core.plan import PAPER_LINES, SinePlan
from modallab.core.rig import Rig
from modallab.formats.rig.rig_file import parse_rig
from modallab.storage import Store
from modallab_simulators.faults import KINDS, ChannelFault, FaultyBench

GOAL_S = 0.3
LOOK_SAMPLES = 300
REST_SAMPLES = 1000
BURSTS = 2
RAMP_S = 1.0
VISIBLE = 10.0
"""A channel that moves by less than so many times its noise, had it gone on, cannot be seen to fail; nor can two that
change places and read the same to this."""


class TimedBench(FaultyBench):
    """Knows when the output was brought to 0 V after the fault, on the clock on the wall and in samples."""

    zeroed_s: float | None = None
    zeroed_at: int | None = None
    began_s = 0.0
    next = 0
    row = 0
    swapped_with: int | None = None
    noise = 1.0
    moved = 0.0

    def start(self) -> None:
        super().start()
        self.began_s = time.monotonic()

    def read(self, count: int, timeout_s: float) -> SampleChunk:
        chunk = super().read(count, timeout_s)
        self.next = chunk.first_sample + count
        if self.next < REST_SAMPLES:
            self.noise = float(np.diff(chunk.samples[self.row].astype(float), 2).std() / 6**0.5)
        if self.at is not None and self.at - LOOK_SAMPLES < self.next <= self.at + LOOK_SAMPLES:
            moves = self.sound.astype(float)
            # Of two that change places it is their difference that can be seen.
            change = moves[self.row] if self.swapped_with is None else moves[self.row] - moves[self.swapped_with]
            self.moved = max(self.moved, float(change.std()))
        return chunk

    def play(self, burst: Burst) -> int:
        self.zeroed_s = self.zeroed_at = None
        return super().play(burst)

    def zero(self) -> None:
        super().zero()
        if self.zeroed_at is None:
            self.zeroed_s, self.zeroed_at = time.monotonic() - self.began_s, self.next


@dataclass(frozen=True)
class Outcome:
    """Of one trial.

    Attributes:
        took_s: from the fault to 0 V.
        accepted: blocks with the fault in them that count.
        visible: motion of the channel about the fault, without it, over its noise; if swapped, less the other's.
        what: was said.
    """

    took_s: float
    accepted: int
    visible: float
    what: str


def trial(rig: Rig, seed: int, fault: ChannelFault, *, free: bool) -> Outcome:
    rng = np.random.default_rng(seed)
    lines = rng.choice(PAPER_LINES, BURSTS, replace=False) / 1.024
    plan = SinePlan(
        frequencies_hz=tuple(float(f) for f in lines), levels_v={"low": float(rng.uniform(0.5, 1.5))}, block_s=0.256,
        ramp_s=RAMP_S, settle_s=1.5, wait_s=0.5, settle_timeout_s=3.0,
    )  # fmt: skip
    url = f"sim://cantilever?seed={seed}" + ("" if free else "&pace=1")
    bench = TimedBench(open_bench(url, rig), fault, seed)
    bench.row, bench.swapped_with = fault.channel, fault.other if fault.kind == "swapped" else None
    what, rate_hz = "went on", plan.rate_hz
    with tempfile.TemporaryDirectory() as folder, Store(Path(folder)) as store:
        with store.begin(plan, rig, bench.info) as recorder:
            try:
                run_plan(bench, rig, plan, recorder, lambda _: None, chunk_s=0.02 if free else None)
            except SafetyError as error:
                what = error.what
        assert bench.at is not None
        kept = [row for row in store.catalogue.blocks(recorder.run) if row.note.accepted]
        # Beyond a burst that went on to its end the block of a later one may count too.
        spoilt = [row for row in kept if row.note.first_sample + row.count > bench.at]
    visible = bench.moved / bench.noise
    if what == "went on" or bench.zeroed_at is None or bench.zeroed_s is None:
        return Outcome(float("inf"), len(spoilt), visible, what)
    took_s = (bench.zeroed_at - bench.at) / rate_hz if free else bench.zeroed_s - bench.at / rate_hz
    return Outcome(took_s, len(spoilt), visible, what)


def random_fault(rig: Rig, seed: int) -> ChannelFault:
    rng = np.random.default_rng([seed, 1])
    limited = [c.index for c in rig.channels if c.quantity in ("force", "acceleration")]
    # Half of all faults are the force's.
    channel = rig.force_channel.index if rng.random() < 0.5 else int(rng.choice(limited[1:]))
    other = int(rng.choice([c for c in limited if c != channel]))
    duration = 1.5 + 0.256 + 0.1 + RAMP_S
    # A rise of a cosine reaches a tenth after a fifth of its time.
    part = rng.uniform(0.205 * RAMP_S / duration, 1 - RAMP_S / duration)
    return ChannelFault(
        KINDS[seed % len(KINDS)],
        channel,
        int(rng.integers(1, BURSTS + 1)),
        float(part),
        other,
        float(rng.uniform(0.3, 0.8)),
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=20)
    parser.add_argument("--first", type=int, default=0, help="seed of the first trial")
    parser.add_argument("--free", action="store_true")
    arguments = parser.parse_args()
    rig = parse_rig((files("modallab.cli") / "link_rig.yaml").read_text(encoding="utf-8"), "link_rig.yaml")
    # As a rig's process does.
    print(raise_priority() or "raised priority")
    outcomes: list[Outcome] = []
    hidden = 0
    seed = arguments.first
    while len(outcomes) < arguments.trials:
        fault = random_fault(rig, seed)
        outcome = trial(rig, seed, fault, free=arguments.free)
        bad = outcome.took_s > GOAL_S or outcome.accepted > 0
        if bad:
            name = rig.channels[fault.channel].name
            print(f"{seed}: {fault} ({name}): {outcome}", flush=True)
        if bad and outcome.visible < VISIBLE:
            hidden += 1
        else:
            outcomes.append(outcome)
        seed += 1
    good = sum(o.took_s <= GOAL_S and not o.accepted for o in outcomes)
    print(f"{good} of {len(outcomes)} at 0 V within {GOAL_S} s with no block accepted")
    print(f"{hidden} more failed on a channel that moved by less than {VISIBLE:g} times its noise, and went unseen")
    seen = np.array([o.took_s for o in outcomes if np.isfinite(o.took_s)])
    print(f"median {np.median(seen):.3f} s, p99 {np.quantile(seen, 0.99):.3f} s, longest {seen.max():.3f} s")


if __name__ == "__main__":
    main()
