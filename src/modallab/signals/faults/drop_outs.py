"""Drop-outs: a channel that stands still for a while, at zero or at its last value, while it should move."""

import numpy as np

from modallab.core.arrays import Real
from modallab.signals.faults.repeats import Fault, SampleRuns, equal_runs

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


def drop_outs(row: Real, rate_hz: float, channel: str, steps: Real, *, force: bool) -> tuple[Fault, ...]:
    """The stretches of a channel (n,) in which it stands still between two in which it moves.

    Args:
        row: samples.
        rate_hz: sampling rate.
        channel: its name.
        steps: (n,) as of `steps_of`.
        force: whether it is the force, which rests between hits and between bursts.
    """
    runs = _begin_with_jump(row, equal_runs(row).longer(LEAST_RUN), steps)
    kept = [
        k for k in range(runs.first.size) if _is_lost(row, int(runs.first[k]), int(runs.stop[k]), steps, force=force)
    ]
    if not kept:
        return ()
    lost = SampleRuns(runs.first[kept], runs.stop[kept])
    value = float(row[lost.first[0]])
    what = f"stands still at {value:.6g} while it should move"
    return (Fault(channel, what, float(lost.first[0]) / rate_hz, int(lost.length.sum())),)


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
