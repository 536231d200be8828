"""The project beside its peers in one run: modes found, errors beside the Cramer-Rao bound, time and memory.

    OPENBLAS_NUM_THREADS=1 python benchmarks/identification/compare.py --peers FOLDER [--case A B close] [--only sdypy]

FOLDER is what make_peers.py made. Time is processor time of one process, without imports of the project or reading of
files; a mode is found if an estimate lies within 1 % of it.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from cases import CASES, Case
from ours import cramer_rao, identified

from modallab.identification.criteria import mac
from modallab.schema.model import ModalModel

HERE = Path(__file__).parent
ORDER = {"A": 60, "B": 80, "close": 40}
PEERS = ("sdypy", "sdynpy", "pyyeti", "pyoma")


def ours(case: Case, order: int | None) -> dict:
    begin = time.process_time()
    model = identified(case, order)
    took = time.process_time() - begin
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    found = {"f": [], "zeta": []} if model is None else {"f": model.frequency_hz, "zeta": model.damping_ratio}
    return {**found, "cpu_s": took, "mib": memory, "mac": worst_mac(case, model)}


def worst_mac(case: Case, model: ModalModel | None) -> float:
    """Least MAC of a found mode's shape, from its loudest input, with the true one."""
    if model is None:
        return float("nan")
    values = []
    for r, f in enumerate(model.frequency_hz):
        true = case.truth.phi[int(np.argmin(np.abs(case.truth.frequency_hz - f)))]
        column = model.modal_constants[r][:, np.argmax(np.sum(np.abs(model.modal_constants[r]), axis=0))]
        values.append(float(mac(column[None], true[None, : column.size])[0, 0]))
    return min(values)


def peer(python: Path, name: str, case: Case, order: int) -> dict:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "case.npz"
        truth = case.truth.frequency_hz
        np.savez(path, frequency_hz=case.frequency_hz, mobility=case.mobility, wanted_hz=truth)
        command = [str(python), "-W", "ignore", str(HERE / "run_peer.py"), name, str(path), str(order)]
        done = subprocess.run(
            command, capture_output=True, text=True, check=False, env=os.environ | {"QT_QPA_PLATFORM": "offscreen"}
        )
    if done.returncode:
        return {"failed": done.stderr.strip().splitlines()[-1] if done.stderr.strip() else "killed"}
    return json.loads(done.stdout.splitlines()[-1])


def line(name: str, case: Case, result: dict) -> str:
    if "failed" in result:
        return f"{name:8s} failed: {result['failed'][:90]}"
    truth, f, zeta = case.truth, np.asarray(result["f"], float), np.asarray(result["zeta"], float)
    errors = []
    for true_f, true_z in zip(truth.frequency_hz, truth.zeta, strict=True):
        near = np.flatnonzero(np.abs(f / true_f - 1) < 0.01)
        if near.size:
            i = near[np.argmin(np.abs(f[near] - true_f))]
            errors.append((abs(f[i] / true_f - 1), abs(zeta[i] / true_z - 1)))
    shapes = f"   worst MAC {result['mac']:.7f}" if "mac" in result else ""
    worst = 100 * np.array(errors).max(axis=0) if errors else (np.nan, np.nan)
    return (
        f"{name:8s} {len(errors):3d} of {truth.zeta.size:2d} {worst[0]:11.5f} {worst[1]:14.4f} "
        f"{result['cpu_s']:9.2f} {result['mib']:9.0f}{shapes}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--peers", type=Path, required=True)
    parser.add_argument("--case", nargs="+", choices=[*ORDER], default=["A", "close", "B"])
    parser.add_argument("--only", nargs="*", default=PEERS)
    parser.add_argument("--outputs", type=int, help="of case B, fewer than 200")
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    python = arguments.peers / ("Scripts" if sys.platform == "win32" else "bin") / "python"
    for name in arguments.case:
        case = CASES[name](arguments.seed)
        if arguments.outputs:
            case = Case(
                case.frequency_hz, case.mobility[: arguments.outputs], case.truth, case.sigma[: arguments.outputs]
            )
        shape = " x ".join(map(str, case.mobility.shape))
        print(f"case {name}: {shape}, {case.truth.zeta.size} modes, order {ORDER[name]}")
        print("who      found      worst f %   worst zeta %     cpu s       MiB")
        print(line("modallab", case, ours(case, ORDER[name] if name == "B" else None)), flush=True)
        for other in arguments.only:
            print(line(other, case, peer(python, other, case, ORDER[name])), flush=True)
        if not arguments.outputs:
            bound = cramer_rao(case) / np.stack([case.truth.frequency_hz, case.truth.zeta], axis=1)
            print(f"bound (one sigma, worst mode) {100 * bound[:, 0].max():.5f} {100 * bound[:, 1].max():.4f}")


if __name__ == "__main__":
    main()
