"""The same test again and again on one simulated bench: is the scatter of what is found as large as is stated?

    OPENBLAS_NUM_THREADS=1 python benchmarks/identification/repeated.py --seeds 3 --repeats 8 --out FOLDER

On each bench, put together as in an ordinary lab, `--repeats` times the same hits at the same points. Each time is
identified by itself. For every mode it prints the scatter of frequency and damping over the times as a ratio to the
stated sigma (median): 1 is right. The frequency is taken beside its straight line over the times, since the bench's
stiffness drifts, which is no scatter. Campaigns are kept in the folder and not recorded again.
"""

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import modallab as ml
from modallab.core.block import Block, Campaign
from modallab.core.model import ModalModel
from modallab.core.plan import ImpactPlan
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.identification.options import IdentificationOptions
from modallab.pipelines.identify import identify_campaign

Real = NDArray[np.float64]
GOAL = (0.7, 1.5)


def recorded(folder: Path, seed: int, repeats: int, points: tuple[int, ...], hits: int, tolerances: str) -> Campaign:
    name = f"{tolerances}_{seed}_{repeats}_{'-'.join(map(str, points))}_{hits}.h5"
    if not (folder / name).exists():
        folder.mkdir(parents=True, exist_ok=True)
        plans = [ImpactPlan(points=points, hits=hits)] * repeats
        ml.simulate(seed=seed, tolerances=tolerances, plan=plans, progress=False).save(folder / name)  # type: ignore[arg-type]
    return read_campaign(folder / name)


def times(campaign: Campaign, per_time: int) -> list[Campaign]:
    blocks: tuple[Block, ...] = campaign.of("impact")
    return [replace(campaign, blocks=blocks[k : k + per_time]) for k in range(0, len(blocks), per_time)]


def identified(campaign: Campaign, per_time: int, band: tuple[float, float]) -> list[ModalModel]:
    options = IdentificationOptions(band_hz=band)
    return [identify_campaign(one, options, "impact").identified[0].model for one in times(campaign, per_time)]


def ratios(models: list[ModalModel]) -> tuple[Real, Real]:
    """(modes, 2) scatter over stated sigma of frequency and damping, and (modes,) the drift of the frequency."""
    count = min(m.n_modes for m in models)
    f, zeta = (np.array([getattr(m, name)[:count] for m in models]) for name in ("frequency_hz", "damping_ratio"))
    sigmas = [np.array([getattr(m, name)[:count] for m in models]) for name in ("frequency_sigma_hz", "damping_sigma")]
    n = np.arange(len(models))
    line = np.polyfit(n, f, 1)
    left = f - (np.outer(n, line[0]) + line[1])
    scatter = np.sqrt(np.sum(left**2, axis=0) / (len(n) - 2)), zeta.std(axis=0, ddof=1)
    ratio = np.stack([s / np.median(sigma, axis=0) for s, sigma in zip(scatter, sigmas, strict=True)], axis=1)
    return ratio, line[0] * len(n) / f.mean(axis=0)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--repeats", type=int, default=8)
    parser.add_argument("--points", type=int, nargs="+", default=[10])
    parser.add_argument("--hits", type=int, default=5)
    parser.add_argument("--tolerances", choices=("usual", "none"), default="usual")
    parser.add_argument("--band", type=float, nargs=2, default=(3.0, 110.0))
    parser.add_argument("--out", type=Path, required=True)
    a = parser.parse_args()
    every: list[Real] = []
    for seed in range(a.first, a.first + a.seeds):
        campaign = recorded(a.out, seed, a.repeats, tuple(a.points), a.hits, a.tolerances)
        found = identified(campaign, a.hits * len(a.points), (a.band[0], a.band[1]))
        ratio, drift = ratios(found)
        every.append(ratio)
        for mode, (row, moved) in enumerate(zip(ratio, drift, strict=True), start=1):
            said = f"{found[0].frequency_hz[mode - 1]:9.4f} Hz, drift {100 * moved:+.4f} %"
            print(f"seed {seed} mode {mode} {said}: f {row[0]:5.2f}  zeta {row[1]:5.2f}", flush=True)
    count = min(map(len, every))
    together = np.sqrt(np.mean([r[:count] ** 2 for r in every], axis=0))
    for mode, row in enumerate(together, start=1):
        good = all(GOAL[0] <= value <= GOAL[1] for value in row)
        print(f"mode {mode}, rms over seeds: f {row[0]:.2f}  zeta {row[1]:.2f}{'' if good else '  outside the goal'}")


if __name__ == "__main__":
    main()
