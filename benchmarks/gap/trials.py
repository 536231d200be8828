"""Makes trials on the simulated bench, each with one effect or none, and diagnoses them.

    python benchmarks/gap/trials.py TRIALS --share report --each 2 --none 10 --out trials.jsonl
    python benchmarks/gap/trials.py TRIALS --share report --each 0 --none 0 --pairs 30 --out pairs.jsonl
    python benchmarks/gap/trials.py TRIALS --share report --each 8 --none 200 --tolerances usual --out rough.jsonl
    python benchmarks/gap/practice.py TRIALS --score trials.jsonl

Effects are drawn with gaps log-uniform from 1.5 to 300 noise units: the gap that is left once the beam is fitted within
the rig file's tolerances, as a diagnosis states it, where 1 is the floor. What those tolerances take over opens none.
Of two effects at once each is drawn so that alone it would open a gap from 100 to 3000.
Each trial has a folder in TRIALS with what the operator believes (rig.yaml) and the truth (truth.yaml), so that it is
scored as a practice campaign is. A trial follows from its name: the two shares have no seed in common, and more trials
of an effect leave those there are as they were. What is in the file already is skipped. With --tolerances usual a
little of everything is wrong with each bench, its rig file says how much, and effects are drawn far beyond: gaps from
30 to 3000. To spread trials over processes, give each a --part and a file of its own.
"""

import argparse
import json
import time
from collections.abc import Iterator
from dataclasses import dataclass
from math import exp, log, sqrt
from pathlib import Path

import numpy as np
import yaml
from rigs import drawn_rig, mounted

from modallab.core.block import Campaign
from modallab.core.effects import Effect, catalogue
from modallab.core.rig import Rig, Tolerance
from modallab.formats.rig.rig_file import dump_rig
from modallab.gap.diagnosis import diagnose
from modallab.gap.report.initial_gap import gap_before
from modallab.twin.effects import models
from modallab_simulators.cantilever.draw_effect import draw_effect, draw_gap
from modallab_simulators.cantilever.effects import kinds
from modallab_simulators.cantilever.trial import make_trial

SHARES = {"calibrate": 1, "report": 2}
NONE = "none"
PAIR = "pair"
PAIR_GAP = (100.0, 3000.0)
ROUGH_GAP = (30.0, 3000.0)
TRIES = 3
EXCEEDING = 6.0
"""Deviations of its own tolerance from which an effect on a bench as built is drawn."""
CLOSE = 0.2
"""Logarithm of the factor by which the gap of a trial may differ from the one that was drawn."""
FURTHER = 2.5
"""The same by which a size changes at most from one try to the next."""
_MOST = 10_000


@dataclass(frozen=True, slots=True)
class Draw:
    """One trial to be made: which share, which effect, the how manieth."""

    share: str
    effect: str
    number: int
    tolerances: str = "none"

    @property
    def name(self) -> str:
        """Of the trial's folder."""
        built = "" if self.tolerances == "none" else f"_{self.tolerances}"
        return f"{self.effect}_{self.share}{built}_{self.number:03d}"

    @property
    def seed(self) -> int:
        """Of everything in the trial; no two trials have the same."""
        names = [NONE, *kinds()]
        share = SHARES[self.share] + (0 if self.tolerances == "none" else 20)
        if self.effect == PAIR:
            return (10 + share) * len(names) * _MOST + self.number
        return (share * len(names) + names.index(self.effect)) * _MOST + self.number


def draws(share: str, effects: list[str], each: int, none: int, pairs: int = 0, tolerances: str = "none") -> list[Draw]:
    """The trials of a share, the first of every effect before the second."""
    counts = dict.fromkeys(effects, each) | {NONE: none, PAIR: pairs}
    most = range(max(counts.values()))
    return [Draw(share, e, i, tolerances) for i in most for e, count in counts.items() if i < count]


def made(draw: Draw) -> tuple[Campaign, dict[str, object]]:
    """The campaign of a trial and its truth, with the gap its effect opens in noise units."""
    rig = drawn_rig(draw.seed)
    if draw.tolerances != "none":
        return rough(draw, mounted(rig.model_copy(update={"tolerance": Tolerance.usual()}), draw.seed))
    if draw.effect == NONE:
        return make_trial(rig, draw.seed)
    if draw.effect == PAIR:
        return make_trial(rig, draw.seed, pair(rig, draw.seed))
    requested = aim = draw_gap(draw.seed)
    met: list[tuple[float, float, Campaign, dict[str, object]]] = []
    for _ in range(TRIES):
        drawn = draw_effect(rig, draw.seed, draw.effect, aim)
        campaign, truth = make_trial(rig, draw.seed, (drawn.effect,))
        gap = gap_before(campaign)
        short = log(sqrt((requested**2 - 1) / max(gap**2 - 1, 0.01)))
        met.append((abs(short), gap, campaign, truth))
        # Some effects have no size, or none that is large or small enough.
        if abs(short) < CLOSE or abs(log(drawn.gap / aim)) > CLOSE:
            break
        aim *= exp(min(max(short, -FURTHER), FURTHER))
    _, gap, campaign, truth = min(met, key=lambda m: m[0])
    return campaign, truth | {"gap_requested": requested, "gap": gap}


def rough(draw: Draw, rig: Rig) -> tuple[Campaign, dict[str, object]]:
    """The same on a bench as people build it; the effect is drawn by the gap it would open on an ideal one."""
    if draw.effect == NONE:
        return make_trial(rig, draw.seed, (), draw.tolerances)
    if draw.effect == PAIR:
        return make_trial(rig, draw.seed, pair(rig, draw.seed), draw.tolerances)
    low, high = np.log(ROUGH_GAP)
    gap = float(np.exp(np.random.default_rng([draw.seed, 79]).uniform(low, high)))
    drawn = draw_effect(rig, draw.seed, draw.effect, gap)
    for _ in range(TRIES):
        if _exceeds(drawn.effect, rig):
            break
        gap *= FURTHER
        drawn = draw_effect(rig, draw.seed, draw.effect, gap)
    campaign, truth = make_trial(rig, draw.seed, (drawn.effect,), draw.tolerances)
    return campaign, truth | {"gap": drawn.gap}


def _exceeds(effect: Effect, rig: Rig) -> bool:
    """Whether it is far beyond its own tolerance: what lies within is no gap, and rightly called none."""
    search = models()[effect.effect].search if effect.effect in models() else None
    return search is None or search.deviations(effect, rig) > EXCEEDING


def pair(rig: Rig, seed: int) -> tuple[Effect, Effect]:
    """Two effects of the catalogue, each of a size of its own."""
    rng = np.random.default_rng([seed, 78])
    first, second = rng.choice(sorted(catalogue()), 2, replace=False)
    low, high = PAIR_GAP
    sizes = np.exp(rng.uniform(np.log(low), np.log(high), 2))
    drawn = [
        draw_effect(rig, seed, str(name), float(size)).effect for name, size in zip((first, second), sizes, strict=True)
    ]
    return drawn[0], drawn[1]


def left(listed: list[Draw], out: Path) -> Iterator[Draw]:
    """Those that are not in the file."""
    done = {json.loads(line)["name"] for line in out.read_text().splitlines()} if out.exists() else set()
    return (draw for draw in listed if draw.name not in done)


def run(trials: Path, draw: Draw, out: Path) -> None:
    """Make a trial, write down what is believed and what is true, diagnose it, and add a line to the file."""
    campaign, truth = made(draw)
    folder = trials / draw.name
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "rig.yaml").write_text(dump_rig(campaign.rig))
    (folder / "truth.yaml").write_text(yaml.safe_dump(truth, sort_keys=False))
    begun = time.process_time()
    diagnosis = diagnose(campaign)
    entry = {"name": draw.name, "seconds": time.process_time() - begun, "diagnosis": diagnosis.model_dump(mode="json")}
    with out.open("a") as target:
        target.write(json.dumps(entry) + "\n")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("trials", type=Path)
    parser.add_argument("--share", choices=tuple(SHARES), default="report")
    parser.add_argument(
        "--effect", choices=tuple(kinds()), action="append", help="may occur many times; default: all named"
    )
    parser.add_argument("--each", type=int, default=2, help="trials of each effect")
    parser.add_argument("--none", type=int, default=10, help="trials without effect")
    parser.add_argument("--pairs", type=int, default=0, help="trials of two effects")
    parser.add_argument("--tolerances", choices=("none", "usual"), default="none", help="how well benches are built")
    parser.add_argument("--part", type=int, nargs=2, default=(0, 1), metavar=("I", "OF"))
    parser.add_argument("--minutes", type=float, default=float("inf"), help="begin no trial after so many")
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    first, of = arguments.part
    effects = arguments.effect or list(catalogue())
    counts = arguments.each, arguments.none, arguments.pairs
    listed = draws(arguments.share, effects, *counts, arguments.tolerances)[first::of]
    begun = time.monotonic()
    for draw in left(listed, arguments.out):
        if time.monotonic() - begun > 60 * arguments.minutes:
            break
        run(arguments.trials, draw, arguments.out)


if __name__ == "__main__":
    main()
