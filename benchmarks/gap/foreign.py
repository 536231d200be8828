"""Simulators with one hidden defect held against sound benches: is the defect named?

    python benchmarks/gap/foreign.py --trials 40 --none 4 --seed 151515 --out F.jsonl

Each bench is sound, ideal or as labs build them in turn. A simulator of the same rig (see `foreign_bench.py`) has one
linear effect of the catalogue, as large as in `modallab gap blind`; its records and the campaign are compared as
`modallab gap diagnose C --simulation PRED.h5` does. What a simulator cannot have is left out: noise, hum, clipping,
drift, a clock, what shakes the floor or rings on. A sound simulator must come out with no effect. What F holds is not
done again.
"""

import argparse
import json
import time
from pathlib import Path
from typing import Any

import numpy as np
from foreign_bench import Simulator

from modallab.blind.draw import TrialDraw, make_trial
from modallab.blind.trial_bench import trial_bench
from modallab.core.effects import Effect
from modallab.gap.simulations.compare import compare_simulation

EFFECTS = (
    *("clamp_rotation", "clamp_translation", "added_mass", "sensor_mass", "stiffness_loss", "ground_spring"),
    *("local_damper", "gain_error", "polarity", "swap", "position_error", "ac_coupling", "loose_mount", "force_gain"),
    *("channel_skew", "trigger_delay", "hit_position", "stinger_moment", "shaker_mass"),
)
NONE = "none"


def listed(trials: int, none: int, seed: int) -> list[TrialDraw]:
    """The trials in turn, effects in an order that the seed draws."""
    order = [str(name) for name in np.random.default_rng([seed, 15]).permutation(EFFECTS)]
    names = [order[k % len(order)] for k in range(trials)] + [NONE] * none
    # Each effect meets an ideal bench and one as built in turn.
    built = [("none", "usual")[(k + k // len(order)) % 2] for k in range(len(names))]
    return [
        TrialDraw(f"t{k:03d}", name, seed * 1000 + k, of) for k, (name, of) in enumerate(zip(names, built, strict=True))
    ]


def trial(draw: TrialDraw) -> dict[str, Any]:
    """One trial: what is hidden, and what is said of it."""
    made = make_trial(draw, later=False)
    hidden = [_effect(e) for e in made.truth["effects"]]
    rig = made.campaign.rig
    campaign, _ = trial_bench().make_trial(rig, draw.seed, (), draw.tolerances)
    records = Simulator(rig, tuple(hidden), draw.seed + 500_000).records(campaign)
    begun = time.process_time()
    found = compare_simulation(campaign, records)
    return {
        "name": draw.name,
        "tolerances": draw.tolerances,
        "truth": [e.model_dump(mode="json") for e in hidden],
        "drawn": {k: made.truth[k] for k in ("gap", "moves") if k in made.truth},
        "seconds": time.process_time() - begun,
        "said": found.model_dump(mode="json"),
    }


def _effect(reported: dict[str, Any]) -> Effect:
    return Effect(effect=reported["effect"], parameters=reported["parameters"], place=reported["place"])


def named(entry: dict[str, Any]) -> list[str]:
    """What is said to be in the simulation alone, in the bench alone, or in both otherwise."""
    said = entry["said"]
    lacks = [f"-{f['effect']}" for f in said["lacks"]]
    return [f["effect"] for f in said["has"]] + lacks + [f"~{d['bench']['effect']}" for d in said["differs"]]


def right(entry: dict[str, Any]) -> bool:
    """Whether the hidden effect and no other is named; of a sound simulator, whether none is."""
    return named(entry) == [e["effect"] for e in entry["truth"]]


def row(entry: dict[str, Any]) -> str:
    """One trial in words."""
    said, truth = entry["said"], "".join(e["effect"] for e in entry["truth"]) or NONE
    numbers = entry["truth"][0]["parameters"] if entry["truth"] else {}
    found = [f"{f['effect']} {f['parameters']}" for f in said["has"]]
    return (
        f"{entry['name']} {entry['tolerances']:5s} {'right' if right(entry) else 'WRONG'} {truth:18s} "
        f"{'+'.join(named(entry)) or said['verdict']:30s} {said['before']:8.2f} {said['after']:7.2f} "
        f"{entry['seconds']:6.1f} s {numbers} {'; '.join(found)} "
        f"[{said['bench']['verdict']}, {said['simulation']['verdict']}]"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=40, help="with a hidden defect")
    parser.add_argument("--none", type=int, default=4, help="sound simulators")
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--minutes", type=float, default=60.0, help="no trial is begun after these")
    a = parser.parse_args()
    there = [json.loads(line) for line in a.out.read_text().splitlines()] if a.out.exists() else []
    done, end = {e["name"] for e in there}, time.monotonic() + 60 * a.minutes
    for entry in there:
        print(row(entry))
    for draw in listed(a.trials, a.none, a.seed):
        if draw.name in done or time.monotonic() > end:
            continue
        there.append(trial(draw))
        with a.out.open("a") as target:
            target.write(json.dumps(there[-1]) + "\n")
        print(row(there[-1]), flush=True)
    for kind in ("none", "usual"):
        hidden = [right(e) for e in there if e["truth"] and e["tolerances"] == kind]
        sound = [right(e) for e in there if not e["truth"] and e["tolerances"] == kind]
        print(f"tolerances {kind}: named {sum(hidden)} of {len(hidden)}, sound {sum(sound)} of {len(sound)}")
    seconds = [e["seconds"] for e in there]
    print(f"processor seconds: median {np.median(seconds):.1f}, worst {max(seconds):.1f}")


if __name__ == "__main__":
    main()
