"""Accuracy of the demo bench over many seeds, and whether the stated sigma is the scatter's.

Five impact blocks at one point, and the sine test with 24 frequencies, on another bench for every seed; each identified
as `modallab identify` would. Prints the worst errors, the scatter in units of the stated sigma, and the half-power
reading.

    python benchmarks/demo_seeds.py --seeds 100 [--first 1] [--only impact]
"""

import argparse
import json
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from modallab.cli.demo import demo_rig
from modallab.core.plan import ImpactPlan, SinePlan
from modallab.identification.options import IdentificationOptions
from modallab.pipelines.identify import identify_campaign
from modallab.pipelines.report import modes_as_built
from modallab.service.campaigns.local_session import record_campaign

MODES = 3


PLANS = {"impact": ImpactPlan(points=(10,), hits=5), "sine": SinePlan()}


def one_seed(seed: int, tests: Sequence[str]) -> list[dict]:
    rig = demo_rig()
    with tempfile.TemporaryDirectory() as folder:
        plans = tuple(PLANS[test] for test in tests)
        campaign = record_campaign(f"sim://cantilever?seed={seed}", rig, plans, Path(folder), lambda event: None)
    truth = modes_as_built(campaign)
    rows = []
    for item in identify_campaign(campaign, IdentificationOptions()).identified:
        model = item.model
        for r in range(MODES):
            true_f, true_z = truth.frequency_hz[r], truth.damping_ratio[r]
            near = int(np.argmin(np.abs(model.frequency_hz - true_f)))
            rows.append(
                {
                    "seed": seed,
                    "test": item.source,
                    "mode": r + 1,
                    "f": model.frequency_hz[near] / true_f - 1,
                    "z": model.damping_ratio[near] / true_z - 1,
                    "f_sigmas": (model.frequency_hz[near] - true_f) / model.frequency_sigma_hz[near],
                    "z_sigmas": (model.damping_ratio[near] - true_z) / model.damping_sigma[near],
                    "f_hz": model.frequency_hz[near],
                    "f_sigma_hz": model.frequency_sigma_hz[near],
                    "zeta": model.damping_ratio[near],
                    "zeta_sigma": model.damping_sigma[near],
                    "half_power": model.half_power[near],
                    "modes": model.n_modes,
                    "spurious": sum(
                        bool(np.min(np.abs(truth.frequency_hz / f - 1)) > 0.01) for f in model.frequency_hz
                    ),
                }
            )
    return rows


def table(rows: list[dict]) -> None:
    print("test    mode   worst f %   worst zeta %   scatter/sigma f   zeta   worst sigmas f  zeta   half-power %")
    for test in PLANS:
        for mode in range(1, MODES + 1):
            part = [r for r in rows if r["test"] == test and r["mode"] == mode]
            if not part:
                continue
            get = lambda key: np.array([r[key] for r in part])  # noqa: B023, E731
            half = 100 * get("half_power")
            print(
                f"{test:7s} {mode:4d} {100 * np.max(np.abs(get('f'))):11.5f} {100 * np.max(np.abs(get('z'))):14.4f}"
                f" {np.std(get('f_sigmas')):17.2f} {np.std(get('z_sigmas')):6.2f}"
                f" {np.max(np.abs(get('f_sigmas'))):15.1f} {np.max(np.abs(get('z_sigmas'))):5.1f}"
                f"   {np.nanmin(half):.2f} to {np.nanmax(half):.2f}"
            )
    print(f"spurious modes: {sum(r['spurious'] for r in rows if r['mode'] == 1)}")
    agree = []
    for seed in {r["seed"] for r in rows}:
        for mode in range(1, MODES + 1):
            pair = {r["test"]: r for r in rows if r["seed"] == seed and r["mode"] == mode}
            if len(pair) == 2:
                a, b = pair["impact"], pair["sine"]
                agree.append((a["f_hz"] - b["f_hz"]) / np.hypot(a["f_sigma_hz"], b["f_sigma_hz"]))
                agree.append((a["zeta"] - b["zeta"]) / np.hypot(a["zeta_sigma"], b["zeta_sigma"]))
    if not agree:
        return
    rms, worst = np.sqrt(np.mean(np.square(agree))), np.max(np.abs(agree))
    print(f"sine against impact, in joint sigmas: rms {rms:.2f}, worst {worst:.1f}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--only", choices=[*PLANS], help="one test alone")
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    tests = [arguments.only] if arguments.only else [*PLANS]
    seeds = range(arguments.first, arguments.first + arguments.seeds)
    rows = [row for seed in seeds for row in one_seed(seed, tests)]
    table(rows)
    if arguments.json:
        arguments.json.write_text(json.dumps(rows))


if __name__ == "__main__":
    main()
