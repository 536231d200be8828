"""The gap in noise units, split by everything it can be split by.

The gap is the square root of chi-square per number (Bevington and Robinson, Data Reduction and Error Analysis, 2003):
the rms of the residuals over their standard deviations, real and imaginary part one number each.
"""

import itertools
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Complex, Real
from modallab.core.budget import Division
from modallab.core.diagnosis import Shrinkage
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.model.fit import all_rows, row_frequencies_hz
from modallab.gap.model.forward import forward
from modallab.twin.bench import Twin

BANDS_HZ = (0.0, 10.0, 20.0, 50.0, 120.0, 200.0, 400.0, 1000.0)


@dataclass(frozen=True, eq=False, slots=True)
class SquaredResiduals:
    """Squared residuals in noise units with what they belong to; one entry a channel and a piece of a record.

    Attributes:
        total: (entries,) sums of squares.
        count: (entries,) how many real numbers each sums.
        records: name of the piece.
        tests: its test.
        levels: its level, "" for hits.
        channels: row of the accelerometer.
        order: (entries,) place in time, 0 to 1.
    """

    total: Real
    count: Real
    records: tuple[str, ...]
    tests: tuple[str, ...]
    levels: tuple[str, ...]
    channels: tuple[int, ...]
    order: Real

    @property
    def gap(self) -> float:
        """Rms in noise units."""
        return float(np.sqrt(np.sum(self.total) / max(float(np.sum(self.count)), 1.0)))

    def by(self, keys: Iterable[Any]) -> dict[str, float]:
        """Rms of each group of entries."""
        labels = [str(k) for k in keys]
        groups = list(dict.fromkeys(k for k in labels if k))
        found: dict[str, float] = {}
        for group in groups:
            at = np.array([k == group for k in labels])
            found[group] = float(np.sqrt(np.sum(self.total[at]) / max(float(np.sum(self.count[at])), 1.0)))
        return found


def residuals_of_twin(twin: Twin, data: Reduced) -> list[Complex]:
    """(channels, rows) of each part of the data, in noise units."""
    return residuals_of_predictions(forward(twin, data), data)


def residuals_of_predictions(answers: Sequence[Complex], data: Reduced) -> list[Complex]:
    """The same of any answers, in the order of `forward`."""
    return [rows.in_noise_units(rows.y - y) for rows, y in zip(all_rows(data), answers, strict=True)]


def squared_residuals(twin: Twin, data: Reduced) -> SquaredResiduals:
    """The residuals of a twin as squares."""
    return squares_of(forward(twin, data), data)


def squares_of(answers: Sequence[Complex], data: Reduced) -> SquaredResiduals:
    """The residuals of any answers as squares."""
    rows = [
        (float(np.sum(np.abs(r[used]) ** 2)), 2.0 * np.count_nonzero(used), name, test, level, channel, at)
        for r, used, (name, test, level, at), channel in _residuals_in_records(
            residuals_of_predictions(answers, data), data
        )
    ]
    total, count, records, tests, levels, channels, order = zip(*rows, strict=True) if rows else ((),) * 7
    at = np.array(order) / data.last_order
    return SquaredResiduals(np.array(total), np.array(count), records, tests, levels, channels, at)


def _residuals_in_records(
    parts: Sequence[Complex], data: Reduced
) -> Iterator[tuple[Complex, NDArray[np.bool_], tuple[str, str, str, float], int]]:
    """Residuals of a channel in a record, which of them are used, the record's name, test, level and order."""
    for d, r in zip(data.impacts, parts, strict=False):
        piece = d.piece
        for i, channel in enumerate(data.channels):
            yield r[i], np.isfinite(d.rows.sigma[i]), (piece.name, piece.test, piece.level or "", piece.order), channel
    if data.sines is not None:
        shape = (len(data.channels), *data.sines.source.lines.shape)
        r, used = parts[-1].reshape(shape), np.isfinite(data.sines.rows.sigma).reshape(shape)
        for j, piece in enumerate(data.sines.pieces):
            for i, channel in enumerate(data.channels):
                yield r[i, j], used[i, j], (piece.name, "sine", piece.level or "", piece.order), channel


def share_of_squares_within(
    twin: Twin, data: Reduced, tests: Sequence[str], rows: Sequence[int], bands: Sequence[tuple[float, float]]
) -> float:
    """Share of the squares above the floor that lie in these tests, rows (none: all) and bands, 0 to 1."""
    inside = whole = 0.0
    chosen = np.array([not rows or c in rows for c in data.channels])
    for (test, hz, used), r in zip(_kinds_of_parts(data), residuals_of_twin(twin, data), strict=True):
        excess = np.where(used, np.abs(r) ** 2 - 2, 0.0)
        lines = np.any([(hz >= low) & (hz < high) for low, high in bands], axis=0)
        whole += float(np.sum(excess))
        inside += float(np.sum(excess[np.ix_(chosen, lines)])) if test in tests else 0.0
    return float(np.clip(inside / whole, 0.0, 1.0)) if whole > 0 else 0.0


def labels_of_entries(data: Reduced, resonances_hz: Sequence[float]) -> tuple[list[tuple[Division, str]], Real]:
    """What the entries of a residual belong to, real parts first, then imaginary ones.

    Args:
        data: what the residual is of.
        resonances_hz: of the modes.

    Returns:
        test, channel, band or mode, and its name, of each column; (entries, columns) 1 where an entry belongs to it.
    """
    names = np.array([data.rig.channels[c].name for c in data.channels])
    mode_of = nearest_mode(resonances_hz)
    labels: dict[Division, list[NDArray[np.str_]]] = {"test": [], "channel": [], "band": [], "mode": []}
    for test, hz, _ in _kinds_of_parts(data):
        rows, channels = len(hz), len(names)
        labels["test"].append(np.full(channels * rows, test))
        labels["channel"].append(np.repeat(names, rows))
        labels["band"].append(np.tile([name_of_band(float(f)) for f in hz], channels))
        labels["mode"].append(np.tile([mode_of(float(f)) for f in hz], channels))
    whole: dict[Division, NDArray[np.str_]] = {kind: np.concatenate(parts) for kind, parts in labels.items() if parts}
    columns: list[tuple[Division, str]] = [
        (kind, name) for kind, values in whole.items() for name in dict.fromkeys(map(str, values))
    ]
    belongs = np.array([whole[kind] == name for kind, name in columns], dtype=np.float64).T
    return columns, np.concatenate([belongs, belongs])


def _kinds_of_parts(data: Reduced) -> list[tuple[str, Real, NDArray[np.bool_]]]:
    """Test, (rows,) Hz and (channels, rows) use of each part of the data."""
    tests = [d.piece.test for d in data.impacts] + ["sine"] * (data.sines is not None)
    used = (np.isfinite(rows.sigma) for rows in all_rows(data))
    return list(zip(tests, (np.abs(hz) for hz in row_frequencies_hz(data)), used, strict=True))


def shares_by_frequency(twin: Twin, data: Reduced, label: Callable[[float], str]) -> dict[str, float]:
    """Share of the squares in each group of frequencies, by rising frequency."""
    frequency = np.abs(np.concatenate(list(row_frequencies_hz(data))))
    power = np.concatenate([np.sum(np.abs(r) ** 2, axis=0) for r in residuals_of_twin(twin, data)])
    sums: dict[str, float] = {}
    for k in np.argsort(frequency):
        name = label(float(frequency[k]))
        sums[name] = sums.get(name, 0.0) + float(power[k])
    whole = max(sum(sums.values()), 1e-300)
    return {k: v / whole for k, v in sums.items()}


def nearest_mode(resonances_hz: Sequence[float]) -> Callable[[float], str]:
    """From a frequency to the number of the mode that is nearest; "none" where none is known."""
    known = np.array(resonances_hz)

    def mode_of(f: float) -> str:
        return str(1 + int(np.argmin(np.abs(np.log(known / max(f, 0.1)))))) if len(known) else "none"

    return mode_of


def name_of_band(hz: float) -> str:
    """The name of the band a frequency lies in."""
    for low, high in itertools.pairwise(BANDS_HZ):
        if low <= hz < high:
            return f"{low:g}-{high:g}"
    return f"{BANDS_HZ[-1]:g}-"


DRAWS = 400
BARE = 0.02
"""Excess above the floor below which there is nothing to shrink."""


def share_of_gap_closed(before: float, after: float) -> float:
    """Share of the reducible gap that is closed: 1 - (after^2 - 1) / (before^2 - 1)."""
    return 1 - (after**2 - 1) / (before**2 - 1)


def shrinkage_with_interval(
    held_out: list[str],
    before: SquaredResiduals,
    after: SquaredResiduals,
    rivals: dict[str, float],
    rng: np.random.Generator,
) -> Shrinkage:
    """The shrinkage with its 95 % interval, by bootstrap over channels of records.

    Args:
        held_out: names of the records.
        before: squares of the twin without effects, in noise units squared, one entry a channel of a record.
        after: the same with the effects found, entry by entry.
        rivals: share closed by the best other explanation, by its effects.
        rng: draws the entries with replacement.
    """
    if before.gap**2 - 1 < BARE:
        return Shrinkage(
            held_out=held_out, before=before.gap, after=after.gap, closed=None, interval=None, rival=rivals
        )
    draws = rng.integers(0, len(before.total), size=(DRAWS, len(before.total)))
    count = np.sum(before.count[draws], axis=1)
    g0, g1 = (np.sum(s.total[draws], axis=1) / count for s in (before, after))
    # A draw without any of the gap says nothing about how much of it is closed.
    ok = g0 - 1 > 0.05 * (before.gap**2 - 1)
    values = 1 - (g1[ok] - 1) / (g0[ok] - 1)
    low, high = np.quantile(values, [0.025, 0.975]) if len(values) > 20 else (-np.inf, 1.0)
    share = share_of_gap_closed(before.gap, after.gap)
    return Shrinkage(
        held_out=held_out,
        before=before.gap,
        after=after.gap,
        closed=share,
        interval=(min(float(low), share), max(float(high), share)),
        rival=rivals,
    )
