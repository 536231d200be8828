"""Hits at other points than requested, on rough simulated benches: how many are caught, and how many good ones are not.

    python benchmarks/wrong_point.py --seeds 20

Sensitivities scatter by 1 %, places by 2 mm; 30 % of the hits are at another of the ten points. Each begins from rest.
"""

import argparse
from collections import Counter

import numpy as np

from modallab.acquisition.procedures.struck_point.check import StruckPointCheck
from modallab.acquisition.procedures.struck_point.participation import ExpectedModes, response_of_hit
from modallab.bench.loader import open_bench
from modallab.bench.protocol import AcquisitionRequest
from modallab.cli.demo import demo_rig
from modallab.pipelines.known_modes import expected_modes
from modallab.signals.conversion import Conversion

RATE_HZ, BLOCK, BEFORE, BAND_HZ = 2000.0, 2048, 100, 110.0
WEAKEST_N = 10.0
POINTS = tuple(range(10, 0, -1))
Outcome = tuple[int, int, int, bool, int]
"""Requested, struck, hits before at the point, rejected, the point it was said to be."""


def session(seed: int, hits: int, wrong: float, expected: ExpectedModes | None, effect: str) -> list[Outcome]:
    """All hits of one bench; the operator strikes again until each good hit is there, and never overrides."""
    rig, rng = demo_rig(), np.random.default_rng([seed, 3])
    gains = 1 + 0.01 * rng.standard_normal(10)
    effects = "".join(f"&effect=gain_error,channel={row},gain={gain:.4f}" for row, gain in enumerate(gains, start=1))
    effects += f"&effect={effect}" if effect else ""
    bench = open_bench(f"sim://cantilever?seed={seed}&bad_hits=0&place_m=0.002{effects}", rig)
    delivery = bench.configure(AcquisitionRequest("impact", RATE_HZ))
    conversion = Conversion.of(rig, "impact", delivery.units, delivery.scale, delivery.dtype)
    check = StruckPointCheck.of(rig, conversion, BAND_HZ, expected)
    found: list[Outcome] = []
    for point in POINTS:
        good = 0
        for n in range(3 * hits):
            others = [p for p in POINTS if p != point]
            struck = int(rng.choice(others)) if rng.uniform() < wrong else point
            bench.start()
            bench.read(BLOCK, 1.0)
            bench.prompt_hit(struck)
            samples = bench.read(3 * BLOCK, 1.0).samples
            bench.stop()
            force_n = conversion.force_n(samples)
            first = int(np.argmax(force_n >= 2.0)) - BEFORE
            block = samples[:, first : first + BLOCK]
            answer = response_of_hit(block, conversion, RATE_HZ, BEFORE, check.checked_rows, check.up_to_hz)
            if force_n.max() < WEAKEST_N or answer is None:
                continue
            said = check.check_hit(f"{point}/{n}", point, answer)
            found.append((point, struck, good, bool(said.reasons), said.nearest_point))
            if not said.reasons:
                check.keep_hit(f"{point}/{n}", f"{point}/{n}", point)
                good += 1
            if good == hits:
                break
    return found


def main() -> None:
    """Run the sessions and print what they came to."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--hits", type=int, default=3)
    parser.add_argument("--wrong", type=float, default=0.3)
    parser.add_argument("--effect", default="", help="what else is wrong with the bench, as in its address")
    parser.add_argument("--model", action=argparse.BooleanOptionalAction, default=True)
    arguments = parser.parse_args()
    expected = expected_modes(demo_rig()) if arguments.model else None
    all_hits: list[Outcome] = []
    for seed in range(arguments.seeds):
        all_hits += session(seed, arguments.hits, arguments.wrong, expected, arguments.effect)
    wrong = [hit for hit in all_hits if hit[0] != hit[1]]
    good = [hit for hit in all_hits if hit[0] == hit[1]]
    first = [hit for hit in wrong if hit[2] == 0]
    beside = [hit for hit in wrong if abs(hit[0] - hit[1]) == 1]
    for name, hits in (("wrong", wrong), ("wrong, first at the point", first), ("wrong, next to the point", beside)):
        named = sum(hit[4] == hit[1] for hit in hits if hit[3])
        print(f"{name}: {sum(hit[3] for hit in hits)} of {len(hits)} caught, {named} by the right name")
    print(f"good: {sum(hit[3] for hit in good)} of {len(good)} rejected")
    missed = Counter((hit[0], hit[1]) for hit in wrong if not hit[3])
    print(f"missed (requested, struck): {dict(missed)}")


if __name__ == "__main__":
    main()
