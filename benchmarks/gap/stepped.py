"""Diagnoses the campaigns whose truth holds an effect that depends on the size of the motion, and says how well.

    python benchmarks/gap/stepped.py PRACTICE ROUGH --out trials.jsonl
    python benchmarks/gap/stepped.py PRACTICE ROUGH --only practice_42 rough_14 --out trials.jsonl

Folders are those of `practice.py` and `rough.py`. A row says whether the names are right, and of each effect how far
its place, its numbers and their intervals are from the truth.
"""

import argparse
import json
import time
from pathlib import Path
from typing import Any

import yaml

from modallab.core.diagnosis import Diagnosis
from modallab.core.effect import AlongBeam
from modallab.core.effects import catalogue
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.gap.diagnosis import diagnose


def stepped(folders: list[Path]) -> dict[str, Path]:
    """Name -> folder of the campaigns with such an effect."""
    found: dict[str, Path] = {}
    for folder in folders:
        for file in sorted(folder.glob("*/truth.yaml")):
            effects = [e["effect"] for e in yaml.safe_load(file.read_text())["effects"]]
            if any(e in catalogue() and not catalogue()[e].linear for e in effects):
                found[file.parent.name] = file.parent
    return found


def row(name: str, truth: list[dict[str, Any]], diagnosis: Diagnosis, seconds: float) -> str:
    """One campaign in a line."""
    true, said = sorted(e["effect"] for e in truth), sorted(f.effect for f in diagnosis.effects)
    parts: list[str] = []
    for e in truth:
        f = next((f for f in diagnosis.effects if f.effect == e["effect"]), None)
        if f is None:
            continue
        if "x" in e["place"] and isinstance(e["place"]["x"], float) and isinstance(f.place, AlongBeam):
            parts.append(f"x {f.place.x - e['place']['x']:+.3f}")
        for key, value in e["parameters"].items():
            within = f.interval.get(key)
            held = "open" if within is None else "in" if within[0] <= value <= within[1] else "OUT"
            parts.append(f"{key} {100 * (f.parameters[key] / value - 1):+.2f} % {held}")
    gap = diagnosis.gap
    mark = "right" if true == said else "WRONG"
    names = f"{'+'.join(true)} -> {diagnosis.verdict}: {'+'.join(said)}"
    return f"{name} {mark} {names} | {'; '.join(parts)} | {gap.before:.0f} to {gap.after:.2f} | {seconds:.0f} s"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", type=Path, nargs="+")
    parser.add_argument("--only", nargs="*", help="names of campaigns, of whatever truth")
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    chosen = stepped(arguments.folders)
    if arguments.only:
        chosen = {n: f / n for n in arguments.only for f in arguments.folders if (f / n).exists()}
    for name, folder in chosen.items():
        campaign = read_campaign(folder)
        begun = time.process_time()
        diagnosis = diagnose(campaign)
        seconds = time.process_time() - begun
        # The truth is read once the diagnosis stands.
        truth = yaml.safe_load((folder / "truth.yaml").read_text())["effects"]
        entry = {"name": name, "seconds": seconds, "diagnosis": diagnosis.model_dump(mode="json")}
        with arguments.out.open("a") as target:
            target.write(json.dumps(entry) + "\n")
        print(row(name, truth, diagnosis, seconds), flush=True)


if __name__ == "__main__":
    main()
