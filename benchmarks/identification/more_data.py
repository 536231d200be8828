"""Does a plan with more points and hits find every mode that a part of it finds?

    OPENBLAS_NUM_THREADS=1 python benchmarks/identification/more_data.py --seeds 10 [--points 10 6 3] [--sizes 1 3 10]
        [--benches usual] --out FOLDER

For every seed, on the ideal bench and on one put together as in a lab, `--hits` hits at each of the points are recorded
once, and plans of fewer points and of fewer hits are cut out of them. By default the points are those of the page's own
plan; 10 6 3 are those of the command's and the notebook's. A mode that a plan finds and a larger one, which holds all
of its hits, does not find is lost. Prints the modes lost and those that are none, and writes FOLDER/more_data.csv.
"""

import argparse
import csv
from dataclasses import replace
from pathlib import Path

import numpy as np

import modallab as ml
from modallab.core.block import Campaign
from modallab.core.plan import ImpactPlan
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.identification.options import IdentificationOptions
from modallab.pipelines.identify import identify_campaign
from modallab.pipelines.report import modes_as_built

SAME = 1e-3


def recorded(folder: Path, seed: int, tolerances: str, points: tuple[int, ...], most: int) -> Campaign:
    path = folder / f"{tolerances}_{seed}_{len(points)}_{most}.h5"
    if not path.exists():
        plan = ImpactPlan(points=points, hits=most)
        ml.simulate(seed=seed, tolerances=tolerances, plan=plan, progress=False).save(path)  # type: ignore[arg-type]
    return read_campaign(path)


def part(campaign: Campaign, points: tuple[int, ...], hits: int) -> Campaign:
    of = [[b for b in campaign.blocks if b.drive_point == p][:hits] for p in points]
    return replace(campaign, blocks=tuple(b for blocks in of for b in blocks))


def unlike(frequency_hz: np.ndarray, others_hz: np.ndarray) -> list[float]:
    return [float(f) for f in frequency_hz if np.min(np.abs(others_hz / f - 1), initial=np.inf) > SAME]


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--seeds", type=int, default=10)
    arguments.add_argument("--first", type=int, default=1)
    arguments.add_argument("--hits", type=int, default=10)
    arguments.add_argument("--points", type=int, nargs="+", default=list(range(10, 0, -1)))
    arguments.add_argument("--benches", nargs="+", default=["none", "usual"])
    arguments.add_argument("--sizes", type=int, nargs="+", default=[1, 2, 3, 5, 7, 10], help="of plans: points, hits")
    arguments.add_argument("--out", type=Path, required=True)
    asked = arguments.parse_args()
    asked.out.mkdir(parents=True, exist_ok=True)
    sizes = [h for h in asked.sizes if h <= asked.hits]
    counts = [p for p in asked.sizes if p <= len(asked.points)]
    with (asked.out / "more_data.csv").open("w", newline="") as file:
        out = csv.writer(file)
        out.writerow(["seed", "tolerances", "points", "hits", "modes", "lost_hz", "spurious_hz"])
        for seed in range(asked.first, asked.first + asked.seeds):
            for tolerances in asked.benches:
                campaign = recorded(asked.out, seed, tolerances, tuple(asked.points), asked.hits)
                true = modes_as_built(campaign).frequency_hz
                found: dict[tuple[int, int], np.ndarray] = {}
                for points in counts:
                    for hits in sizes:
                        cut = part(campaign, tuple(asked.points[:points]), hits)
                        model = identify_campaign(cut, IdentificationOptions()).identified[0].model
                        smaller = [f for (p, h), f in found.items() if p <= points and h <= hits]
                        known = np.concatenate([*smaller, np.empty(0)])
                        real = known[[not unlike(np.array([f]), true) for f in known]] if known.size else known
                        found[points, hits] = model.frequency_hz
                        missed = unlike(real, model.frequency_hz), unlike(model.frequency_hz, true)
                        lost, none = (" ".join(map(str, sorted({round(f, 1) for f in of}))) for of in missed)
                        out.writerow([seed, tolerances, points, hits, model.n_modes, lost, none])
                        if lost or none:
                            print(seed, tolerances, points, hits, f"lost: {lost}; spurious: {none}", flush=True)
                        file.flush()


if __name__ == "__main__":
    main()
