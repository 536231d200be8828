"""The response to hits, random records and sines that no fit has seen, predicted from the model of the others.

    python benchmarks/held_out.py 7 benchmarks/results/held_out.csv

Benches as built. The last two of five hits at each point are held out. The shaker is another structure than the bench
alone: its model is that of the first pseudo-random waves; later waves, of other phases, and the sines are held out. A
row is an output of a record. Its error is a share of the record over the lines that were driven. The floor is the error
with which the seen records predict it without a model: by their FRF of the same point. A sample of a hit, or a line of
the others, is inside if it differs by less than the stated 95 % of the model, of how hits scatter and of the noise.

No force was recorded before a block, so that what still moves at its start is nobody's prediction: blocks are recorded
when it has decayed, and those of waves are cut as the generator's own clock would have.
"""

import sys
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import modallab as ml
from by_seed import measure
from modallab.core.block import Block, Campaign
from modallab.core.plan import BLOCK_S, BroadbandPlan, ImpactPlan, SinePlan
from modallab.core.rig import Tolerance
from modallab.frf.periodic_drive import resample_blocks_to_drive_clock
from modallab.modification.known import KnownStructure
from modallab.notebook.recording import Recording
from modallab.signals.signals import Signals, to_signals_of

FIRST_SEED, SEEN_HITS, SEEN_WAVES, PERIODS = 7451, 3, 2, 40
HITS = ImpactPlan(points=(10, 6, 3), hits=5)
RANDOM = BroadbandPlan(
    signal="pseudo-random", band_hz=(3, 400), levels_v={"low": 0.5}, blocks=12, blocks_per_wave=3, settle_s=40
)
SINES = SinePlan(
    frequencies_hz=tuple(n / BLOCK_S for n in (5, 13, 31, 55, 89, 140)), levels_v={"low": 0.2, "high": 0.4}, settle_s=40
)
BAND_HZ = {"impact": (3.0, 650.0), "pseudo-random": RANDOM.band_hz}
UNDRIVEN = 0.7
"""Of half the rate: up to the middle between it and 1 only noise is in a driven record."""
INSIDE = -np.log(0.05)
"""Squared distance, in variances of a complex number, that 95 % of normal ones stay within."""
COLUMNS = ("seed", "kind", "record", "output", "error", "floor", "inside")


@dataclass(frozen=True)
class Case:
    """A model, the records that it has not seen, and with each those that it has seen, with the same point."""

    kind: str
    known: KnownStructure
    held: Sequence[tuple[Signals, Sequence[Signals]]]


def cases(seed: int) -> Iterator[Case]:
    """Hits from the model of hits; random records and sines from that of other random records."""
    whole = ml.simulate("link", seed=seed, tolerances="usual", plan=[HITS, RANDOM, SINES], progress=False).campaign
    groups: dict[str, dict[object, list[Block]]] = defaultdict(lambda: defaultdict(list))
    for b in whole.blocks:
        groups[b.test][b.drive_point if b.test == "impact" else b.name.rsplit("_", 1)[0]].append(b)
    waves = [
        resample_blocks_to_drive_clock(to_signals_of(own, whole.rig), RANDOM.band_hz)
        for own in groups["pseudo-random"].values()
    ]
    hits = [to_signals_of(own, whole.rig) for own in groups["impact"].values()]
    sines = [to_signals_of(own, whole.rig) for own in groups["sine"].values()]
    seen = [s for own in waves[:SEEN_WAVES] for s in own]
    driven = known_of(whole, seen)
    held = [(s, own[:SEEN_HITS]) for own in hits for s in own[SEEN_HITS:]]
    yield Case("impact", known_of(whole, [s for own in hits for s in own[:SEEN_HITS]]), held)
    yield Case("pseudo-random", driven, [(s, seen) for own in waves[SEEN_WAVES:] for s in own])
    yield Case("sine", driven, [(s, seen) for own in sines for s in own])


def known_of(whole: Campaign, seen: Sequence[Signals]) -> KnownStructure:
    """The model of some records. Its sensors are those of the records it is compared with, and so is its stinger."""
    blocks = tuple(s.block for s in seen)
    model = ml.identify(Recording(replace(whole, blocks=blocks)), blocks[0].test, progress=False).modal_model
    known = {"sensitivity": 0.0, "position_m": 0.0}
    if model.hit_shares is None:
        known |= {"hit_position_m": 0.0, "hit_gain": 0.0}
    else:
        # What is predicted is one hit more, beside the mean of those that the model was made with.
        one_more = np.append(model.hit_shares, -np.ones((*model.hit_shares.shape[:2], 1)), axis=2)
        model = model.model_copy(update={"hit_shares": one_more})
    tolerance = Tolerance.usual().model_copy(update=known)
    return KnownStructure(model, whole.rig.model_copy(update={"tolerance": tolerance}))


def rows_of(seed: int) -> list[list[object]]:
    """A row for each output of each record."""
    found = []
    for case in cases(seed):
        for held, repeats in case.held:
            error, floor, inside = compared(case, held, repeats)
            each = zip(case.known.model.output_points, error, floor, inside, strict=True)
            found += [[seed, case.kind, held.block.name, *row] for row in each]
    return found


def compared(case: Case, held: Signals, repeats: Sequence[Signals]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(outputs,) error, floor and share of samples or lines inside."""
    hz = np.fft.rfftfreq(held.force.size, 1 / held.rate_hz)
    low, high = BAND_HZ.get(case.kind, (held.block.frequency_hz or 0.0,) * 2)
    # Blocks are of one length whatever their rate, so that their lines have the same numbers.
    lines = np.flatnonzero((hz > low - 0.5 / BLOCK_S) & (hz < high + 0.5 / BLOCK_S))

    def at(values: np.ndarray) -> np.ndarray:
        return np.fft.rfft(values, axis=-1)[..., lines]

    force, record = at(held.force), at(held.responses)
    pairs = [(at(r.responses), at(r.force)) for r in repeats]
    repeated = force * sum(r * f.conj() for r, f in pairs) / sum(np.abs(f) ** 2 for _, f in pairs)
    off = at(motion(case.known, held)) - record
    size = np.linalg.norm(record, axis=1)
    inside = samples_inside if case.kind == "impact" else lines_inside
    return (
        np.linalg.norm(off, axis=1) / size,
        np.linalg.norm(repeated - record, axis=1) / size,
        inside(case.known, held, lines, off),
    )


def samples_inside(known: KnownStructure, held: Signals, lines: np.ndarray, off: np.ndarray) -> np.ndarray:
    """(outputs,) share of the samples of a hit, whose block ends before its motion does."""
    spectrum = np.zeros((len(off), held.force.size // 2 + 1), complex)
    spectrum[:, lines] = off
    noise = np.var(held.responses[:, : held.hit.first], axis=1)[:, None]
    stated = known.standard_deviation(lambda one: motion(one, held)) ** 2 + noise
    moving = slice(held.hit.first, None)
    inside = np.fft.irfft(spectrum, held.force.size) ** 2 <= 1.96**2 * stated
    return np.mean(inside[:, moving], axis=1)


def lines_inside(known: KnownStructure, held: Signals, lines: np.ndarray, off: np.ndarray) -> np.ndarray:
    """(outputs,) share of the lines of a record of whole periods."""
    hz, spectrum = (
        np.fft.rfftfreq(held.force.size, 1 / held.rate_hz),
        np.fft.rfft([held.force, *held.responses], axis=1),
    )
    frf = known.frf(hz[lines], known.sensors, [held.block.drive_point], "inertance")
    assert frf.variance is not None
    undriven = (hz > UNDRIVEN * hz[-1]) & (hz < (1 + UNDRIVEN) / 2 * hz[-1])
    of_force, *noise = np.mean(np.abs(spectrum[:, undriven]) ** 2, axis=1)
    stated = np.abs(spectrum[0, lines]) ** 2 * frf.variance[:, 0] + of_force * np.abs(frf.values[:, 0]) ** 2
    return np.mean(np.abs(off) ** 2 <= INSIDE * (stated + np.array(noise)[:, None]), axis=1)


def motion(known: KnownStructure, held: Signals) -> np.ndarray:
    """(outputs, samples) of a hit from rest, or of a force that repeats and has done so for long."""
    n, hit = held.force.size, held.block.test == "impact"
    force = held.hit_force[None] if hit else np.tile(held.force, PERIODS)[None]
    return known.response(force, 1 / held.rate_hz, [held.block.drive_point], known.sensors)[:, -n:]


def summary(rows: list[list[object]]) -> str:
    """The figures of the page, a line for each kind."""
    lines = []
    for kind in dict.fromkeys(str(r[1]) for r in rows):
        error, floor, inside = np.array([r[4:] for r in rows if r[1] == kind], float).T
        records = len({(r[0], r[2]) for r in rows if r[1] == kind})
        lines.append(
            f"{kind}: {records} records; error {100 * np.median(error):.2g} % in the median, {100 * error.max():.2g} % "
            f"at most; {np.median(error / floor):.2g} times the floor, {100 * np.mean(error <= 2 * floor):.0f} % "
            f"within twice of it; {100 * np.mean(inside):.0f} % inside the 95 % interval"
        )
    return "\n".join(lines)


if __name__ == "__main__":
    measure(rows_of, COLUMNS, summary, FIRST_SEED, int(sys.argv[1]), Path(sys.argv[2]))
