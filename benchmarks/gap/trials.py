"""Blind trials on the simulated bench by fixed seeds: two shares that have none in common.

    python benchmarks/gap/trials.py TRIALS --share report --each 2 --none 10
    python benchmarks/gap/trials.py TRIALS --share report --each 0 --none 0 --pairs 30
    python benchmarks/gap/trials.py TRIALS --share report --each 11 --none 300 --tolerances usual

Each with one effect, two or none, as `modallab gap blind` makes them: drawn and sealed in the folder TRIALS, answered,
opened. There a seed draws all; here a trial follows from its share, its effect and its number, so that more trials of
an effect leave those there are as they were. What is in the folder already is not done again. Prints the figures and
what happened effect by effect, and leaves blind.json and blind.html.
"""

import argparse
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

from modallab.blind.draw import NONE, PAIR, TrialDraw
from modallab.blind.page import render
from modallab.blind.run import blind_draws
from modallab.blind.trial_bench import trial_bench
from modallab.core.effects import catalogue

SHARES = {"calibrate": 1, "report": 2}
_MOST = 10_000


def seed_of(share: str, effect: str, number: int, tolerances: str) -> int:
    """Of everything in a trial; no two trials have the same."""
    names = [NONE, *trial_bench().kinds()]
    block = SHARES[share] + (0 if tolerances == "none" else 20)
    if effect == PAIR:
        return (10 + block) * len(names) * _MOST + number
    return (block * len(names) + names.index(effect)) * _MOST + number


def draws(
    share: str, effects: list[str], each: int, none: int, pairs: int = 0, tolerances: str = "none"
) -> list[TrialDraw]:
    """The trials of a share, the first of every effect before the second."""
    counts = dict.fromkeys(effects, each) | {NONE: none, PAIR: pairs}
    built = "" if tolerances == "none" else f"_{tolerances}"
    return [
        TrialDraw(f"{e}_{share}{built}_{i:03d}", e, seed_of(share, e, i, tolerances), tolerances)
        for i in range(max(counts.values()))
        for e, count in counts.items()
        if i < count
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("trials", type=Path)
    parser.add_argument("--share", choices=tuple(SHARES), default="report")
    parser.add_argument(
        "--effect", choices=tuple(trial_bench().kinds()), action="append", help="may occur many times; default: all"
    )
    parser.add_argument("--each", type=int, default=2, help="trials of each effect")
    parser.add_argument("--none", type=int, default=10, help="trials without effect")
    parser.add_argument("--pairs", type=int, default=0, help="trials of two effects")
    parser.add_argument("--tolerances", choices=("none", "usual"), default="none", help="how well benches are built")
    parser.add_argument("--workers", type=int, default=1)
    arguments = parser.parse_args()
    effects = arguments.effect or list(catalogue())
    counts = arguments.each, arguments.none, arguments.pairs
    listed = draws(arguments.share, effects, *counts, arguments.tolerances)
    plan = {"share": arguments.share, "trials": [draw.name for draw in listed]}
    with ProcessPoolExecutor(arguments.workers, mp_context=get_context("spawn")) as pool:
        found = blind_draws(arguments.trials, listed, plan, later=True, pool=pool)
    (arguments.trials / "blind.json").write_text(found.model_dump_json(indent=1), encoding="utf-8")
    (arguments.trials / "blind.html").write_text(render(found), encoding="utf-8")
    for of in found.effects:
        print(f"{of.effect:32s} {of.right:3d} of {of.trials:3d}  {of.said}")
    for figure in found.figures:
        print(f"{figure.name:45s} {figure.value}  of {figure.count:3d}  {' '.join(figure.misses)}")
    print(f"calibration error {found.calibration_error:.4f}")


if __name__ == "__main__":
    main()
