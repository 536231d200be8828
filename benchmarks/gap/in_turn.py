"""Blind trials on the simulated bench one after another, as many as there is time for: each sealed, answered, opened.

    python benchmarks/gap/in_turn.py TRIALS --trials 200 --none 200 --seed 90117 --minutes 60 --processes 2
    python benchmarks/gap/in_turn.py TRIALS --trials 200 --none 200 --seed 90117 --minutes 0

`modallab gap blind` seals all trials before it answers the first. Here a run may end after any trial: they come in the
order in which that command draws them, those with an effect and those without mixed, so that the first of many are a
fair sample. What is in the folder already is not done again. With no minutes it only sums up. The intervals of places
and parameters that hold the truth are counted as well.
"""

import argparse
import json
import time
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from itertools import islice
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from modallab.blind.draw import TrialDraw, draw_trials, make_trial
from modallab.blind.outcome import named_cause, summarise_trials, true_name
from modallab.blind.request import BlindRequest
from modallab.blind.score import Trial
from modallab.blind.seal import SEALED, hash_of, seal_truth, sealed_hash
from modallab.blind.trial_answers import ANSWERS, read_answers
from modallab.blind.trial_answers import answer_trial as diagnosed
from modallab.core.diagnosis import FoundEffect
from modallab.formats.campaign.campaign_hdf5 import write_campaign

WHOLE = {"swap", "polarity"}
"""Effects without a number, and those of which a number is none to be found."""


def answer(folder: Path, draw: TrialDraw) -> dict[str, Any]:
    """Make, seal and answer one trial, as far as that has not been done; gives the answer."""
    campaign = folder / "campaigns" / f"{draw.name}.h5"
    if sealed_hash(folder, draw.name) is None:
        made = make_trial(draw, later=False)
        campaign.parent.mkdir(parents=True, exist_ok=True)
        write_campaign(made.campaign, campaign)
        seal_truth(folder, draw.name, made.truth)
    return {"name": draw.name} | diagnosed(campaign)


def answer_in_turn(folder: Path, draws: list[TrialDraw], end: float, processes: int) -> None:
    """Answer those that are not answered, in their order, and begin none after `end`."""
    there = {a.name for a in read_answers(folder / ANSWERS)}
    left = iter([draw for draw in draws if draw.name not in there])
    with (
        ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool,
        (folder / ANSWERS).open("a", encoding="utf-8", newline="\n") as target,
    ):
        running = {pool.submit(answer, folder, draw) for draw in islice(left, processes) if time.monotonic() < end}
        while running:
            done, running = wait(running, return_when=FIRST_COMPLETED)
            for future in done:
                target.write(json.dumps(future.result()) + "\n")
                target.flush()
                following = next(left, None) if time.monotonic() < end else None
                running |= set() if following is None else {pool.submit(answer, folder, following)}


def answered(folder: Path, draws: list[TrialDraw]) -> list[Trial]:
    """The trials that have been answered, beside their truths."""
    names = {draw.name for draw in draws}
    found: list[Trial] = []
    for a in read_answers(folder / ANSWERS):
        if a.name in names:
            truth = json.loads((folder / SEALED / f"{a.name}.json").read_text(encoding="utf-8"))["truth"]
            found.append(Trial(a.name, truth["effects"], a.diagnosis, a.length_m, a.seconds))
    return found


def measured_again(folder: Path, draws: list[TrialDraw], trials: list[Trial]) -> None:
    """The later campaign of each effect named right, where it is missing, for `applied.py`."""
    right = {t.name for t in trials if t.right and t.truth}
    for draw in draws:
        later = folder / SEALED / f"{draw.name}_later.h5"
        if draw.name in right and not later.exists():
            made = make_trial(draw)
            assert made.later is not None
            write_campaign(made.later, later)


def held(trial: Trial) -> list[tuple[str, bool]]:
    """Whether the interval of each number of the effects named right holds the truth, places among them."""
    listed: list[tuple[str, bool]] = []
    for true in trial.truth:
        found = next((f for f in trial.diagnosis.effects if f.effect == true["effect"]), None)
        if found is not None and found.effect not in WHOLE:
            numbers = dict(true["parameters"]) | {"x": true["place"].get("x")}
            inside = ((f"{found.effect} {name}", _inside(found, name, numbers)) for name in numbers)
            listed += [(name, ok) for name, ok in inside if ok is not None]
    return listed


def _inside(found: FoundEffect, name: str, numbers: dict[str, Any]) -> bool | None:
    interval = found.interval.get(name)
    if interval is None or not isinstance(numbers[name], int | float):
        return None
    return interval[0] <= numbers[name] <= interval[1]


def row(trial: Trial) -> str:
    """One trial in words."""
    gaps = f"{trial.diagnosis.gap.before:8.1f} {trial.diagnosis.gap.after:7.2f}"
    mark = "right" if trial.right else "WRONG"
    return f"{trial.name} {mark} {true_name(trial):24s} {named_cause(trial):36s} {gaps} {trial.seconds:6.1f} s"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--trials", type=int, default=200, help="with one effect")
    parser.add_argument("--none", type=int, default=200, help="without effect")
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--first", type=int, default=0, help="as many are left out, which another folder has")
    parser.add_argument("--minutes", type=float, default=60.0, help="no trial is begun after these")
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--later", action="store_true", help="measure the benches of right answers once more")
    parser.add_argument("--tolerances", choices=("none", "usual"), default="usual", help="how well benches are built")
    arguments = parser.parse_args()
    sizes = {"trials": arguments.trials, "none": arguments.none, "seed": arguments.seed}
    draws = draw_trials(BlindRequest(**sizes, tolerances=arguments.tolerances, later=False))[arguments.first :]
    arguments.folder.mkdir(parents=True, exist_ok=True)
    end = time.monotonic() + 60 * arguments.minutes
    answer_in_turn(arguments.folder, draws, end, arguments.processes)
    trials = answered(arguments.folder, draws)
    if arguments.later:
        measured_again(arguments.folder, draws, trials)
    print("\n".join(row(t) for t in trials))
    found = summarise_trials(trials, None, hash_of((arguments.folder / ANSWERS).read_text(encoding="utf-8")))
    for figure in found.figures:
        print(f"{figure.name:45s} {figure.value}  of {figure.count:3d}  {' '.join(figure.misses)}")
    print(f"calibration error {found.calibration_error:.4f}")
    intervals = [(t.name, *pair) for t in trials for pair in held(t)]
    misses = [f"{name} {number}" for name, number, ok in intervals if not ok]
    print(f"95 % intervals that hold the truth {len(intervals) - len(misses)} of {len(intervals)}: {', '.join(misses)}")
    if trials:
        print(f"processor seconds, worst {max(t.seconds for t in trials):.1f}")


if __name__ == "__main__":
    main()
