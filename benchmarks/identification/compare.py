"""The project beside its peers in one run: modes found, errors beside the Cramer-Rao bound, time and memory.

    OPENBLAS_NUM_THREADS=1 python benchmarks/identification/compare.py --peers FOLDER [--case A B close] [--only sdypy]

FOLDER is what make_peers.py made. Everybody runs in a process of their own. Time is processor time without imports and
without reading of files; memory is the process's peak. A mode is found if an estimate of its own lies within 1 % of it
and nearer to it than to any other mode. Beside each worst error stands the bound (one sigma) of that very mode.
"""

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np
from cases import CASES, Case
from matching import matched
from numpy.typing import NDArray
from ours import cramer_rao
from printed import printed

from modallab.identification.selection.criteria import mac

HERE = Path(__file__).parent
ORDER = {"A": 60, "B": 80, "close": 40}
PEERS = ("sdypy", "sdynpy", "pyyeti", "pyoma")
HEAD = "who      found      worst f %  (bound)   worst zeta %  (bound)      cpu s       MiB"


def run(command: list[str], case: Case) -> dict:
    """What the command, given a file of the case, prints as JSON."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "case.npz"
        requested, drive = case.truth.frequency_hz, np.array(case.truth.drive)
        np.savez(path, frequency_hz=case.frequency_hz, mobility=case.mobility, requested_hz=requested, drive=drive)
        return printed([part if part != "CASE" else str(path) for part in command])


def worst_mac(case: Case, shapes: list[dict[str, list[float]]], pairs: list[int | None]) -> float:
    """Least MAC of a found mode's shape with the true one."""
    values = [np.nan]
    for true, near in zip(case.truth.phi, pairs, strict=True):
        if near is not None:
            shape = np.array(shapes[near]["real"]) + 1j * np.array(shapes[near]["imag"])
            values.append(float(mac(shape[None], true[None, : shape.size])[0, 0]))
    return float(np.nanmin(values))


def line(name: str, case: Case, bound: NDArray[np.float64], result: dict) -> str:
    if "failed" in result:
        used = f" ({result['cpu_s']:.0f} s, {result['mib']:.0f} MiB)" if "cpu_s" in result else ""
        return f"{name:8s} failed: {result['failed'][:90]}{used}"
    truth, f, zeta = case.truth, np.asarray(result["f"], float), np.asarray(result["zeta"], float)
    pairs = matched(truth.frequency_hz, f)
    found = [mode for mode, near in enumerate(pairs) if near is not None]
    near = [pairs[mode] for mode in found]
    cells = []
    for estimates, true, least in ((f, truth.frequency_hz, bound[:, 0]), (zeta, truth.zeta, bound[:, 1])):
        errors = np.abs(estimates[near] / true[found] - 1)
        worst = int(np.argmax(errors)) if found else 0
        cells.append(f"{100 * errors[worst]:11.5f} {100 * least[found[worst]]:9.5f}" if found else 21 * " ")
    shapes = f"   worst MAC {worst_mac(case, result['shapes'], pairs):.7f}" if "shapes" in result else ""
    count = f"{name:8s} {len(found):3d} of {truth.zeta.size:2d}"
    return f"{count} {cells[0]} {cells[1]} {result['cpu_s']:10.2f} {result['mib']:9.0f}{shapes}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--peers", type=Path, required=True)
    parser.add_argument("--case", nargs="+", choices=[*ORDER], default=["A", "close", "B"])
    parser.add_argument("--only", nargs="*", default=PEERS)
    parser.add_argument("--outputs", type=int, help="of case B, fewer than 200")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--limit", type=int, default=900, help="processor seconds after which a peer is ended")
    arguments = parser.parse_args()
    python = arguments.peers / ("Scripts" if sys.platform == "win32" else "bin") / "python"
    for name in arguments.case:
        case = CASES[name](arguments.seed)
        if arguments.outputs:
            few = slice(arguments.outputs)
            case = Case(case.frequency_hz, case.mobility[few], case.truth, case.sigma[few])
        bound = cramer_rao(case) / np.stack([case.truth.frequency_hz, case.truth.zeta], axis=1)
        shape = " x ".join(map(str, case.mobility.shape))
        print(f"case {name}: {shape}, {case.truth.zeta.size} modes, order {ORDER[name]}\n{HEAD}")
        own = [sys.executable, str(HERE / "run_ours.py"), "CASE", str(ORDER[name] if name == "B" else 0)]
        print(line("modallab", case, bound, run(own, case)), flush=True)
        for other in arguments.only:
            # Isolated: a file of this folder must not stand for a package of theirs (numba looks for `coverage`).
            command = [str(python), "-I", "-W", "ignore", str(HERE / "run_peer.py"), other, "CASE", str(ORDER[name])]
            print(line(other, case, bound, run([*command, str(arguments.limit)], case)), flush=True)


if __name__ == "__main__":
    main()
