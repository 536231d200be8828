"""Random, burst-random, pseudo-random (a multisine) and chirp against the hammer, on one simulated bench.

    OPENBLAS_NUM_THREADS=1 python benchmarks/identification/drives.py --seed 1 --out FOLDER

For every mode and drive: frequency and damping, how many joint sigmas they lie from those of the hammer, and from the
truth. Campaigns are kept in the folder and not recorded again.
"""

import argparse
from pathlib import Path

import numpy as np

import modallab as ml
from modallab.core.block import Campaign
from modallab.core.errors import ModallabError
from modallab.core.model import ModalModel
from modallab.core.plan import BroadbandPlan, ImpactPlan
from modallab.core.units import BROADBAND
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.identification.options import IdentificationOptions
from modallab.pipelines.identify import identify_campaign
from modallab.pipelines.report import modes_as_built

SAME = 0.02


def recorded(folder: Path, seed: int, test: str, blocks: int) -> Campaign:
    path = folder / f"{test}_{seed}_{blocks}.h5"
    if not path.exists():
        folder.mkdir(parents=True, exist_ok=True)
        hit = ImpactPlan(points=(10,), hits=5)
        plan = hit if test == "impact" else BroadbandPlan(signal=test, blocks=blocks, band_hz=(2.0, 200.0))  # type: ignore[arg-type]
        ml.simulate(seed=seed, plan=plan, progress=False).save(path)
    return read_campaign(path)


def sigmas(model: ModalModel, r: int, f: float, zeta: float, f_sigma: float = 0.0, zeta_sigma: float = 0.0) -> str:
    away = (model.frequency_hz[r] - f) / np.hypot(model.frequency_sigma_hz[r], f_sigma)
    damped = (model.damping_ratio[r] - zeta) / np.hypot(model.damping_sigma[r], zeta_sigma)
    return f"{away:+6.2f} {damped:+6.2f}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--blocks", type=int, default=20)
    parser.add_argument("--band", type=float, nargs=2, default=(3.0, 110.0))
    parser.add_argument("--tests", nargs="+", default=["impact", *BROADBAND], choices=["impact", *BROADBAND])
    parser.add_argument("--out", type=Path, required=True)
    a = parser.parse_args()
    hit: ModalModel | None = None
    print("drive          mode        f [Hz]     zeta [%]   sigmas from impact: f zeta   from the truth: f zeta")
    for test in a.tests:
        campaign = recorded(a.out, a.seed, test, a.blocks)
        truth = modes_as_built(campaign)
        try:
            model = (
                identify_campaign(campaign, IdentificationOptions(band_hz=(a.band[0], a.band[1]))).identified[0].model
            )
        except ModallabError as error:
            print(f"{test}: {error}", flush=True)
            continue
        hit = model if test == "impact" else hit
        for r, f in enumerate(model.frequency_hz):
            of_hit = "" if hit is None or test == "impact" else beside(model, r, hit)
            of_truth = ""
            if truth is not None:
                k = int(np.argmin(np.abs(truth.frequency_hz - f)))
                of_truth = sigmas(model, r, float(truth.frequency_hz[k]), float(truth.damping_ratio[k]))
            print(
                f"{test:14s} {r + 1:4d} {f:13.5f} {100 * model.damping_ratio[r]:12.5f}   {of_hit:>25s}   {of_truth}",
                flush=True,
            )
        for note in model.notes:
            print(f"  {test}: {note}", flush=True)


def beside(model: ModalModel, r: int, hit: ModalModel) -> str:
    k = int(np.argmin(np.abs(hit.frequency_hz - model.frequency_hz[r])))
    if abs(hit.frequency_hz[k] / model.frequency_hz[r] - 1) > SAME:
        return "not there"
    known = hit.frequency_hz[k], hit.damping_ratio[k], hit.frequency_sigma_hz[k], hit.damping_sigma[k]
    return sigmas(model, r, *map(float, known))


if __name__ == "__main__":
    main()
