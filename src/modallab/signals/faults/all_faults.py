"""All faults that the samples of a block show."""

import numpy as np

from modallab.core.arrays import Real
from modallab.core.block import Block
from modallab.core.errors import DataError
from modallab.core.rig import Rig
from modallab.core.units import Quantity
from modallab.signals.faults.flat_tops import flat_tops
from modallab.signals.faults.repeats import (
    SampleFault,
    SampleRuns,
    equal_runs,
    repeated_in_all_channels,
    repeated_values,
    smallest_steps,
)
from modallab.signals.faults.whole_channels import constant_channels, is_dead_channel, is_zero_drift, overload_counts
from modallab.signals.hit import find_hit

ALONE = 50.0
"""How many times further than anything near it a sample stands off the middle of its neighbours."""
TOGETHER = 10.0
"""The same, from which on another channel moves as well: what is felt elsewhere is no fault."""
NEAR, OWN = 16, 1
"""Samples to either side that show how the channel moves, and those that one wrong sample bends itself."""
FELT = 2
"""Samples before, and twice as many behind, within which another channel feels what is no fault."""


def find_spikes(rows: Real, rate_hz: float, channels: tuple[str, ...], steps: Real) -> tuple[SampleFault, ...]:
    """Samples of (channels, n) rows that stand alone in time, and in which no other channel moves.

    Of a single channel nothing is known of others, and nothing is said. `steps` is (channels, n), as of `steps_of`.
    """
    if len(rows) < 2 or rows.shape[1] < 4 * NEAR:
        return ()
    off = np.zeros_like(rows)
    off[:, 1:-1] = np.abs(rows[:, 1:-1] - (rows[:, :-2] + rows[:, 2:]) / 2)
    least = np.maximum(steps, 1e-12 * np.abs(rows).max(axis=1, keepdims=True))
    found: list[SampleFault] = []
    for k, channel in enumerate(channels):
        alone = [i for i in _candidate_samples(off[k], least[k]) if _deviation_ratio(off[k], least[k], i) > ALONE]
        places = [i for i in alone if not _felt_elsewhere(np.delete(off, k, 0), np.delete(least, k, 0), i)]
        if places:
            what = f"a value of {rows[k, places[0]]:.6g} that neighbouring samples do not explain"
            found.append(SampleFault(channel, what, places[0] / rate_hz, len(places)))
    return tuple(found)


def _candidate_samples(off: Real, least: Real) -> list[int]:
    """Samples that stand further off than their neighbours, and than those a little before and after."""
    beside = np.maximum(np.roll(off, OWN + 1), np.roll(off, -OWN - 1))
    highest = off >= np.maximum(np.roll(off, 1), np.roll(off, -1))
    return [int(i) for i in np.flatnonzero(highest & (off > ALONE * np.maximum(beside, least)))]


def _deviation_ratio(off: Real, least: Real, place: int) -> float:
    """How far a sample stands off the middle of its neighbours, over the furthest near it but not beside it."""
    around = np.concatenate([off[max(0, place - NEAR) : max(0, place - OWN)], off[place + OWN + 1 : place + NEAR + 1]])
    return float(off[place] / max(float(around.max(initial=0.0)), float(least[place]), 1e-300))


def _felt_elsewhere(off: Real, least: Real, place: int) -> bool:
    span = range(max(0, place - FELT), min(off.shape[1], place + 2 * FELT + 1))
    return any(_deviation_ratio(row, low, i) > TOGETHER for row, low in zip(off, least, strict=True) for i in span)


LEAST_RUN = 3
BESIDE = 16
"""Samples to either side that show whether the channel moves."""
MOVES = 16.0
"""Steps of the converter from sample to sample there."""
SHARP = 6.0
"""Steps by which it leaves the value, times (1 + 2 / L)^2, which a smooth top of L equal samples has at most."""
RARE = 1e-4
"""Chance of such a stretch in the whole record where noise alone makes samples equal."""
REST = 0.05
"""Share of a record for which a force stands at one value between hits or bursts."""


def drop_outs(row: Real, rate_hz: float, channel: str, steps: Real, *, force: bool) -> tuple[SampleFault, ...]:
    """The stretches of a channel (n,) in which it stands still between two in which it moves.

    Args:
        row: samples.
        rate_hz: sampling rate.
        channel: its name.
        steps: (n,) as of `steps_of`.
        force: whether it is the force, which rests between hits and between bursts.
    """
    runs = _begin_with_jump(row, equal_runs(row).at_least(LEAST_RUN), steps)
    kept = [
        k for k in range(runs.first.size) if _is_lost(row, int(runs.first[k]), int(runs.stop[k]), steps, force=force)
    ]
    if not kept:
        return ()
    lost = SampleRuns(runs.first[kept], runs.stop[kept])
    value = float(row[lost.first[0]])
    what = f"stands still at {value:.6g} while it should move"
    return (SampleFault(channel, what, float(lost.first[0]) / rate_hz, int(lost.length.sum())),)


def _begin_with_jump(row: Real, runs: SampleRuns, steps: Real) -> SampleRuns:
    """Runs whose value is reached or left faster than that of a smooth top of as many equal samples."""
    jumps = np.abs(np.diff(row, prepend=row[0], append=row[-1]))
    edges, step = np.maximum(jumps[runs.first], jumps[runs.stop]), steps[runs.first]
    kept = (edges >= SHARP * step * (1 + 2 / runs.length) ** 2) & (edges > 0) & (runs.first >= BESIDE)
    return SampleRuns(runs.first[kept], runs.stop[kept])


def _is_lost(row: Real, first: int, stop: int, steps: Real, *, force: bool) -> bool:
    step = float(steps[max(0, first - BESIDE) : stop + BESIDE].max())
    before, after = _movement_of_part(row[first - BESIDE : first]), _movement_of_part(row[stop : stop + BESIDE])
    if min(before, before if stop >= row.size else after) < MOVES * step:
        return False
    chance = (stop - first - 1) * np.log(max(step, 1e-300) / (2 * before)) + np.log(row.size)
    return bool(chance < np.log(RARE)) and not (force and np.mean(row == row[first]) > REST)


def _movement_of_part(part: Real) -> float:
    return float(np.median(np.abs(np.diff(part)))) if part.size > 2 else 0.0


LEAST_SAMPLES = 64
"""Fewer show too little of how a channel moves."""


def find_faults(block: Block, rig: Rig) -> tuple[SampleFault, ...]:
    """Faults of the chain in a block: overloads, dead channels, flat tops, held values, drop-outs, drift, lone values.

    Each needs what no sound channel does, whatever its noise and resolution; limits are given with each kind.

    Args:
        block: finite samples (channels, n).
        rig: which channels are forces.
    """
    if over := overload_counts(block, rig):
        return over
    rows = block.samples.astype(np.float64)
    found = list(constant_channels(rows, block.channels, [c.name for c in rig.forces[: len(block.driven_points)]]))
    if block.n_samples < LEAST_SAMPLES:
        return tuple(found)
    steps = np.stack([smallest_steps(row) for row in rows])
    quantities = {channel.name: channel.quantity for channel in rig.channels}
    for row, name, step in zip(rows, block.channels, steps, strict=True):
        noise = _noise_of_hit(row) if block.test == "impact" and quantities.get(name) == "force" else None
        found += _faults_of_row(row, name, step, block.rate_hz, quantities.get(name), noise)
    return (
        *found,
        *repeated_in_all_channels(rows, block.rate_hz, block.channels, steps),
        *find_spikes(rows, block.rate_hz, block.channels, steps),
    )


def _noise_of_hit(row: Real) -> float | None:
    try:
        return find_hit(row).noise
    except DataError:
        return None


def _faults_of_row(
    row: Real, name: str, steps: Real, rate_hz: float, quantity: Quantity | None, noise: float | None
) -> tuple[SampleFault, ...]:
    if found := is_dead_channel(row, name, steps):
        return found
    tops = flat_tops(row, rate_hz, name, steps, noise)
    held = repeated_values(row, rate_hz, name, steps)
    # What is held everywhere has no drop-outs of its own; neither has a channel at the end of its range.
    lost = () if tops or held else drop_outs(row, rate_hz, name, steps, force=quantity == "force")
    # Only accelerations keep their mean: a structure may end where it was not, and a force may be let go.
    return (*tops, *held, *lost, *(is_zero_drift(row, rate_hz, name) if quantity == "acceleration" else ()))
