"""Causes that nobody has modelled, put into records of the simulated bench as built: is a wrong name given?

    python benchmarks/gap/never_met.py --seed 4242 --out FILE [--only KIND ...] [--trials 1]

Neither the catalogue nor the simulator knows them: most act on single records, on one test, or on two channels at once.
Each is drawn by a seed, large beside the tolerances. Right is the verdict "unknown"; "no gap" is a miss; a name of the
catalogue above 0.9 is wrong. Writes a row a trial; trials that are there already are not made again.
"""

import argparse
import csv
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.signal import butter, iirnotch, lfilter

from modallab.blind.draw import TrialDraw, draw_rig, make_trial, with_changed_mounting
from modallab.blind.trial_bench import trial_bench
from modallab.core.arrays import Real
from modallab.core.block import Block, Campaign
from modallab.core.rig import Tolerance
from modallab.gap.diagnosis import diagnose

COLUMNS = ("kind", "seed", "verdict", "names", "probabilities", "gap_without_effects", "gap_after", "stage", "seconds")


@dataclass(frozen=True, slots=True)
class Draw:
    """What a cause is drawn by.

    Attributes:
        channel: of a response, not that of the driven point.
        other: of another response.
        size: log-uniform from 1 to 8, times the smallest that a kind has.
        records: one number a record, standard normal.
    """

    channel: int
    other: int
    size: float
    records: Real


Samples = Callable[[Real, Block, Draw, int], Real]


def crosstalk(y: Real, block: Block, d: Draw, n: int) -> Real:
    y[d.channel] += 0.03 * d.size * y[d.other]
    return y


def force_on_all_responses(y: Real, block: Block, d: Draw, n: int) -> Real:
    y[1:] += 0.01 * d.size * y[0] * np.max(np.abs(y[1:])) / np.max(np.abs(y[0]))
    return y


def squared_sensor(y: Real, block: Block, d: Draw, n: int) -> Real:
    y[d.channel] += 0.03 * d.size * y[d.channel] ** 2 / 0.5
    return y


def loose_connector(y: Real, block: Block, d: Draw, n: int) -> Real:
    y[d.channel] *= 1 + 0.03 * d.size * d.records[n]
    return y


def sign_in_sines_only(y: Real, block: Block, d: Draw, n: int) -> Real:
    y[d.channel] *= -1 if block.test == "sine" else 1
    return y


def second_order_filter(y: Real, block: Block, d: Draw, n: int) -> Real:
    y[d.channel] = lfilter(*butter(2, 1200 / d.size / (block.rate_hz / 2) / 4), y[d.channel])
    return y


def notch(y: Real, block: Block, d: Draw, n: int) -> Real:
    y[d.channel] = lfilter(*iirnotch(110.0, 2.0, block.rate_hz), y[d.channel])
    return y


def base_strain(y: Real, block: Block, d: Draw, n: int) -> Real:
    at = min(max(d.channel, 2), len(y) - 2)
    y[at] += 0.05 * d.size * (y[at - 1] - 2 * y[at] + y[at + 1])
    return y


def cable_whip(y: Real, block: Block, d: Draw, n: int) -> Real:
    if block.test == "impact":
        t = np.arange(y.shape[1]) / block.rate_hz
        began = t[int(np.argmax(np.abs(y[0])))]
        after = np.where(t > began, np.exp(-(t - began) / 0.08), 0.0)
        y[d.channel] += 0.03 * d.size * np.max(np.abs(y[d.channel])) * after * np.sin(2 * np.pi * 17 * (t - began))
    return y


def slew_limit(y: Real, block: Block, d: Draw, n: int) -> Real:
    steps = np.diff(y[d.channel], prepend=y[d.channel, 0])
    most = np.quantile(np.abs(steps), 1 - 0.003 * d.size)
    out = np.empty_like(y[d.channel])
    at = y[d.channel, 0]
    for i, wanted in enumerate(y[d.channel]):
        at += float(np.clip(wanted - at, -most, most))
        out[i] = at
    y[d.channel] = out
    return y


def force_filter(y: Real, block: Block, d: Draw, n: int) -> Real:
    y[0] = lfilter(*butter(2, 1600 / d.size / (block.rate_hz / 2) / 2), y[0])
    return y


def swap_in_sines_only(y: Real, block: Block, d: Draw, n: int) -> Real:
    if block.test == "sine":
        y[[d.channel, d.other]] = y[[d.other, d.channel]]
    return y


def coarse_converter(y: Real, block: Block, d: Draw, n: int) -> Real:
    step = 0.004 * d.size * np.max(np.abs(y[d.channel]))
    y[d.channel] = step * np.round(y[d.channel] / step)
    return y


def joined_cables(y: Real, block: Block, d: Draw, n: int) -> Real:
    y[[d.channel, d.other]] = np.mean(y[[d.channel, d.other]], axis=0)
    return y


def window_on_hits(y: Real, block: Block, d: Draw, n: int) -> Real:
    if block.test == "impact":
        y *= np.exp(-np.arange(y.shape[1]) / block.rate_hz * 0.5 * d.size)
    return y


def echo(y: Real, block: Block, d: Draw, n: int) -> Real:
    late = int(0.004 * block.rate_hz)
    y[d.channel, late:] += 0.05 * d.size * y[d.channel, :-late].copy()
    return y


def common_high_pass_in_hits(y: Real, block: Block, d: Draw, n: int) -> Real:
    if block.test == "impact":
        y[1:] = lfilter(*butter(1, 1.0 * d.size / (block.rate_hz / 2), "high"), y[1:])
    return y


def averaged_pairs(y: Real, block: Block, d: Draw, n: int) -> Real:
    y[d.channel, 1:] = 0.5 * (y[d.channel, 1:] + y[d.channel, :-1].copy())
    return y


def dead_zone(y: Real, block: Block, d: Draw, n: int) -> Real:
    wide = 0.003 * d.size * np.max(np.abs(y[d.channel]))
    y[d.channel] = np.sign(y[d.channel]) * np.maximum(np.abs(y[d.channel]) - wide, 0.0)
    return y


KINDS: dict[str, Samples] = {
    kind.__name__: kind
    for kind in (
        crosstalk,
        force_on_all_responses,
        squared_sensor,
        loose_connector,
        sign_in_sines_only,
        second_order_filter,
        notch,
        base_strain,
        cable_whip,
        slew_limit,
        force_filter,
        swap_in_sines_only,
        coarse_converter,
        joined_cables,
        window_on_hits,
        echo,
        common_high_pass_in_hits,
        averaged_pairs,
        dead_zone,
    )
}
PARTS: dict[str, tuple[str, Callable[[Block, int, int], bool]]] = {
    "mass_in_hits_only": ("added_mass", lambda block, n, of: block.test == "impact"),
    "mass_in_last_third": ("added_mass", lambda block, n, of: n > 2 * of / 3),
    "spring_in_sines_only": ("ground_spring", lambda block, n, of: block.test == "sine"),
    "damper_in_every_second_record": ("local_damper", lambda block, n, of: n % 2 == 0),
    "crack_in_last_half": ("stiffness_loss", lambda block, n, of: n > of / 2),
    "clamp_in_hits_only": ("clamp_rotation", lambda block, n, of: block.test == "impact"),
}
"""Effects that are there in a part of the records only: by name, and in which."""


def made(kind: str, seed: int) -> Campaign:
    """A campaign of the bench as built with a cause that nobody has modelled."""
    if kind in PARTS:
        return _in_part(kind, seed)
    sound = make_trial(TrialDraw(kind, "none", seed, "usual"), later=False).campaign
    chance = np.random.default_rng([seed, 991])
    channel, other = chance.choice(np.arange(1, len(sound.rig.channels)), 2, replace=False)
    d = Draw(int(channel), int(other), float(8 ** chance.uniform()), chance.standard_normal(len(sound.blocks)))
    return replace(sound, blocks=tuple(_changed(b, KINDS[kind], d, n) for n, b in enumerate(sound.blocks)))


def _changed(block: Block, kind: Samples, d: Draw, n: int) -> Block:
    """A record with the cause in it, on the converter's counts as before."""
    scale = np.asarray(block.scale)[:, None]
    moved = kind(block.samples * scale, block, d, n) / scale
    if np.issubdtype(block.samples.dtype, np.integer):
        limits = np.iinfo(block.samples.dtype)
        moved = np.clip(np.round(moved), limits.min, limits.max)
    return replace(block, samples=moved.astype(block.samples.dtype))


def _in_part(kind: str, seed: int) -> Campaign:
    effect, there = PARTS[kind]
    bench = trial_bench()
    rig = with_changed_mounting(draw_rig(seed).model_copy(update={"tolerance": Tolerance.usual()}), seed)
    drawn = bench.draw_effect(rig, seed, effect, 300.0).effect
    without, having = (bench.make_trial(rig, seed, e, "usual")[0] for e in ((), (drawn,)))
    pairs = enumerate(zip(without.blocks, having.blocks, strict=True))
    blocks = (h if there(h, n, len(having.blocks)) else w for n, (w, h) in pairs)
    return replace(without, blocks=tuple(blocks))


def answered(kind: str, seed: int) -> dict[str, object]:
    campaign, began = made(kind, seed), time.process_time()
    try:
        said = diagnose(campaign)
    except Exception as error:
        return {"kind": kind, "seed": seed, "verdict": f"error: {error}"}
    return {
        "kind": kind,
        "seed": seed,
        "verdict": said.verdict,
        "names": "+".join(f.effect for f in said.effects),
        "probabilities": " ".join(f"{f.probability:.3f}" for f in said.effects),
        "gap_without_effects": round(said.shrink.before, 3),
        "gap_after": round(said.shrink.after, 3),
        "stage": said.where.stage,
        "seconds": round(time.process_time() - began, 1),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--trials", type=int, default=1, help="of each kind")
    parser.add_argument("--only", nargs="*", default=[*KINDS, *PARTS])
    parser.add_argument("--out", type=Path, required=True)
    a = parser.parse_args()
    there: set[tuple[str, int]] = set()
    if a.out.exists():
        with a.out.open(encoding="utf-8", newline="") as source:
            there = {(row["kind"], int(row["seed"])) for row in csv.DictReader(source)}
    listed = [(kind, a.seed + n) for n in range(a.trials) for kind in a.only]
    for kind, seed in listed:
        if (kind, seed) not in there:
            row, new = answered(kind, seed), not a.out.exists()
            with a.out.open("a", encoding="utf-8", newline="") as target:
                writer = csv.DictWriter(target, COLUMNS, lineterminator="\n")
                if new:
                    writer.writeheader()
                writer.writerow(row)
            print(row, flush=True)


if __name__ == "__main__":
    main()
