"""Diagnoses rough practice campaigns, benches with a little of everything wrong, and scores them.

    python benchmarks/gap/rough.py ROUGH --share develop --out trials.jsonl
    python benchmarks/gap/rough.py ROUGH --share develop --as-ideal --out before.jsonl
    python benchmarks/gap/rough.py ROUGH --score trials.jsonl

Even numbers are for development, odd ones for the report. With --as-ideal the rig file loses what it states beyond the
tolerances of beam and sensitivity.
"""

import argparse
import json
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from modallab.blind.score import Trial, parameter_errors
from modallab.core.block import Campaign
from modallab.core.diagnosis import Diagnosis
from modallab.core.rig import Tolerance
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.gap.diagnosis import diagnose

BEAM = {"youngs_modulus", "thickness", "density", "sensitivity", "meaning"}


def shares(folder: Path) -> dict[str, list[str]]:
    names = sorted(f.parent.name for f in folder.glob("*/truth.yaml"))
    return {"develop": names[0::2], "report": names[1::2]}


def as_ideal(campaign: Campaign) -> Campaign:
    """The campaign with a rig that knows of no tolerances but the beam's and the sensitivities'."""
    rig = campaign.rig
    stated = {k: v for k, v in rig.tolerance.model_dump().items() if k in BEAM}
    return replace(campaign, rig=rig.model_copy(update={"tolerance": Tolerance.model_validate(stated)}))


def run(folder: Path, names: list[str], out: Path, ideal: bool) -> None:
    done = {json.loads(line)["name"] for line in out.read_text().splitlines()} if out.exists() else set()
    for name in names:
        if name in done:
            continue
        campaign = read_campaign(folder / name)
        begun = time.process_time()
        diagnosis = diagnose(as_ideal(campaign) if ideal else campaign)
        entry = {"name": name, "seconds": time.process_time() - begun, "diagnosis": diagnosis.model_dump(mode="json")}
        with out.open("a") as target:
            target.write(json.dumps(entry) + "\n")
        print(row(trial(folder, entry)), flush=True)


def trial(folder: Path, entry: dict[str, Any]) -> Trial:
    truth = yaml.safe_load((folder / entry["name"] / "truth.yaml").read_text())
    rig = yaml.safe_load((folder / entry["name"] / "rig.yaml").read_text())
    diagnosis = Diagnosis.model_validate(entry["diagnosis"])
    return Trial(entry["name"], truth["effects"], diagnosis, float(rig["beam"]["length_m"]), entry["seconds"])


def right(t: Trial) -> bool:
    """Whether the verdict and, where there are names for them, the names are those of the truth."""
    return t.said == t.names if t.identifiable else t.diagnosis.verdict == "unknown"


def right_stage(t: Trial) -> bool:
    return t.diagnosis.where.stage in ({e["family"] for e in t.truth} or {None})


def row(t: Trial) -> str:
    error = max(parameter_errors(t), default=float("nan"))
    truth = " + ".join(sorted(str(e["effect"]) for e in t.truth)) or "none"
    said = f"{t.diagnosis.verdict}: {' + '.join(sorted(t.said))}"
    marks = f"{'right' if right(t) else 'WRONG':5s} {'stage' if right_stage(t) else '-----'}"
    gaps = f"{t.diagnosis.gap.before:8.1f} {t.diagnosis.gap.after:7.2f}"
    return f"{t.name} {marks} {truth:40s} {said:45s} {100 * error:8.2f} % {gaps} {t.seconds:6.1f} s"


def table(listed: list[Trial]) -> list[str]:
    none = [t for t in listed if not t.truth]
    single = [t for t in listed if len(t.truth) == 1 and t.identifiable]
    several = [t for t in listed if len(t.truth) > 1 and t.identifiable]
    other = [t for t in listed if t.truth and not t.identifiable]
    gaps = [t for t in listed if t.truth]
    errors = [e for t in listed for e in parameter_errors(t)]
    return [
        f"false alarms {sum(not right(t) for t in none)} of {len(none)}",
        f"one effect named {sum(right(t) for t in single)} of {len(single)}",
        f"two effects named {sum(right(t) for t in several)} of {len(several)}",
        f"unknown called so {sum(right(t) for t in other)} of {len(other)}",
        f"stage {sum(right_stage(t) for t in gaps)} of {len(gaps)}",
        f"parameters, median error {100 * float(np.median(errors or [np.nan])):.2g} % of {len(errors)}",
        f"processor seconds, median {float(np.median([t.seconds for t in listed])):.1f}",
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--share", choices=("develop", "report"), default="develop")
    parser.add_argument("--only", nargs="*", help="names of campaigns of the share")
    parser.add_argument("--as-ideal", action="store_true", help="without the tolerances a rough rig states")
    parser.add_argument("--out", type=Path)
    parser.add_argument("--score", type=Path)
    arguments = parser.parse_args()
    if arguments.out is not None:
        names = [n for n in shares(arguments.folder)[arguments.share] if not arguments.only or n in arguments.only]
        run(arguments.folder, names, arguments.out, arguments.as_ideal)
    if arguments.score is not None:
        entries = [json.loads(line) for line in arguments.score.read_text().splitlines()]
        listed = [trial(arguments.folder, e) for e in entries]
        print("\n".join([*(row(t) for t in listed), *table(listed)]))


if __name__ == "__main__":
    main()
