"""Diagnoses that leave several explanations: does the experiment planned then, once run, leave the truth alone?

    python benchmarks/gap/next_run.py --sets 20 --seed 161616 --out F.jsonl

Campaigns that show little: few accelerometers, and hits at one point or sines at one level, on a simulated bench with
one effect. Those are kept whose diagnosis leaves two explanations or more (`STANDING`), the truth among them. The best
experiment of `modallab gap next` is run on the same bench, and the diagnosis goes on with its records, as `--run` does.
What F holds is not done again.
"""

import argparse
import json
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from modallab.blind.trial_bench import trial_bench
from modallab.blind.trial_rigs import drawn_rig, mounted
from modallab.core.diagnosis import Diagnosis
from modallab.core.effects import Effect, kind_of
from modallab.core.plan import PAPER_LINES, ImpactPlan, Plan, SinePlan
from modallab.core.rig import Rig, Tolerance
from modallab.gap.design.continued import continued
from modallab.gap.design.experiments import DECIDES, next_experiments
from modallab.gap.diagnosis import diagnose
from modallab.service.campaigns.local_session import record_campaign

EFFECTS = (
    *("clamp_rotation", "clamp_translation", "added_mass", "sensor_mass", "stiffness_loss", "ground_spring"),
    *("gain_error", "position_error", "hit_position", "force_gain", "channel_skew", "trigger_delay"),
    *("stinger_moment", "shaker_mass", "local_damper", "ac_coupling", "loose_mount"),
)
STANDING = 0.05
"""Probability from which an explanation is left standing."""
GAPS = (2.0, 60.0)
"""Gaps that are drawn, in noise units on an ideal bench; several times that on one as built."""
SENSORS = {"tip": (10,), "close": (6, 7), "two": (5, 10), "three": (3, 7, 10)}
LINES = tuple(round(line / 1.024, 3) for line in PAPER_LINES[::2])
PLANS: dict[str, Plan] = {
    "hits at 6": ImpactPlan(points=(6,), hits=2),
    "hits at 10": ImpactPlan(points=(10,), hits=2),
    "sines": SinePlan(frequencies_hz=LINES, levels_v={"low": 1.0}),
}
OF_HITS, OF_SINES = {"hit_position"}, {"stinger_moment", "shaker_mass"}


def with_sensors(rig: Rig, points: tuple[int, ...]) -> Rig:
    """The rig with the force and the accelerometers at these points only."""
    kept = [c for c in rig.channels if c.point is None or c.point in points]
    return rig.model_copy(update={"channels": tuple(c.model_copy(update={"index": k}) for k, c in enumerate(kept))})


def drawn(seed: int) -> dict[str, Any]:
    """A trial: rig, plan, effect and the bench's address."""
    rng = np.random.default_rng([seed, 16])
    rough = bool(rng.integers(2))
    sensors, plan = str(rng.choice(list(SENSORS))), str(rng.choice(list(PLANS)))
    names = [e for e in EFFECTS if e not in (OF_HITS if plan == "sines" else OF_SINES)]
    rig = with_sensors(drawn_rig(seed), SENSORS[sensors])
    if rough:
        rig = mounted(rig.model_copy(update={"tolerance": Tolerance.usual()}), seed)
    gap = float(np.exp(rng.uniform(*np.log(GAPS)))) * (6 if rough else 1)
    effect = trial_bench().draw_effect(rig, seed, str(rng.choice(names)), gap).effect
    words = [f"{k}={v!r}" for k, v in effect.parameters.items()]
    words += [f"{k}={v}" for k, v in effect.place.items() if kind_of(effect.effect).place == k]
    url = f"sim://cantilever?seed={seed}&k_root=inf&bad_hits=0&n_per_v=2&effect={','.join([effect.effect, *words])}"
    return {"rig": rig, "plan": plan, "sensors": sensors, "effect": effect, "rough": rough,
            "url": url + ("&tolerances=usual" if rough else "")}  # fmt: skip


def standing(found: Diagnosis) -> list[list[str]]:
    """The explanations that are left standing, the likeliest first."""
    if found.verdict == "no_gap":
        return []
    listed = sorted(found.candidates, key=lambda c: -c.probability)
    return [sorted(c.effects) for c in listed if c.probability >= STANDING]


def trial(seed: int) -> dict[str, Any]:
    """One trial, as far as it goes."""
    made = drawn(seed)
    rig, url, effect = made["rig"], made["url"], made["effect"]
    assert isinstance(effect, Effect)
    entry: dict[str, Any] = {"seed": seed, "truth": effect.effect, "numbers": effect.parameters, "place": effect.place}
    entry |= {k: made[k] for k in ("plan", "sensors", "rough", "url")}
    with TemporaryDirectory() as folder:
        campaign = record_campaign(url, rig, [PLANS[made["plan"]]], Path(folder), lambda _: None)
        begun = time.process_time()
        first = diagnose(campaign)
        entry |= {"verdict": first.verdict, "standing": standing(first), "seconds": time.process_time() - begun}
        if first.verdict != "known" or len(entry["standing"]) < 2 or [effect.effect] not in entry["standing"]:
            return entry | {"kept": False}
        ranked = next_experiments(campaign, first)
        if ranked[0].expected < DECIDES:
            return entry | {"kept": False, "none": ranked[0].after}
        later = record_campaign(url, rig, ranked[0].plans, Path(folder), lambda _: None)
    second = diagnose(continued(campaign, later))
    said = sorted(f.effect for f in second.effects)
    return entry | {
        "kept": True,
        "experiments": [{"name": e.name, "before": e.before, "after": e.after} for e in ranked],
        "then": {"verdict": second.verdict, "said": said, "standing": standing(second)},
        "right": said == [effect.effect] and standing(second) == [[effect.effect]],
    }


def row(e: dict[str, Any]) -> str:
    """One trial in words."""
    head = f"{e['seed']} {'built' if e['rough'] else 'ideal'} {e['sensors']:6s} {e['plan']:10s} {e['truth']:17s}"
    left = " | ".join("+".join(s) for s in e["standing"]) or e["verdict"]
    if not e["kept"]:
        none = f" no experiment decides: {e['none']:.2g}" if "none" in e else ""
        return f"{head} not kept: {e['verdict']} {left}{none}"
    then, best = e["then"], e["experiments"][0]
    left_then = " | ".join("+".join(s) for s in then["standing"]) or then["verdict"]
    how = f"{best['name']} ({best['before']:.3g} to {best['after']:.3g})"
    return f"{head} {'right' if e['right'] else 'WRONG'} {left} -> {how} -> {left_then} {e['numbers']}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sets", type=int, default=20, help="diagnoses that leave several explanations")
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--minutes", type=float, default=60.0, help="no trial is begun after these")
    a = parser.parse_args()
    there = [json.loads(line) for line in a.out.read_text().splitlines()] if a.out.exists() else []
    print("\n".join(map(row, there)))
    end = time.monotonic() + 60 * a.minutes
    while sum(e["kept"] for e in there) < a.sets and time.monotonic() < end:
        there.append(trial(a.seed * 1000 + len(there)))
        with a.out.open("a") as target:
            target.write(json.dumps(there[-1]) + "\n")
        print(row(there[-1]), flush=True)
    kept = [e for e in there if e["kept"]]
    print(f"the truth alone is left: {sum(e['right'] for e in kept)} of {len(kept)} sets, of {len(there)} diagnoses")
    print(f"sets of which it is said that no experiment on the rig decides: {sum('none' in e for e in there)}")


if __name__ == "__main__":
    main()
