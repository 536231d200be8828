"""Many seeds of one case: what is found, how wrong, what is spurious, and how often 95 % intervals hold the truth.

    OPENBLAS_NUM_THREADS=1 python benchmarks/identification/coverage.py --case A --seeds 200 [--first 0] [--out a.jsonl]

Cases: A, close, noise (see cases.py) and paper (time records through the paper's protocol, see protocol.py). With --out
each seed is a line of that file as soon as it is done, and seeds that stand there already are not run again: a long run
may be ended and taken up, or be put together from pieces. The table is of all seeds asked for.
"""

import argparse
import json
import time
from pathlib import Path

import numpy as np
from cases import CASES, NO_TRUTH
from coverage_table import INSIDE, table
from matching import matched
from numpy.typing import NDArray
from ours import cramer_rao, identified
from protocol import paper

from modallab.core.model import ModalModel


def one(name: str, seed: int) -> dict:
    begin = time.process_time()
    if name == "paper":
        truth_hz, zeta, phi, model = paper(seed)
        drive: tuple[int, ...] = (phi.shape[1] - 1,)
    else:
        case = CASES[name](seed)
        begin = time.process_time()
        model = identified(case)
        truth_hz, zeta, phi, drive = case.truth.frequency_hz, case.truth.zeta, case.truth.phi, case.truth.drive
    took = time.process_time() - begin
    return {"case": name, "seed": seed, "s": took, **compared(truth_hz, zeta, phi, drive, model)}


def compared(
    truth_hz: NDArray[np.float64],
    zeta: NDArray[np.float64],
    phi: NDArray[np.float64],
    drive: tuple[int, ...],
    model: ModalModel | None,
) -> dict:
    """Each mode's relative errors of f and zeta, both in sigmas, and the constants' shares inside 95 %: re, im."""
    pairs = matched(truth_hz, np.zeros(0) if model is None else model.frequency_hz)
    rows: list[list[float] | None] = []
    for f, z, shape, near in zip(truth_hz, zeta, phi, pairs, strict=True):
        if model is None or near is None:
            rows.append(None)
            continue
        df, dz = model.frequency_hz[near] - f, model.damping_ratio[near] - z
        in_sigmas = [df / model.frequency_sigma_hz[near], dz / model.damping_sigma[near]]
        rows.append([df / f, dz / z, *in_sigmas, *constants_inside(shape, drive, near, model)])
    return {"modes": rows, "spurious": 0 if model is None else model.n_modes - sum(p is not None for p in pairs)}


def constants_inside(
    shape: NDArray[np.float64], drive: tuple[int, ...], near: int, model: ModalModel
) -> tuple[float, float]:
    """Shares of a mode's modal constants, for every driven output, whose real and imaginary parts are inside 95 %."""
    assert model.modal_constant_part_sigma is not None
    away = model.modal_constants[near] - np.outer(shape, shape[list(drive)])
    sigma = model.modal_constant_part_sigma[near]
    return tuple(float(np.mean(np.abs(a) < INSIDE * s)) for a, s in ((away.real, sigma.real), (away.imag, sigma.imag)))


def stored(out: Path | None, name: str) -> dict[int, dict]:
    """Results of the case that stand in the file, by seed; a line cut off by a kill is left out."""
    results: dict[int, dict] = {}
    for text in out.read_text().splitlines() if out is not None and out.exists() else []:
        try:
            row = json.loads(text)
        except json.JSONDecodeError:
            continue
        if row["case"] == name:
            results[row["seed"]] = row
    return results


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--case", choices=[*CASES, "paper"], default="A")
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--out", type=Path, help="file of results, one line a seed, appended to")
    arguments = parser.parse_args()
    done = stored(arguments.out, arguments.case)
    seeds = range(arguments.first, arguments.first + arguments.seeds)
    for seed in seeds:
        if seed in done:
            continue
        done[seed] = one(arguments.case, seed)
        if arguments.out is not None:
            with arguments.out.open("a") as target:
                target.write(json.dumps(done[seed]) + "\n")
    bound = None
    if arguments.case not in NO_TRUTH:
        case = CASES[arguments.case](0)
        bound = cramer_rao(case) / np.stack([case.truth.frequency_hz, case.truth.zeta], axis=1)
    table([done[seed] for seed in seeds], bound)


if __name__ == "__main__":
    main()
