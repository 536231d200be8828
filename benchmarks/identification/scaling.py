"""How time and memory grow with channels, lines and order: case B and smaller ones of it, each in its own process.

    OPENBLAS_NUM_THREADS=1 python benchmarks/identification/scaling.py [--only outputs lines order]

Time is processor time of the identification alone; memory is the peak of the process, and what of it is the data.
"""

import argparse
import sys
from pathlib import Path

import numpy as np
from cases import Case, case_b, in_noise
from compare import run
from matching import matched

OWN = Path(__file__).parent / "run_ours.py"
MIDDLE = {"outputs": 50, "lines": 8192, "order": 80}
POINTS = {"outputs": (25, 50, 100, 200), "lines": (2048, 4096, 8192, 16384), "order": (40, 60, 80, 120)}


def smaller(outputs: int, lines: int) -> Case:
    """Case B with fewer outputs, and with other lines over the same band."""
    structure = case_b(0).truth
    case = in_noise(structure, np.linspace(0, 800, lines), 0)
    return Case(case.frequency_hz, case.mobility[:outputs], structure, case.sigma[:outputs])


def point(what: str, value: int) -> str:
    """One line of the table."""
    size = MIDDLE | {what: value}
    case = smaller(size["outputs"], size["lines"])
    result = run([sys.executable, str(OWN), "CASE", str(size["order"])], case)
    found = sum(p is not None for p in matched(case.truth.frequency_hz, np.asarray(result["f"], float)))
    return (
        f"{what:8s} {size['outputs']:7d} {size['lines']:6d} {size['order']:6d} {found:3d} of {case.truth.zeta.size}"
        f" {result['cpu_s']:8.2f} {result['mib']:8.0f} {case.mobility.nbytes / 2**20:9.0f}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="*", choices=[*POINTS], default=[*POINTS])
    arguments = parser.parse_args()
    print("varied   outputs  lines  order   found    cpu s      MiB  data MiB")
    for what in arguments.only:
        for value in POINTS[what]:
            print(point(what, value), flush=True)


if __name__ == "__main__":
    main()
