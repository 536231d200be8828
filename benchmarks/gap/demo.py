"""How often the diagnosis of the demonstration is right: its bench as built, without effect and with one, seed by seed.

python benchmarks/gap/demo.py --seeds 10 --effect added_mass,mass=0.05,x=0.8
"""

import argparse
import tempfile
import time
from pathlib import Path

from modallab.bench.loader import simulated_bench
from modallab.cli.demo import demo_plans, demo_rig
from modallab.core.diagnosis import Diagnosis
from modallab.core.effect import AlongBeam
from modallab.core.errors import ModallabError
from modallab.core.rig import Tolerance
from modallab.gap.diagnosis import diagnose
from modallab.gap.words.verdicts import verdict_sentence
from modallab.service.campaigns.local_session import record_campaign

NEAR = 0.05
"""Share of the length within which a place counts as found."""


def run(seed: int, effects: list[str]) -> tuple[Diagnosis, float]:
    """Record the demonstration's tests on the bench of a seed, and diagnose; with the processor's seconds of that."""
    rig = demo_rig().model_copy(update={"tolerance": Tolerance.usual()})
    url = simulated_bench(rig, seed, effects, "usual")
    with tempfile.TemporaryDirectory() as folder:
        campaign = record_campaign(url, rig, demo_plans(), Path(folder), lambda _: None)
    began = time.process_time()
    return diagnose(campaign), time.process_time() - began


def right(diagnosis: Diagnosis, effects: list[str]) -> bool:
    """Whether the verdict, the names and the place are those of what was put in."""
    if not effects:
        return diagnosis.verdict == "no_gap"
    names = sorted(effect.partition(",")[0] for effect in effects)
    places = [float(word[2:]) for effect in effects for word in effect.split(",") if word.startswith("x=")]
    found = [f.place.x for f in diagnosis.effects if isinstance(f.place, AlongBeam)]
    near = all(any(abs(x - place) < NEAR for x in found) for place in places)
    return sorted(f.effect for f in diagnosis.effects) == names and near


def main() -> None:
    """Print a line a seed and case, and how many were right."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--effect", action="append", default=[])
    arguments = parser.parse_args()
    for effects in ([], arguments.effect) if arguments.effect else ([],):
        good = 0
        for seed in range(1, arguments.seeds + 1):
            try:
                diagnosis, took = run(seed, effects)
            except ModallabError as error:
                print(f"{seed} ENDED: {error.what}", flush=True)
                continue
            good += right(diagnosis, effects)
            mark = "right" if right(diagnosis, effects) else "WRONG"
            print(f"{seed} {mark} {took:.0f} s: {verdict_sentence(diagnosis)}", flush=True)
        print(f"{good} of {arguments.seeds} right: {' '.join(effects) or 'no effect'}", flush=True)


if __name__ == "__main__":
    main()
