"""How well what has no name is described: campaigns whose effect the catalogue lacks.

    python benchmarks/gap/unknown.py FOLDER --share develop
    python benchmarks/gap/unknown.py FOLDER --share unseen
    python benchmarks/gap/unknown.py --trials 3 --share unseen [--tolerances usual] [--effect support_resonance]

FOLDER holds campaigns with a truth.yaml each; of those whose effect is none of the catalogue the first of each effect
is the share `develop`, the others are `unseen`. Without a folder trials are made on the simulated bench, of seeds by
share, effect and number. Prints a line a campaign: what it is, what it was said to behave like, the share of the gap
that this closes on records held out, how far the place is off, and the processor seconds of the whole diagnosis and of
the description.
"""

import argparse
import time
from collections.abc import Iterator
from pathlib import Path
from statistics import median
from typing import Any

import yaml
from trials import seed_of

import modallab.gap.diagnosis as diagnosis_module
from modallab.blind.draw import TrialDraw, make_trial
from modallab.blind.trial_bench import trial_bench
from modallab.core.block import Campaign
from modallab.core.effects import catalogue
from modallab.formats.campaign.campaign_hdf5 import read_campaign

SHARES = {"develop": "calibrate", "unseen": "report"}
Case = tuple[str, Campaign, dict[str, Any]]


def of_folder(folder: Path, share: str) -> Iterator[Case]:
    seen: set[str] = set()
    for path in sorted(folder.glob("*/truth.yaml")):
        truth = yaml.safe_load(path.read_text(encoding="utf-8"))
        effects = truth.get("effects") or []
        if len(effects) != 1 or effects[0]["effect"] in catalogue():
            continue
        first = effects[0]["effect"] not in seen
        seen.add(effects[0]["effect"])
        if first == (share == "develop"):
            yield path.parent.name, read_campaign(path.parent), effects[0]


def of_trials(share: str, each: int, tolerances: str, chosen: list[str]) -> Iterator[Case]:
    outside = chosen or [name for name in trial_bench().kinds() if name not in catalogue()]
    for number in range(each):
        for effect in outside:
            seed = seed_of(SHARES[share], effect, number, tolerances)
            made = make_trial(TrialDraw(f"{effect}_{number}", effect, seed, tolerances), later=False)
            yield f"{effect}_{number}", made.campaign, made.truth["effects"][0]  # type: ignore[index]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, nargs="?")
    parser.add_argument("--share", choices=tuple(SHARES), default="develop")
    parser.add_argument("--trials", type=int, default=1, help="trials of each effect, without a folder")
    parser.add_argument("--effect", action="append", default=[], help="of the simulated bench; may occur many times")
    parser.add_argument("--tolerances", choices=("none", "usual"), default="none")
    arguments = parser.parse_args()
    spent = _timed()
    closed: list[float] = []
    off: list[float] = []
    flagged = count = 0
    cases = (
        of_folder(arguments.folder, arguments.share)
        if arguments.folder is not None
        else of_trials(arguments.share, arguments.trials, arguments.tolerances, arguments.effect)
    )
    for name, campaign, truth in cases:
        began = time.process_time()
        found = diagnosis_module.diagnose(campaign)
        whole, count, said = time.process_time() - began, count + 1, found.described
        flagged += found.verdict == "unknown"
        share = said.shrink.closed if said is not None and said.shrink.closed is not None else 0.0
        closed.append(share)
        x, beam = truth["place"].get("x"), campaign.rig.beam
        if isinstance(x, float) and beam is not None:
            off.append(abs(said.x_m / beam.length_m - x) if said is not None and said.x_m is not None else 1.0)
        at = f", place off by {off[-1]:.3f} L" if isinstance(x, float) else ""
        print(
            f"{name}: {truth['effect']} {truth['parameters']} {truth['place']}: {found.verdict}; "
            f"{said.says if said is not None else 'not described'}; "
            f"closes {share:.2%}{at}; gap {found.gap.before:.4g}; "
            f"{whole:.1f} s, {spent[-1] if spent else 0:.1f} s of it to describe",
            flush=True,
        )
    if count:
        print(f"called unknown {flagged} of {count}; closed, median {median(closed):.2%} of {len(closed)}")
    if off:
        print(f"place within 0.1 L: {sum(o < 0.1 for o in off)} of {len(off)}")


def _timed() -> list[float]:
    """Processor seconds of each description, as they come."""
    spent: list[float] = []
    bare = diagnosis_module.describe

    def timed(*arguments: Any) -> Any:
        began = time.process_time()
        found = bare(*arguments)
        spent.append(time.process_time() - began)
        return found

    diagnosis_module.describe = timed  # type: ignore[assignment]
    return spent


if __name__ == "__main__":
    main()
