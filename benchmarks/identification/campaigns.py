"""Every campaign of a folder through `modallab identify --json`: exit codes, and the errors where the truth is plain.

    OPENBLAS_NUM_THREADS=1 python benchmarks/identification/campaigns.py FOLDER --out results.jsonl [--only-clean]

Each subfolder holds a campaign, its rig file and a `truth.yaml` with `effects`, `true_E`, `true_thickness`, `true_rho`
(SI) and `true_zeta`, of as many modes as are stated. A campaign without effects is a plain cantilever with rotary
inertia, so its frequencies are known in closed form. Campaigns that stand in the file of results are not run again.
One process runs all.
"""

import argparse
import contextlib
import io
import json
import tempfile
import time
import traceback
from collections import Counter, defaultdict
from pathlib import Path

import numpy as np
import yaml
from beam_truth import rayleigh_hz
from matching import matched

from modallab.cli import main as modallab

MODES = 12


def identified(folder: Path) -> dict:
    """Exit code, what was said on the error stream, and the models of one campaign."""
    said, begin = io.StringIO(), time.process_time()
    with tempfile.TemporaryDirectory() as scratch:
        file = Path(scratch) / "models.json"
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(said):
            try:
                code = modallab(["identify", str(folder), "--json", str(file)])
            except Exception:  # what is not typed is what is looked for
                code, _ = -1, said.write(traceback.format_exc())
        models = json.loads(file.read_text()) if file.exists() else None
    return {"code": code, "said": said.getvalue()[-600:], "s": time.process_time() - begin, "models": models}


def errors(folder: Path, models: dict) -> list[dict]:
    """Each true mode in a test's band: relative errors of f and zeta, and both in sigmas; zeta if stated."""
    truth = yaml.safe_load((folder / "truth.yaml").read_text())
    length = yaml.safe_load((folder / "rig.yaml").read_text())["beam"]["length_m"]
    frequency = rayleigh_hz(MODES, length, truth["true_thickness"], truth["true_E"], truth["true_rho"])
    rows: list[dict] = []
    for model in models["models"]:
        low, high = model["band_hz"]
        inside = np.flatnonzero((frequency > low) & (frequency < high))
        found = np.array(model["frequency_hz"])
        pairs = matched(frequency[inside], found)
        for mode, near in zip(inside, pairs, strict=True):
            row: dict = {"test": model["test"], "mode": int(mode) + 1, "found": near is not None}
            if near is not None:
                row |= _error("f", found[near], frequency[mode], model["frequency_sigma_hz"][near])
            if near is not None and mode < len(truth["true_zeta"]):
                row |= _error(
                    "zeta", model["damping_ratio"][near], truth["true_zeta"][mode], model["damping_sigma"][near]
                )
            rows.append(row)
        spurious = len(found) - sum(p is not None for p in pairs)
        rows.append({"test": model["test"], "mode": 0, "found": True, "spurious": spurious})
    return rows


def _error(name: str, found: float, true: float, sigma: float) -> dict[str, float]:
    return {name: (found - true) / true, f"{name}_sigmas": (found - true) / sigma}


def table(results: list[dict]) -> None:
    codes = Counter(r["code"] for r in results)
    print(
        f"{len(results)} campaigns, exit codes {dict(codes)}; "
        f"median {np.median([r['s'] for r in results]):.1f} s of processor"
    )
    for r in results:
        if r["code"] != 0:
            print(f"  {r['name']}: {r['code']}: {r['said'].strip().splitlines()[-1]}")
    groups: dict[tuple[str, int], list[dict]] = defaultdict(list)
    for r in results:
        for row in r["errors"] or ():
            groups[row["test"], row["mode"]].append(row)
    print(
        "test    mode  campaigns  found   worst f %  worst zeta %   in 95 %: f   zeta   rms in sigmas: f   zeta"
        "   mean: f   zeta"
    )
    for (test, mode), rows in sorted(groups.items()):
        if mode == 0:
            print(f"{test:7s} spurious modes: {sum(r['spurious'] for r in rows)} in {len(rows)} campaigns")
        else:
            print(f"{test:7s} {mode:4d} {len(rows):9d} {_cells([r for r in rows if r['found']])}")


def _cells(rows: list[dict]) -> str:
    if not rows:
        return "      0"
    shown = [_figures(rows, name) for name in ("f", "zeta")]
    columns = zip(*shown, strict=True)
    widths = ((11, 13), (12, 6), (17, 6), (9, 6))
    cells = [f"{v:>{w}s}" for values, at in zip(columns, widths, strict=True) for v, w in zip(values, at, strict=True)]
    return f"{len(rows):7d} " + " ".join(cells)


def _figures(rows: list[dict], name: str) -> tuple[str, str, str, str]:
    """Worst error in percent, share inside 95 %, rms and mean in sigmas; dashes where no truth is stated."""
    sigmas = np.array([r[f"{name}_sigmas"] for r in rows if name in r])
    if not sigmas.size:
        return ("-", "-", "-", "-")
    worst = 100 * max(abs(r[name]) for r in rows if name in r)
    rms = np.sqrt(np.mean(sigmas**2))
    return f"{worst:.5f}", f"{100 * np.mean(np.abs(sigmas) < 1.96):.1f}", f"{rms:.2f}", f"{sigmas.mean():.2f}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--out", type=Path, required=True, help="file of results, one line a campaign, appended to")
    parser.add_argument("--only-clean", action="store_true", help="only campaigns without effects")
    parser.add_argument("--most", type=int, help="end after so many campaigns that were not run before")
    arguments = parser.parse_args()
    done = [json.loads(line) for line in arguments.out.read_text().splitlines()] if arguments.out.exists() else []
    names = {r["name"] for r in done}
    left = [p.parent for p in sorted(arguments.folder.glob("*/truth.yaml")) if p.parent.name not in names]
    effects = {p: yaml.safe_load((p / "truth.yaml").read_text())["effects"] for p in left}
    for folder in [p for p in left if not (arguments.only_clean and effects[p])][: arguments.most]:
        result = identified(folder)
        clean = not effects[folder] and result["models"] is not None
        result |= {"name": folder.name, "errors": errors(folder, result["models"]) if clean else None}
        with arguments.out.open("a") as target:
            target.write(json.dumps(result) + "\n")
        done.append(result)
    table(done)


if __name__ == "__main__":
    main()
