"""Diagnoses the practice campaigns of one share of a fixed split and scores them.

    python benchmarks/gap/practice.py PRACTICE --share report --out trials.jsonl
    python benchmarks/gap/practice.py PRACTICE --share report --withhold --out withheld.jsonl
    python benchmarks/gap/practice.py PRACTICE --score trials.jsonl

With --withhold the names of the true effects are taken out of the candidates: the right answer is "unknown", at the
right stage.

The split is by the hash of a campaign's name, stratified by effect: of two campaigns with one effect one is for
development, one for the report; those without and with two effects fall into develop, calibrate and report.
"""

import argparse
import hashlib
import json
import time
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from modallab.blind.score import Trial, parameter_errors, probability_calibration, score_trials
from modallab.core.diagnosis import Diagnosis
from modallab.core.effects import catalogue
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.gap.diagnosis import diagnose

SALT = "modallab-split-1:"


def shares(practice: Path) -> dict[str, list[str]]:
    groups: dict[str, list[str]] = defaultdict(list)
    for file in sorted(practice.glob("*/truth.yaml")):
        effects = yaml.safe_load(file.read_text())["effects"]
        kind = {0: "none", 2: "two"}.get(len(effects)) or effects[0]["effect"]
        groups[kind].append(file.parent.name)
    split: dict[str, list[str]] = {"develop": [], "calibrate": [], "report": []}
    for kind, names in groups.items():
        order = ["develop", "calibrate", "report"] if kind in {"none", "two"} else ["develop", "report"]
        for i, name in enumerate(sorted(names, key=lambda n: hashlib.sha256((SALT + n).encode()).hexdigest())):
            split[order[i % len(order)]].append(name)
    return split


def truth_of(practice: Path, name: str) -> list[dict[str, Any]]:
    return yaml.safe_load((practice / name / "truth.yaml").read_text())["effects"]


def run(practice: Path, names: list[str], out: Path, withhold: bool = False) -> None:
    done = {json.loads(line)["name"] for line in out.read_text().splitlines()} if out.exists() else set()
    for name in names:
        if name in done:
            continue
        withheld = {e["effect"] for e in truth_of(practice, name)} if withhold else set[str]()
        if withhold and not withheld & set(catalogue()):
            continue
        campaign = read_campaign(practice / name)
        begun = time.process_time()
        diagnosis = diagnose(campaign, allowed=lambda effect, held=withheld: effect not in held)
        seconds, said = time.process_time() - begun, diagnosis.model_dump(mode="json")
        entry = {"name": name, "seconds": seconds, "diagnosis": said, "withheld": sorted(withheld)}
        with out.open("a") as target:
            target.write(json.dumps(entry) + "\n")


def trials(practice: Path, file: Path) -> list[Trial]:
    found: list[Trial] = []
    for line in file.read_text().splitlines():
        entry: dict[str, Any] = json.loads(line)
        truth = yaml.safe_load((practice / entry["name"] / "truth.yaml").read_text())
        rig = yaml.safe_load((practice / entry["name"] / "rig.yaml").read_text())
        diagnosis = Diagnosis.model_validate(entry["diagnosis"])
        length = float(rig["beam"]["length_m"])
        withheld = frozenset(entry.get("withheld", ()))
        found.append(Trial(entry["name"], truth["effects"], diagnosis, length, entry["seconds"], withheld))
    return found


def by_effect(listed: list[Trial]) -> list[str]:
    """Rows of a table: effect, trials, named right, stage right, median relative error of the parameters."""
    groups: dict[str, list[Trial]] = defaultdict(list)
    for trial in listed:
        groups[" + ".join(sorted(str(e["effect"]) for e in trial.truth)) or "none"].append(trial)
    rows: list[str] = []
    for name, group in sorted(groups.items()):
        right = sum(t.said == t.names if t.identifiable else t.diagnosis.verdict == "unknown" for t in group)
        stage = sum(t.diagnosis.where.stage in {e["family"] for e in t.truth} for t in group if t.truth)
        errors = [e for t in group for e in parameter_errors(t)]
        error = f"{100 * float(np.median(errors)):.2g} %" if errors else ""
        rows.append(
            f"| {name.replace('_', ' ')} | {len(group)} | {right} | {stage if name != 'none' else ''} | {error} |"
        )
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("practice", type=Path)
    parser.add_argument("--share", choices=("develop", "calibrate", "report"), default="report")
    parser.add_argument("--part", type=int, nargs=2, default=(0, 1), metavar=("I", "OF"))
    parser.add_argument("--withhold", action="store_true", help="take the true effects out of the candidates")
    parser.add_argument("--out", type=Path)
    parser.add_argument("--score", type=Path)
    arguments = parser.parse_args()
    if arguments.out is not None:
        run(
            arguments.practice,
            shares(arguments.practice)[arguments.share][arguments.part[0] :: arguments.part[1]],
            arguments.out,
            arguments.withhold,
        )
    if arguments.score is not None:
        listed = trials(arguments.practice, arguments.score)
        print("\n".join(by_effect(listed)))
        for figure in score_trials(listed):
            print(f"{figure.name:42s} {figure.value:8.4f} of {figure.count:3d}  {' '.join(figure.misses)}")
        error, bins = probability_calibration(listed)
        print(f"{'calibration error of the probabilities':42s} {error:8.4f}")
        for figure in bins:
            print(f"    {figure.name}: right {figure.value:.3f} of {figure.count}")


if __name__ == "__main__":
    main()
