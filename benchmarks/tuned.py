"""The mass or spring that gives a mode a wanted frequency, looked up in the measured model, then hung on the bench.

    python benchmarks/tuned.py 6 benchmarks/results/tuned.csv

Each bench is as built in an ordinary lab, and has five wanted frequencies. The smallest answer of all points that
states the frequency to 0.2 % is put on it, else the smallest, and it is measured again. Where the model has no
answer, the bench itself is asked for its limits: its own modes with nothing and with a tonne, or a spring of 1 GN/m,
at each point. A row is a wanted frequency.
"""

import json
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np

import modallab as ml
from by_seed import measure
from modallab.bench.loader import open_bench, simulated_bench
from modallab.cli.demo import demo_rig
from modallab.core.plan import ImpactPlan
from modallab.core.rig import Tolerance
from modallab.modification.inverse import By, changes_for_frequency
from modallab.modification.known import KnownStructure
from modallab.service.errors import RunEndedError
from modified import PLAN, POINTS, effect_of

FIRST_SEED, WANTED, MODES = 7251, 5, 5
WITHIN = 2e-3
"""Of a wanted frequency: as near as it is to come."""
STRUCK = (10, 8, 6)
"""As an operator goes on who reads that a sensor is overloaded: at another point."""
WITHOUT_END: dict[By, float] = {"mass": 1e3, "spring": 1e9}
COLUMNS = (
    "seed", "by", "mode", "before_hz", "wanted_hz", "point", "size", "size_sigma", "measured_hz", "measured_sigma_hz",
    "bench_low_hz", "bench_high_hz",
)  # fmt: skip


def drawn(rng: np.random.Generator, before_hz: np.ndarray) -> tuple[By, int, float]:
    """By what, which mode, and the frequency: one in four lies on the side that a mass, or a spring, never reaches."""
    by: By = ("mass", "spring")[int(rng.integers(2))]
    mode, share = int(rng.integers(1, MODES + 1)), float(np.exp(rng.uniform(np.log(0.003), np.log(0.3))))
    down = (by == "mass") == (rng.random() < 0.75)
    return by, mode, float(f"{before_hz[mode - 1] * (1 - share if down else 1 + share):.5g}")


def limits(seed: int, by: By, mode: int) -> tuple[float, float]:
    """Of a mode of the bench itself, over all points and sizes."""
    changes = [(), *((effect_of(by, WITHOUT_END[by], point),) for point in range(1, POINTS + 1))]
    found = [own_hz(seed, effects)[mode - 1] for effects in changes]
    return min(found), max(found)


def own_hz(seed: int, effects: tuple[str, ...]) -> list[float]:
    """The true frequencies of the bench."""
    rig = demo_rig()
    bench = open_bench(simulated_bench(rig, seed, effects, "usual"), rig)
    try:
        return json.loads(bench.truth.facts()["frequency_hz"])  # pyright: ignore[reportAttributeAccessIssue]
    finally:
        bench.close()


def rows_of(seed: int) -> list[list[object]]:
    """The wanted frequencies of one bench."""
    bare = ml.identify(ml.simulate(seed=seed, tolerances="usual", plan=PLAN, progress=False), "impact", progress=False)
    rig = bare.campaign.rig.model_copy(update={"tolerance": Tolerance.usual()})
    known = KnownStructure(bare.modal_model, rig)
    rng = np.random.default_rng(seed)
    return [row(seed, known, *drawn(rng, bare.modal_model.frequency_hz)) for _ in range(WANTED)]


def row(seed: int, known: KnownStructure, by: By, mode: int, to_hz: float) -> list[object]:
    """The answer, and what is measured with it."""
    start = [seed, by, mode, known.model.frequency_hz[mode - 1], to_hz]
    answers = changes_for_frequency(known, mode, to_hz, by, list(range(1, POINTS + 1)))
    best = next((a for a in answers if a.feasible and 1.96 * a.hz_sigma <= WITHIN * to_hz), answers[0])
    if not best.feasible:
        return [*start, "", "", "", "", "", *limits(seed, by, mode)]
    effect = effect_of(by, best.size, int(str(best.at)))
    found = ml.identify(measured(seed, effect), "impact", progress=False).modal_model
    m = int(np.argmin(np.abs(found.frequency_hz - to_hz)))
    return [*start, best.at, best.size, best.sigma, found.frequency_hz[m], found.frequency_sigma_hz[m], "", ""]


def measured(seed: int, effect: str) -> ml.Recording:
    """The bench with it, hit at the first point where no sensor is driven beyond its range."""
    for point in STRUCK:
        plan = ImpactPlan(points=(point,), hits=5)
        with suppress(RunEndedError):
            return ml.simulate(effect=effect, seed=seed, tolerances="usual", plan=plan, progress=False)
    raise SystemExit(f"{seed}: sensors are driven beyond their range at each of the points {STRUCK}")


def summary(rows: list[list[object]]) -> str:
    """The figures of the page."""
    each = [dict(zip(COLUMNS, map(str, r), strict=True)) for r in rows]
    met = [abs(float(r["measured_hz"]) / float(r["wanted_hz"]) - 1) for r in each if r["size"]]
    unanswered = [r for r in each if not r["size"]]
    rightly = [not float(r["bench_low_hz"]) < float(r["wanted_hz"]) < float(r["bench_high_hz"]) for r in unanswered]
    return (
        f"{len(rows)} wanted frequencies: {len(met)} answered, off by {100 * np.median(met):.3f} % in the median, "
        f"{100 * max(met):.3f} % at most, {np.sum(np.array(met) <= WITHIN)} within 0.2 %; {len(unanswered)} said to be "
        f"out of reach, {sum(rightly)} of them of the bench too"
    )


if __name__ == "__main__":
    measure(rows_of, COLUMNS, summary, FIRST_SEED, int(sys.argv[1]), Path(sys.argv[2]))
