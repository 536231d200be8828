"""Diagnoses that leave several explanations: does the experiment planned then, once run, leave the truth alone?

    python benchmarks/gap/next_run.py --sets 20 --seed 161616 --out F.jsonl

Campaigns that show little: few accelerometers and two hits at one point, on a simulated bench with one effect. It is
drawn without regard to others and made smaller, where need be, until such a campaign still sees it but does not tell it
from the one most like it, by signatures as `gap distinguishability` has them. Of those that are the same as another to
every test of the rig few are kept. Campaigns count whose diagnosis leaves two explanations or more (`STANDING`), the
truth among them. The best experiment of `modallab gap next` is run on the same bench, and the diagnosis goes on with
its records, as `--run` does. Where the plan says that no experiment decides, the best is run all the same: it must not
decide then. What F holds is not done again.
"""

import argparse
import json
import time
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from undecided import EFFECTS, PLANS, drawn

from modallab.acquisition.process.run import record_run
from modallab.core.block import Campaign
from modallab.core.diagnosis import Diagnosis
from modallab.core.effects import Effect
from modallab.core.errors import ModallabError
from modallab.core.hold_out import SPREAD
from modallab.core.plan import Plan
from modallab.core.rig import Rig
from modallab.gap.design.experiments import DECIDES, continue_campaign, next_experiments
from modallab.gap.design.explanations import drop_redundant_explanations, remaining_explanations
from modallab.gap.diagnosis import diagnose
from modallab.storage import Store, campaign_of
from modallab_simulators.cantilever.address import SessionConditions, parse_address
from modallab_simulators.cantilever.bench import CantileverBench

STANDING = 0.05
"""Probability from which an explanation is left standing."""


def standing(found: Diagnosis) -> list[list[str]]:
    """The explanations that are left standing, the likeliest first."""
    if found.verdict == "no_gap":
        return []
    return [sorted(c.effects) for c in drop_redundant_explanations(found.candidates) if c.probability >= STANDING]


def trial(seed: int, names: Sequence[str]) -> dict[str, Any]:
    """One trial, as far as it goes."""
    made = drawn(seed, names)
    if made is None:
        return {"seed": seed, "kept": False, "why": "it is not seen, or distinguished"}
    effect = made["effect"]
    assert isinstance(effect, Effect)
    entry: dict[str, Any] = {
        "seed": seed,
        "truth": effect.effect,
        "numbers": effect.parameters,
        "place": effect.place.model_dump(),
    }
    entry |= {k: made[k] for k in ("plan", "sensors", "rough", "other", "seen", "apart", "url")}
    try:
        with TemporaryDirectory() as folder:
            return entry | tried(made, effect.effect, Path(folder))
    except ModallabError as error:
        return entry | {"kept": "standing" in entry, "right": False, "why": f"{type(error).__name__}: {error}"}


def recorded(url: str, rig: Rig, plans: Sequence[Plan], folder: Path, session: int = 0) -> Campaign:
    """Tests on the simulated bench, in this process; another session has hits and noise of its own."""
    # As in blind trials: one card drives and converts, and the beam has no more modes than matter in the band.
    circumstances = SessionConditions(first_start=1000 * session, one_clock=True, modes=15)
    with Store(folder) as store:
        benches = [CantileverBench(url, rig, parse_address(url), circumstances) for _ in plans]
        return campaign_of(
            store, [record_run(b, rig, plan, store, lambda _: None) for b, plan in zip(benches, plans, strict=True)]
        )


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
        later = recorded(url, rig, ranked[0].plans, folder / "later", session=1)
        second = diagnose(continue_campaign(campaign, later), SPREAD, known=remaining_explanations(first))
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
    parser.add_argument("--effects", default=",".join(EFFECTS), help="those that are drawn")
    parser.add_argument("--minutes", type=float, default=60.0, help="no trial is begun after these")
    a = parser.parse_args()
    there = [json.loads(line) for line in a.out.read_text().splitlines()] if a.out.exists() else []
    print("\n".join(map(row, there)))
    end = time.monotonic() + 60 * a.minutes
    while sum(e["kept"] and e.get("decides", True) for e in there) < a.sets and time.monotonic() < end:
        there.append(trial(a.seed * 1000 + len(there), a.effects.split(",")))
        with a.out.open("a") as target:
            target.write(json.dumps(there[-1]) + "\n")
        print(row(there[-1]), flush=True)
    print(summary(there))


if __name__ == "__main__":
    main()
