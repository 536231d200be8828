"""Says which share of the intervals of trials holds the truth, totals where a tolerance shares it.

    python benchmarks/gap/held.py TRIALS trials.jsonl

Of a trial on a bench as built an effect and a tolerance that are the same quantity are one number, and a diagnosis
states the total: the gain of a sensor that is 1 % off by itself is its own times the effect's. The trial's bench is
drawn once more from its seed, without recording anything.
"""

import argparse
import json
from pathlib import Path
from typing import Any

import yaml
from trials import Draw

from modallab.core.diagnosis import Diagnosis, Found
from modallab.core.effects import Effect
from modallab.formats.rig.rig_file import read_rig
from modallab_simulators.cantilever.altered import Altered
from modallab_simulators.cantilever.trial import Operator, rigidly_clamped

NEVER_A_SIZE = {"sign", "hz"}
BUILT = "_usual_"
"""What stands in the name of a trial on a bench as built."""


def bench(trials: Path, name: str, truth: dict[str, Any]) -> Altered:
    """What a trial's bench is other than believed."""
    rig = rigidly_clamped(read_rig(trials / name / "rig.yaml"))
    kind, number = name.split(BUILT)
    draw = Draw(kind.rsplit("_", 1)[1], kind.rsplit("_", 1)[0], int(number), BUILT.strip("_"))
    effects = [Effect(effect=e["effect"], parameters=e["parameters"], place=e["place"]) for e in truth["effects"]]
    return Operator(rig, draw.seed, effects, tolerances=draw.tolerances).truth.effects.altered


def totals(altered: Altered, found: Found) -> dict[str, float]:
    """Parameters of an effect that a tolerance shares, the tolerance's own deviation included."""
    s, chain, name = altered.structure, altered.chain, found.effect
    if name == "clamp_rotation":
        return {next(iter(found.parameters)): 1 / sum(1 / k for k in s.root_nm_rad)}
    if name == "gain_error":
        return {"gain": chain.gain[int(found.place["channel"])]}
    if name == "force_gain":
        return {"gain": chain.force_gain}
    if name == "thermal_drift":
        return {"EI_drift": s.drift}
    if name == "shaker_mass":
        return {"mass": sum(a.mass for a in s.at_shaker)}
    if name == "stinger_moment":
        return {next(iter(found.parameters)): sum(a.stiffness for a in s.at_shaker)}
    return {}


def held(trials: Path, entry: dict[str, Any]) -> list[tuple[str, float, tuple[float, float], bool]]:
    """(effect and parameter, truth, interval, whether it holds) of each effect named right."""
    truth: dict[str, Any] = yaml.safe_load((trials / entry["name"] / "truth.yaml").read_text())
    listed: list[tuple[str, float, tuple[float, float], bool]] = []
    for found in Diagnosis.model_validate(entry["diagnosis"]).effects:
        true = next((e for e in truth["effects"] if e["effect"] == found.effect), None)
        if true is None:
            continue
        values = {**true["parameters"], **{k: v for k, v in true["place"].items() if k == "x"}}
        if BUILT in entry["name"]:
            values |= totals(bench(trials, entry["name"], truth), found)
        for name, (low, high) in found.interval.items():
            if name in values and name not in NEVER_A_SIZE:
                value = float(values[name])
                listed.append((f"{found.effect}.{name}", value, (low, high), low <= value <= high))
    return listed


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("trials", type=Path)
    parser.add_argument("lines", type=Path)
    arguments = parser.parse_args()
    found = [
        row for line in arguments.lines.read_text().splitlines() for row in held(arguments.trials, json.loads(line))
    ]
    for name, value, (low, high), inside in found:
        print(f"{'holds' if inside else 'MISSES':7s} {name:28s} {value:12.6g} [{low:.6g}, {high:.6g}]")
    print(f"{sum(row[3] for row in found)} of {len(found)} intervals hold the truth")


if __name__ == "__main__":
    main()
