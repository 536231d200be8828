"""Right diagnoses of blind trials, applied: does a later campaign on the same bench stand within its tolerances?

    python benchmarks/gap/applied.py TRIALS --out F.jsonl

TRIALS is a folder of `modallab gap blind`, whole or as far as it has come; that command does the same once all trials
are answered. For each right diagnosis: the share of the gap that was to be closed, what is closed in the later
campaign, and whether that campaign has no gap to the rig with the diagnosis in it. What F holds is not done again.
"""

import argparse
import json
import time
from pathlib import Path
from typing import Any

import numpy as np

from modallab.blind.outcome import true_name
from modallab.blind.run import diagnose_later_campaign
from modallab.blind.score import Trial
from modallab.blind.seal import SEALED
from modallab.blind.trial_answers import ANSWERS, TrialAnswer, read_answers


def answered(folder: Path) -> list[tuple[TrialAnswer, Trial]]:
    """What has been answered, beside its truth, in the order of the trials."""
    found: list[tuple[TrialAnswer, Trial]] = []
    for a in sorted(read_answers(folder / ANSWERS), key=lambda a: a.name):
        truth = json.loads((folder / SEALED / f"{a.name}.json").read_text(encoding="utf-8"))["truth"]
        found.append((a, Trial(a.name, truth["effects"], a.diagnosis, a.length_m, a.seconds)))
    return found


def applied(folder: Path, answer: TrialAnswer, trial: Trial) -> dict[str, Any]:
    """One right diagnosis, held against the later campaign."""
    begun = time.process_time()
    seen = diagnose_later_campaign(folder / SEALED / f"{answer.name}_later.h5", answer.diagnosis)
    entry = {"name": answer.name, "effect": true_name(trial), "predicted": answer.diagnosis.shrink.closed}
    return entry | {"seen": seen.closed, "shut": seen.shut, "seconds": time.process_time() - begun}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--minutes", type=float, default=60.0, help="no trial is begun after these")
    a = parser.parse_args()
    there = [json.loads(line) for line in a.out.read_text().splitlines()] if a.out.exists() else []
    done, end = {e["name"] for e in there}, time.monotonic() + 60 * a.minutes
    listed = answered(a.folder)
    for answer, trial in listed:
        if trial.truth and trial.right and answer.name not in done and time.monotonic() < end:
            there.append(applied(a.folder, answer, trial))
            with a.out.open("a") as target:
                target.write(json.dumps(there[-1]) + "\n")
            print(there[-1], flush=True)
    wrong = [
        f"{t.name} {true_name(t)}: {'+'.join(sorted(t.said)) or t.diagnosis.verdict}" for _, t in listed if not t.right
    ]
    print(f"right {len(listed) - len(wrong)} of {len(listed)}; {'; '.join(wrong)}")
    print(f"gap closed in a later campaign: {sum(e['shut'] for e in there)} of {len(there)}")
    errors = [abs(e["predicted"] - e["seen"]) for e in there if None not in (e["predicted"], e["seen"])]
    if errors:
        near = sum(e <= 0.05 for e in errors)
        print(f"predicted within 0.05 of seen: {near} of {len(errors)}; median {np.median(errors):.2g}")


if __name__ == "__main__":
    main()
