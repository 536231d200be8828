"""Two effects at once on benches as built: are both named, is one?

    python benchmarks/gap/pairs.py --pairs 16 --seed 171717 --out F.jsonl
    python benchmarks/gap/pairs.py --pairs 6 --seed 171718 --stepped --out F.jsonl

Pairs are drawn as by `modallab gap blind --pairs N --tolerances usual`; those are kept whose effects are both linear,
or with `--stepped` those of a linear one and one that depends on the size of the motion. Of each effect it is said
whether it lies within its tolerance or moves the response by less than the rig file cares for: a diagnosis calls that
no gap. What F holds is not done again.
"""

import argparse
import json
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from modallab.blind.draw import PAIR, TrialDraw, make_trial, pair_names
from modallab.core.effects import Effect, kind_of
from modallab.core.rig import Rig
from modallab.gap.diagnosis import diagnose
from modallab.gap.search.consequence import ABOVE
from modallab.twin.effects import effect_models
from modallab_simulators.cantilever.blind_trials import GapMeter


def drawn(seed: int, stepped: bool) -> Iterator[tuple[TrialDraw, Any]]:
    """Trials of the kind that is asked for, without end."""
    for k in range(10_000):
        draw = TrialDraw(f"p{k:03d}", PAIR, seed * 1000 + k, "usual")
        linear = [kind_of(name).linear for name in pair_names(draw.seed)]
        if all(linear) if not stepped else sum(linear) == 1:
            yield draw, make_trial(draw, later=False)


def below_tolerance(effect: Effect, rig: Rig, seed: int) -> str:
    """Why an effect alone would be no gap on this bench; "" where it is one."""
    search = effect_models()[effect.effect].search
    if search is not None and search.tolerance.deviations(effect, rig) <= ABOVE:
        return "within its tolerance"
    moves = GapMeter(rig, seed).moves((effect,))
    return "" if moves >= rig.tolerance.response else f"moves the response by {moves:.2%}"


def trial(draw: TrialDraw, made: Any) -> dict[str, Any]:
    """One trial: what is there, and what is said."""
    rig = made.campaign.rig
    effects = [_effect(e) for e in made.truth["effects"]]
    begun = time.process_time()
    said = diagnose(made.campaign)
    return {
        "name": draw.name,
        "truth": [e.model_dump(mode="json") | {"small": below_tolerance(e, rig, draw.seed)} for e in effects],
        "seconds": time.process_time() - begun,
        "said": said.model_dump(mode="json"),
    }


def _effect(reported: dict[str, Any]) -> Effect:
    return Effect(effect=reported["effect"], parameters=reported["parameters"], place=reported["place"])


def names(entry: dict[str, Any]) -> tuple[list[str], list[str]]:
    """True names, and those that were said."""
    return sorted(e["effect"] for e in entry["truth"]), sorted(e["effect"] for e in entry["said"]["effects"])


def row(entry: dict[str, Any]) -> str:
    """One trial in words."""
    true, said = names(entry)
    mark = "both " if true == said else "one  " if set(true) & set(said) else "NONE "
    numbers = "; ".join(f"{e['effect']} {e['parameters']} {e['place']} {e['small']}" for e in entry["truth"])
    gap = entry["said"]["gap"]
    words = f"{'+'.join(said) or entry['said']['verdict']:32s} {gap['before']:8.1f} {gap['after']:7.2f}"
    return f"{entry['name']} {mark} {words} {entry['seconds']:6.1f} s {numbers}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=int, default=16)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--stepped", action="store_true", help="one of the two depends on the size of the motion")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--minutes", type=float, default=60.0, help="no trial is begun after these")
    a = parser.parse_args()
    there = [json.loads(line) for line in a.out.read_text().splitlines()] if a.out.exists() else []
    print("\n".join(map(row, there)))
    done, end = {e["name"] for e in there}, time.monotonic() + 60 * a.minutes
    for draw, made in drawn(a.seed, a.stepped):
        if len(there) >= a.pairs or time.monotonic() > end:
            break
        if draw.name not in done:
            there.append(trial(draw, made))
            with a.out.open("a") as target:
                target.write(json.dumps(there[-1]) + "\n")
            print(row(there[-1]), flush=True)
    summed_up(there)


def summed_up(there: list[dict[str, Any]]) -> None:
    plain = [e for e in there if not any(t["small"] for t in e["truth"])]
    for words, of in (("all", there), ("both beyond what the rig file calls no gap", plain)):
        both = sum(true == said for true, said in map(names, of))
        one = sum(bool(set(true) & set(said)) for true, said in map(names, of))
        strange = sum(bool(set(said) - set(true)) for true, said in map(names, of))
        print(f"{words}: both {both}, at least one {one}, a wrong name {strange}, of {len(of)}")
    if there:
        seconds = [e["seconds"] for e in there]
        print(f"processor seconds: median {np.median(seconds):.1f}, worst {max(seconds):.1f}")


if __name__ == "__main__":
    main()
