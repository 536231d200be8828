"""Diagnoses that leave several explanations: does the experiment planned then, once run, leave the truth alone?

    python benchmarks/gap/next_run.py --sets 20 --seed 161616 --out F.jsonl

Campaigns that show little: few accelerometers, and hits at one point or sines at one level, on a simulated bench with
one effect. What such a campaign cannot tell is computed beforehand (`of_data`): the effect is one of a pair whose
signatures are alike there, large enough to be seen and small enough not to be told from the other. Of pairs that are
the same to every test of the rig one in eight is kept. Those campaigns are kept whose diagnosis leaves two explanations
or more (`STANDING`), the truth among them. The best experiment of `modallab gap next` is run on the same
bench, and the diagnosis goes on with its records, as `--run` does. Where the plan says that no experiment decides, the
best is run all the same: it must not decide then. What F holds is not done again.
"""

import argparse
import json
import time
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from modallab.acquisition.process.run import record
from modallab.bench.loader import open_bench
from modallab.blind.trial_bench import trial_bench
from modallab.blind.trial_rigs import drawn_rig, mounted
from modallab.core.block import Campaign
from modallab.core.diagnosis import Diagnosis
from modallab.core.effects import Effect, kind_of
from modallab.core.errors import ModallabError
from modallab.core.plan import PAPER_LINES, ImpactPlan, Plan, SinePlan
from modallab.core.rig import Rig, Tolerance
from modallab.gap.design.continued import FITTED, continued
from modallab.gap.design.distinguishability import Distinguishability, of_data
from modallab.gap.design.experiments import DECIDES, next_experiments
from modallab.gap.design.planned import planned
from modallab.gap.design.standing import without_needless
from modallab.gap.diagnosis import diagnose
from modallab.gap.model.fit import all_rows
from modallab.storage import Store, campaign_of

EFFECTS = (
    *("clamp_rotation", "clamp_translation", "added_mass", "sensor_mass", "stiffness_loss", "ground_spring"),
    *("gain_error", "position_error", "hit_position", "force_gain", "channel_skew", "trigger_delay"),
    *("stinger_moment", "shaker_mass", "local_damper", "ac_coupling", "loose_mount"),
)
STANDING = 0.05
"""Probability from which an explanation is left standing."""
SAME = 1 - 1e-5
"""Cosine from which two effects are the same."""
SEEN, TOLD = 20.0, 3.0
"""Noise units, over all records and beyond tolerances, that an effect leaves at least, and by which it is told from the
other of its pair at most."""
SHAKER = (1.6, 40.0)
"""Gaps of a mass on the shaker, in the same units as the next."""
GAPS = (1.6, 60.0)
"""Gaps in noise units on an ideal bench without tolerances that are drawn at all."""
MOVES = 0.04
"""Share of the response that an effect on a bench as built moves at least: less is no gap there."""
BUILT = 1 / 3
"""Share of benches as built: their diagnoses take longer."""
SENSORS = {"tip": (10,), "middle": (6,), "low": (3,), "close": (6, 7), "two": (5, 10), "three": (3, 7, 10)}
LINES = tuple(round(line / 1.024, 3) for line in PAPER_LINES)
PLANS: dict[str, Plan] = {
    "hits at 3": ImpactPlan(points=(3,), hits=2),
    "hits at 6": ImpactPlan(points=(6,), hits=2),
    "hits at 10": ImpactPlan(points=(10,), hits=2),
    "sines": SinePlan(frequencies_hz=LINES, levels_v={"low": 0.2}),
}


def with_sensors(rig: Rig, points: tuple[int, ...]) -> Rig:
    """The rig with the force and the accelerometers at these points only."""
    kept = [c for c in rig.channels if c.point is None or c.point in points]
    return rig.model_copy(update={"channels": tuple(c.model_copy(update={"index": k}) for k, c in enumerate(kept))})


def seen(rig: Rig, plans: list[Plan]) -> tuple[Distinguishability, float]:
    """What a campaign can tell, and the noise units over all records that a gap of one makes."""
    points = [(rig.x_of(p), plan.hits) for plan in plans if isinstance(plan, ImpactPlan) for p in plan.points]
    data = planned(rig, plans)
    return of_data(data, points, EFFECTS), float(np.sqrt(2 * sum(r.y.size for r in all_rows(data))))


def alike(rig: Rig, plan: Plan, rng: np.random.Generator) -> list[tuple[str, str, float, float]]:
    """Effects that a campaign may not tell from another, that other, and gaps at which it sees but does not tell."""
    found, units = seen(rig, [plan])
    whole, _ = seen(rig, [ImpactPlan(points=tuple(p.id for p in rig.points), hits=5), SinePlan()])
    same = {frozenset((a, b)) for a, b, cosine in whole.alike() if cosine > SAME}
    # A mass on the shaker is one on the beam where it stands, to sines.
    pairs = [("shaker_mass", "added_mass", *SHAKER)] * 2 if isinstance(plan, SinePlan) else []
    for a, b, cosine in found.alike():
        if frozenset((a, b)) in same and rng.random() > 1 / 8:
            continue
        for one, other in ((a, b), (b, a)):
            left = units * float(found.strength[found.effects.index(one)])
            low, high = SEEN / left, TOLD / left / max(float(np.sqrt(1 - cosine**2)), 1e-3)
            if max(low, GAPS[0]) < min(high, GAPS[1]):
                pairs.append((one, other, max(low, GAPS[0]), min(high, GAPS[1])))
    return pairs


def drawn(seed: int) -> dict[str, Any] | None:
    """A trial: rig, plan, effect and the bench's address; None where no pair that is seen and not told apart."""
    rng = np.random.default_rng([seed, 16])
    rough = bool(rng.random() < BUILT)
    # Sines alone give an ideal bench's diagnosis too little to begin from: it says "unknown".
    plans = [name for name, plan in PLANS.items() if rough or isinstance(plan, ImpactPlan)]
    sensors, plan = str(rng.choice(list(SENSORS))), str(rng.choice(plans))
    rig = with_sensors(drawn_rig(seed), SENSORS[sensors])
    if rough:
        rig = mounted(rig.model_copy(update={"tolerance": Tolerance.usual()}), seed)
    pairs = alike(rig, PLANS[plan], rng)
    if not pairs:
        return None
    name, other, low, high = pairs[int(rng.integers(len(pairs)))]
    gap = float(np.exp(rng.uniform(np.log(low), np.log(high))))
    one = trial_bench().draw_effect(rig, seed, name, gap)
    if rough and one.moves < MOVES:
        return None
    effect = one.effect
    words = [f"{k}={v!r}" for k, v in effect.parameters.items()]
    words += [f"{k}={v}" for k, v in effect.place.items() if kind_of(effect.effect).place == k]
    url = f"sim://cantilever?seed={seed}&k_root=inf&bad_hits=0&n_per_v=2&effect={','.join([effect.effect, *words])}"
    return {"rig": rig, "plan": plan, "sensors": sensors, "effect": effect, "other": other, "rough": rough, "gap": gap,
            "url": url + ("&tolerances=usual" if rough else "")}  # fmt: skip


def standing(found: Diagnosis) -> list[list[str]]:
    """The explanations that are left standing, the likeliest first."""
    if found.verdict == "no_gap":
        return []
    return [sorted(c.effects) for c in without_needless(found.candidates) if c.probability >= STANDING]


def trial(seed: int) -> dict[str, Any]:
    """One trial, as far as it goes."""
    made = drawn(seed)
    if made is None:
        return {"seed": seed, "kept": False, "why": "no pair that is seen and not told apart"}
    effect = made["effect"]
    assert isinstance(effect, Effect)
    entry: dict[str, Any] = {"seed": seed, "truth": effect.effect, "numbers": effect.parameters, "place": effect.place}
    entry |= {k: made[k] for k in ("plan", "sensors", "rough", "other", "gap", "url")}
    try:
        with TemporaryDirectory() as folder:
            return entry | tried(made, effect.effect, Path(folder))
    except ModallabError as error:
        return entry | {"kept": "standing" in entry, "right": False, "why": f"{type(error).__name__}: {error}"}


def recorded(url: str, rig: Rig, plans: Sequence[Plan], folder: Path) -> Campaign:
    """Tests on the simulated bench, in this process."""
    with Store(folder) as store:
        return campaign_of(store, [record(open_bench(url, rig), rig, plan, store, lambda _: None) for plan in plans])


def tried(made: dict[str, Any], truth: str, folder: Path) -> dict[str, Any]:
    """What a trial's bench, diagnoses and plan say."""
    rig, url = made["rig"], made["url"]
    campaign = recorded(url, rig, [PLANS[made["plan"]]], folder / "first")
    begun = time.process_time()
    first = diagnose(campaign)
    entry: dict[str, Any] = {"verdict": first.verdict, "standing": standing(first)}
    entry |= {"seconds": time.process_time() - begun, "of": [c.probability for c in first.candidates[:4]]}
    if first.verdict != "known" or len(entry["standing"]) < 2 or [truth] not in entry["standing"]:
        return entry | {"kept": False}
    begun = time.process_time()
    ranked = next_experiments(campaign, first)
    entry |= {"planned_in": time.process_time() - begun}
    entry |= {"experiments": [e.model_dump(exclude={"plans", "says"}) for e in ranked[:6]]}
    try:
        later = recorded(url, rig, ranked[0].plans, folder / "later")
        second = diagnose(continued(campaign, later), FITTED)
    except ModallabError as error:
        return entry | {"kept": True, "right": False, "why": f"{type(error).__name__}: {error}"}
    said = sorted(f.effect for f in second.effects)
    then = {"verdict": second.verdict, "said": said, "standing": standing(second)}
    then |= {"all": [("+".join(c.effects), c.probability) for c in second.candidates[:6]], "gap": second.gap.after}
    return entry | {
        "kept": True,
        "decides": ranked[0].expected >= DECIDES,
        "then": then,
        "right": said == [truth] and standing(second) == [[truth]],
    }


def row(e: dict[str, Any]) -> str:
    """One trial in words."""
    if "truth" not in e:
        return f"{e['seed']} not kept: {e['why']}"
    head = f"{e['seed']} {'built' if e['rough'] else 'ideal'} {e['sensors']:6s} {e['plan']:10s} {e['truth']:17s}"
    if "standing" not in e:
        return f"{head} not kept: {e['why']}"
    left = " | ".join("+".join(s) for s in e["standing"]) or e["verdict"]
    if not e["kept"]:
        return f"{head} not kept: {e['verdict']} {left}"
    best = e["experiments"][0]
    how = f"{best['name']} (expected {best['expected']:.3f}, {best['nats']:.3g} nats, in {e['planned_in']:.0f} s)"
    if "then" not in e:
        return f"{head} WRONG {left} -> {how} -> {e['why']}"
    then = e["then"]
    left_then = " | ".join(f"{name} {p:.2f}" for name, p in then["all"] if p >= STANDING) or then["verdict"]
    word = "right" if e["right"] else "WRONG"
    return f"{head} {word if e['decides'] else f'nothing decides, {word}'} {left} -> {how} -> {left_then}"


def summary(there: list[dict[str, Any]]) -> str:
    """What counts."""
    kept = [e for e in there if e["kept"]]
    run = [e for e in kept if e.get("decides", True)]
    none = [e for e in kept if not e.get("decides", True)]
    return (
        f"the truth alone is left: {sum(e['right'] for e in run)} of {len(run)} sets, of {len(there)} draws\n"
        f"where it is said that no experiment on the rig decides, the best leaves the truth alone: "
        f"{sum(e['right'] for e in none)} of {len(none)}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sets", type=int, default=20, help="sets of which the plan says that an experiment decides")
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--minutes", type=float, default=60.0, help="no trial is begun after these")
    a = parser.parse_args()
    there = [json.loads(line) for line in a.out.read_text().splitlines()] if a.out.exists() else []
    print("\n".join(map(row, there)))
    end = time.monotonic() + 60 * a.minutes
    while sum(e["kept"] and e.get("decides", True) for e in there) < a.sets and time.monotonic() < end:
        there.append(trial(a.seed * 1000 + len(there)))
        with a.out.open("a") as target:
            target.write(json.dumps(there[-1]) + "\n")
        print(row(there[-1]), flush=True)
    print(summary(there))


if __name__ == "__main__":
    main()
