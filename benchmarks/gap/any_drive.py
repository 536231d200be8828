"""The same effect under several drives: whether a diagnosis says the same, whatever moved the beam.

Records the simulated bench without an effect and with one of seven, by hammer, random, burst-random, chirp and a slow
sweep, and diagnoses each. A row of the CSV is one diagnosis: verdict, effect, number with its interval, seconds.
`--reference` diagnoses against a hammer test of the same bench without the effect, as of a structure without a beam.
`--summary` counts drives with the verdict of the hammer test, with an interval that meets its, and false alarms.

    python benchmarks/gap/any_drive.py --out rows.csv [--effects 7 --none 10 --drives random chirp]
    python benchmarks/gap/any_drive.py --summary benchmarks/gap/any_drive.csv
"""

import argparse
import csv
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from modallab.cli.demo import demo_rig
from modallab.core.block import Campaign
from modallab.core.modal_diagnosis import ModalDiagnosis
from modallab.core.plan import BroadbandPlan, ImpactPlan
from modallab.gap.diagnosis import diagnose
from modallab.pipelines.structure_gap import gap_of, model_to_compare
from modallab.service.campaigns.local_session import record_campaign

DRIVES = {
    "impact": ImpactPlan(points=(10, 7, 3), hits=5),
    "random": BroadbandPlan(signal="random", blocks=30),
    "burst-random": BroadbandPlan(signal="burst-random", blocks=6, block_s=8.192, burst_share=0.4),
    "chirp": BroadbandPlan(signal="chirp", blocks=6, block_s=8.192, settle_s=16),
    "sweep": BroadbandPlan(signal="chirp", blocks=3, block_s=30.0),
}
EFFECTS = (
    "added_mass,mass=0.05,x=0.8",
    "gain_error,channel=a05,gain=1.1",
    "trigger_delay,seconds=1e-4",
    "clamp_rotation,k_rot=600",
    "ground_spring,k=800,x=0.6",
    "local_damper,c=2,x=0.7",
    "position_error,channel=a04,dx=0.01",
)
FIELDS = (
    "against",
    "seed",
    "effect",
    "drive",
    "verdict",
    "found",
    "number",
    "low",
    "high",
    "probability",
    "gap",
    "seconds",
)


def trials(effects: int, none: int, drives: list[str]) -> Iterator[tuple[int, str, str]]:
    """Seed, effect and drive of each trial, those with an effect first."""
    yield from ((1 + n, effect, drive) for n, effect in enumerate(EFFECTS[:effects]) for drive in drives)
    yield from ((101 + n, "", drive) for n in range(none) for drive in drives if drive != "impact")


def recorded(seed: int, effect: str, drive: str) -> Campaign:
    address = f"sim://cantilever?seed={seed}" + (f"&effect={effect}" if effect else "")
    with tempfile.TemporaryDirectory() as folder:
        return record_campaign(address, demo_rig(), (DRIVES[drive],), Path(folder), lambda _: None)


def row_of(against: str, seed: int, effect: str, drive: str) -> dict[str, object]:
    campaign = recorded(seed, effect, drive)
    before = recorded(seed, "", "impact") if against == "reference" else None
    reference = model_to_compare(before) if before else None
    begin = time.process_time()
    found = diagnose(campaign) if reference is None else gap_of(campaign, reference, before=before).diagnosis
    row: dict[str, object] = {"against": against, "seed": seed, "effect": effect, "drive": drive}
    gap = found.before if isinstance(found, ModalDiagnosis) else found.gap.before
    row |= {"verdict": found.verdict, "gap": f"{gap:.4g}", "seconds": f"{time.process_time() - begin:.1f}"}
    if found.effects:
        best = found.effects[0]
        name, value = next(iter(best.parameters.items()))
        low, high = best.interval.get(name) or ("", "")
        row |= {"found": "+".join(f.effect for f in found.effects), "probability": f"{best.probability:.3g}"}
        row |= {"number": value, "low": low, "high": high}
    return row


def summary(rows: list[dict[str, str]]) -> None:
    """Print how drives compare with the hammer test."""
    for against in dict.fromkeys(r["against"] for r in rows):
        print(f"against the {against}")
        _summary([r for r in rows if r["against"] == against])


def _summary(rows: list[dict[str, str]]) -> None:
    sound = [r for r in rows if not r["effect"]]
    print(f"no effect: {sum(r['verdict'] == 'no_gap' for r in sound)} of {len(sound)} no gap")
    hit = {r["effect"]: r for r in rows if r["effect"] and r["drive"] == "impact"}
    others = [(r, hit[r["effect"]]) for r in rows if r["effect"] in hit and r["drive"] != "impact"]
    same = [(r, h) for r, h in others if (r["verdict"], r["found"]) == (h["verdict"], h["found"])]
    both = [(r, h) for r, h in same if r["low"] and h["low"]]
    meet = sum(float(r["low"]) <= float(h["high"]) and float(h["low"]) <= float(r["high"]) for r, h in both)
    right = sum(r["found"] == r["effect"].split(",")[0] for r, _ in others)
    print(
        f"{len(others)} with an effect: {right} right, {len(same)} as the hammer test says, {meet} of {len(both)} meet"
    )
    for r, h in others:
        if (r, h) not in same:
            print(f"  {r['effect']} by {r['drive']}: {r['verdict']} {r['found']}, hammer {h['verdict']} {h['found']}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path)
    parser.add_argument("--summary", type=Path)
    parser.add_argument("--reference", action="store_true")
    parser.add_argument("--effects", type=int, default=len(EFFECTS))
    parser.add_argument("--none", type=int, default=10)
    parser.add_argument("--drives", nargs="+", default=list(DRIVES), choices=DRIVES)
    given = parser.parse_args()
    if given.out:
        there = list(csv.DictReader(given.out.open())) if given.out.exists() else []
        against = "reference" if given.reference else "beam"
        done = {(int(r["seed"]), r["effect"], r["drive"]) for r in there if r["against"] == against}
        with given.out.open("a", newline="") as file:
            writer = csv.DictWriter(file, FIELDS, restval="")
            if not there:
                writer.writeheader()
            for trial in trials(given.effects, given.none, given.drives):
                if trial not in done:
                    writer.writerow(row_of(against, *trial))
                    file.flush()
    if given.summary or given.out:
        summary(list(csv.DictReader((given.summary or given.out).open())))


if __name__ == "__main__":
    main()
