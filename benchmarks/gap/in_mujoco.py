"""The corrected link in MuJoCo: how far held-out records are closed there, and by the twin itself.

    python benchmarks/gap/in_mujoco.py --seed 181818 --effects clamp_rotation,ground_spring,cubic_spring --out F.jsonl

One trial an effect, drawn as by `modallab gap blind` on an ideal bench. Its diagnosis is written and played as by
`modallab gap export --form mjcf --on CAMPAIGN`: hits that were held out, and with `--sines N` so many sines as well.
What F holds is not done again.
"""

import argparse
import json
import time
from pathlib import Path
from typing import Any

from modallab.blind.draw import TrialDraw, make_trial
from modallab.core.errors import ModallabError
from modallab.core.units import Test
from modallab.gap.diagnosis import diagnose
from modallab.gap.export.forms import FORMS, measure_form
from modallab.gap.report.measure import share_of_gap_closed

EFFECTS = ("clamp_rotation", "ground_spring", "local_damper", "added_mass", "stiffness_loss", "sensor_mass")


def trial(name: str, seed: int, tolerances: str, sines: int) -> list[dict[str, Any]]:
    """One effect in each test."""
    made = make_trial(TrialDraw(name, name, seed, tolerances), later=False)
    said = diagnose(made.campaign)
    entry = {"effect": name, "seed": seed, "said": [f.effect for f in said.effects], "verdict": said.verdict}
    tests: list[tuple[Test, int | None]] = [("impact", None), *([("sine", sines)] if sines else [])]
    found: list[dict[str, Any]] = []
    for test, most in tests:
        begun = time.process_time()
        try:
            measured = measure_form(FORMS["mjcf"], said, made.campaign, [test], most).model_dump(mode="json")
        except ModallabError as error:
            found.append(entry | {"test": test, "error": str(error)})
            continue
        own = share_of_gap_closed(measured["before"], measured["twin_after"])
        found.append(entry | {"test": test, "own": own, "seconds": time.process_time() - begun} | measured)
    return found


def row(e: dict[str, Any]) -> str:
    """One result in words."""
    head = f"{e['effect']:18s} {e['test']:6s} said {'+'.join(e['said']) or e['verdict']:24s}"
    if "error" in e:
        return f"{head} {e['error']}"
    share = "" if e["closed"] is None else f"closed {e['closed']:.4f}, by the twin {e['own']:.4f}"
    return f"{head} {e['before']:8.2f} to {e['after']:7.3f}, twin {e['twin_after']:7.3f}, {share}, {e['seconds']:.0f} s"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--effects", default=",".join(EFFECTS))
    parser.add_argument("--tolerances", choices=("none", "usual"), default="none")
    parser.add_argument("--sines", type=int, default=0, help="records of sines that are played too; each takes a while")
    parser.add_argument("--out", type=Path, required=True)
    a = parser.parse_args()
    there = [json.loads(line) for line in a.out.read_text().splitlines()] if a.out.exists() else []
    done = {e["effect"] for e in there}
    for number, name in enumerate(a.effects.split(",")):
        if name not in done:
            more = trial(name, a.seed * 1000 + number, a.tolerances, a.sines)
            there += more
            with a.out.open("a") as target:
                target.writelines(json.dumps(e) + "\n" for e in more)
    print("\n".join(map(row, there)))
    played = [e for e in there if e.get("closed") is not None]
    near = [e for e in played if abs(e["closed"] - e["own"]) <= 0.05]
    print(f"within 5 points of the twin's own: {len(near)} of {len(played)}; not exported {len(there) - len(played)}")


if __name__ == "__main__":
    main()
