"""Many seeds of one case: what is found, how wrong, what is spurious, and how often 95 % intervals hold the truth.

    OPENBLAS_NUM_THREADS=1 python benchmarks/identification/coverage.py --case A --seeds 200 [--first 0] [--json a.json]

Cases: A, close, noise (see cases.py) and paper (time records through the paper's protocol, see protocol.py).
"""

import argparse
import json
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from cases import CASES
from numpy.typing import NDArray
from ours import cramer_rao, identified
from protocol import paper

from modallab.schema.model import ModalModel

BAND_OF_TRUTH = 0.01
"""A model's mode within 1 % of a true frequency is that mode; one that is nobody's is spurious."""


def one(name: str, seed: int) -> dict:
    begin = time.process_time()
    if name == "paper":
        truth_hz, zeta, model = paper(seed)
    else:
        case = CASES[name](seed)
        begin = time.process_time()
        model = identified(case)
        truth_hz, zeta = case.truth.frequency_hz, case.truth.zeta
    took = time.process_time() - begin
    return {
        "seed": seed,
        "s": took,
        **compared(truth_hz, zeta, model),
    }


def compared(truth_hz: NDArray[np.float64], zeta: NDArray[np.float64], model: ModalModel | None) -> dict:
    rows: list[list[float] | None] = []
    taken: set[int] = set()
    for f, z in zip(truth_hz, zeta, strict=True):
        free = [] if model is None else [i for i in range(model.n_modes) if i not in taken]
        near = min(free, key=lambda i: abs(model.frequency_hz[i] / f - 1), default=None)
        if near is None or abs(model.frequency_hz[near] / f - 1) > BAND_OF_TRUTH:
            rows.append(None)
            continue
        taken.add(near)
        rows.append(
            [
                model.frequency_hz[near] / f - 1,
                model.damping_ratio[near] / z - 1,
                (model.frequency_hz[near] - f) / model.frequency_sigma_hz[near],
                (model.damping_ratio[near] - z) / model.damping_sigma[near],
            ]
        )
    return {"modes": rows, "spurious": 0 if model is None else model.n_modes - len(taken)}


def table(results: Sequence[dict], bound: NDArray[np.float64] | None, truth_hz: NDArray[np.float64] | None) -> None:
    n_modes = len(results[0]["modes"])
    whole = sum(all(m is not None for m in r["modes"]) for r in results)
    print(
        f"{len(results)} seeds: all {n_modes} modes found in {whole}; spurious modes in "
        f"{sum(r['spurious'] > 0 for r in results)} ({sum(r['spurious'] for r in results)} in all); "
        f"{np.median([r['s'] for r in results]):.2f} s of processor each"
    )
    print(
        "mode  worst f %   (bound)   worst zeta %  (bound)   in 95 %: f   zeta   scatter/sigma: f  zeta"
        "   bias/sigma: f  zeta"
    )
    for mode in range(n_modes):
        rows = np.array([r["modes"][mode] for r in results if r["modes"][mode] is not None])
        if not rows.size:
            print(f"{mode + 1:4d}  never found")
            continue
        inside = 100 * np.mean(np.abs(rows[:, 2:]) < 1.96, axis=0)
        least = ["", ""] if bound is None or truth_hz is None else [f"{100 * b:.5f}" for b in bound[mode]]
        worst = 100 * np.abs(rows[:, :2]).max(axis=0)
        print(
            f"{mode + 1:4d} {worst[0]:10.5f} {least[0]:>9s} {worst[1]:13.4f} {least[1]:>9s} "
            f"{inside[0]:12.1f} {inside[1]:6.1f} {rows[:, 2].std():14.2f} {rows[:, 3].std():6.2f}"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--case", choices=[*CASES, "paper"], default="A")
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    results = [one(arguments.case, seed) for seed in range(arguments.first, arguments.first + arguments.seeds)]
    bound = truth_hz = None
    if arguments.case not in ("paper", "noise"):
        case = CASES[arguments.case](0)
        truth_hz = case.truth.frequency_hz
        bound = cramer_rao(case) / np.stack([truth_hz, case.truth.zeta], axis=1)
    table(results, bound, truth_hz)
    if arguments.json:
        arguments.json.write_text(json.dumps(results))


if __name__ == "__main__":
    main()
