"""Files of other programs, written after their formats' own documents, against the numbers that they were written from.

    python benchmarks/formats/run.py [--out FOLDER] [--only NAME ...] [--table FILE.csv]

Prints each case as right, rejected (for a reason that the case calls true), untrue (rejected for another) or WRONG.
Ends with 1 if any is wrong. `FOLDER` keeps the files, and the table lists the outcomes.
"""

import argparse
import contextlib
import csv
import importlib
import io
import os
import re
import sys
import tempfile
import warnings
from pathlib import Path

import numpy as np
from known import CASES, Case, Known, KnownFrf, Record

from modallab.cli import main
from modallab.core.block import Campaign
from modallab.formats import read_campaign
from modallab.signals.signals import to_signals

for module in sorted(Path(__file__).parent.glob("*_cases.py")):
    importlib.import_module(module.stem)

OUTCOMES = ("right", "rejected", "untrue", "WRONG")


def imported(known: Known) -> tuple[int, str]:
    """Exit code and what was printed."""
    if known.rig:
        Path("rig.yaml").write_text(known.rig, encoding="utf-8")
    rig = ("--rig", "rig.yaml") if known.rig else ()
    text = io.StringIO()
    with contextlib.redirect_stdout(text), contextlib.redirect_stderr(text), warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            code = main(["import", *known.files, *rig, *known.options, "--out", "out.h5"])
        except SystemExit as left:
            code = left.code
    return int(code or 0), text.getvalue()


def off(found: np.ndarray, right: np.ndarray) -> float:
    """Largest difference over the largest number; infinite where lengths differ."""
    if found.shape != right.shape:
        return np.inf
    return float(np.abs(found - right).max() / np.abs(right).max())


def records_wrong(campaign: Campaign, records: tuple[Record, ...], tolerance: float) -> str:
    if len(campaign.blocks) != len(records):
        return f"{len(campaign.blocks)} records, not {len(records)}"
    for block, right in zip(campaign.blocks, records, strict=True):
        signals = to_signals(block, campaign.rig)
        if abs(signals.rate_hz / right.rate - 1) > 1e-6:
            return f"{block.name}: {signals.rate_hz!r} Hz, not {right.rate!r}"
        for name, found, row in zip(
            ("force", "a1", "a2"), (signals.forces[0], *signals.responses), right.rows, strict=True
        ):
            if not off(found, row) <= tolerance:
                return f"{block.name}, {name}: {len(found)} samples, not {len(row)}, or off by {off(found, row):.3g}"
    return ""


def frf_wrong(campaign: Campaign, right: KnownFrf, tolerance: float) -> str:
    if len(campaign.frfs) != 1:
        return f"{len(campaign.frfs)} sets of FRFs"
    frf = campaign.frfs[0]
    if frf.quantity != right.quantity:
        return f"{frf.quantity}, not {right.quantity}"
    values = frf.values[:, 0]
    if not (off(frf.frequency_hz, right.frequency) <= 1e-5 and off(values, right.values) <= tolerance):
        return f"lines off by {off(frf.frequency_hz, right.frequency):.3g}, values by {off(values, right.values):.3g}"
    if right.coherence is not None and (frf.coherence is None or off(frf.coherence[:, 0], right.coherence) > tolerance):
        return "the coherence is missing or wrong"
    return ""


def outcome(case: Case, folder: Path) -> tuple[str, str]:
    """What came of a case, and what is wrong or the reason given."""
    folder.mkdir(parents=True, exist_ok=True)
    with contextlib.chdir(folder):
        known = case.write(Path())
        code, said = imported(known)
        said = " ".join(said.split())
        if code:
            blamed = known.healthy and re.search("is damaged|copy the file again|is no whole", said)
            true = known.rejected and re.search(known.rejected, said) and not blamed
            return ("rejected" if true else "untrue"), said
        numbers = known.records or known.frf or known.check
        if not numbers:
            return "WRONG", "taken, must be rejected: " + said
        problem = wrong(known)
        if known.says and not re.search(known.says, said):
            problem = problem or f"no word of {known.says}: {said}"
        return ("WRONG" if problem else "right"), problem


def wrong(known: Known) -> str:
    problem = ""
    if known.frf:
        problem = frf_wrong(read_campaign(Path("out.h5")), known.frf, known.tolerance)
    elif known.records:
        problem = records_wrong(read_campaign(Path("out.h5")), known.records, known.tolerance)
    return problem or (known.check(Path()) if known.check else "")


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--out", type=Path)
    parser.add_argument("--only", nargs="+", default=[])
    parser.add_argument("--table", type=Path)
    return parser.parse_args()


def run() -> int:
    asked = arguments()
    rows = []
    with tempfile.TemporaryDirectory() as scratch:
        root = (asked.out or Path(scratch)).absolute()
        for case in CASES:
            if asked.only and case.name not in asked.only and case.kind not in asked.only:
                continue
            came, why = outcome(case, root / case.name)
            rows.append((case.kind, case.name, case.about, came, why))
            print(f"{came:8s} {case.kind:10s} {case.name}: {why[:400]}", flush=True)
    counts = {name: sum(row[3] == name for row in rows) for name in OUTCOMES}
    print(f"{len(rows)} cases:", ", ".join(f"{n} {name}" for name, n in counts.items()))
    if asked.table:
        with asked.table.open("w", encoding="utf-8", newline="") as file:
            csv.writer(file, lineterminator=os.linesep).writerows(
                [("kind", "case", "file", "outcome", "reason"), *rows]
            )
    return int(counts["WRONG"] > 0)


if __name__ == "__main__":
    sys.exit(run())
