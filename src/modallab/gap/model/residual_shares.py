"""How far two answers lie apart, as a share of the response: what counts for a bench that is no better than its parts.

Differences are squared and summed over the lines of a record, and so is the response: the norm of a record's error over
the record's own (the relative error of a vector; Golub and Van Loan, Matrix Computations, 2013, ch. 2.2).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.gap.conditioning.rows import Reduced, Rows
from modallab.gap.model.fit import all_rows

NODE = 0.03
"""Share of a record's mean squares below which a channel counts as at a node: its own response is no measure there."""
DROWNED = 2500.0
"""A record whose squares are fewer times its noise's says nothing of a percent."""
CHANCE = 3.0
"""Deviations of a sum of squares of noise up to which noise may have left what exceeds it."""
HALF_WIDTHS = 3.0
"""Half-power half-widths about a frequency that count as at resonance, at this damping ratio:"""
DAMPING = 0.006


@dataclass(frozen=True, eq=False, slots=True)
class Record:
    """The lines of one record, or of the hits at one point.

    Attributes:
        name: of the piece of data.
        test: impact or sine.
        at: index of its part of the data, in the order `forward` answers.
        lines: its columns there.
        hz: (k,) their frequencies.
        y: (channels, k) measured.
        noise: (channels, k) expected square of the noise; inf where not to be used.
    """

    name: str
    test: str
    at: int
    lines: slice
    hz: Real
    y: Complex
    noise: Real


def records(data: Reduced) -> Iterator[Record]:
    """The records of reduced data, hits first."""
    for i, d in enumerate(data.impacts):
        hz = np.abs(d.source.lines) / (d.source.n * d.source.dt)
        yield Record(d.piece.name, d.piece.test, i, slice(None), hz, d.rows.y, _noise(d.rows))
    if data.sines is None:
        return
    s, at = data.sines, len(data.impacts)
    count = s.source.lines.shape[1]
    hz, noise = np.abs(s.source.lines) / (s.source.n * s.source.dt), _noise(s.rows)
    for j, piece in enumerate(s.pieces):
        own = slice(j * count, (j + 1) * count)
        yield Record(piece.name, "sine", at, own, hz[j], s.rows.y[:, own], noise[:, own])


def _noise(rows: Rows) -> Real:
    """Of each channel, and of the force along the response."""
    return 2 * rows.sigma**2 * (1 + rows.common * np.abs(rows.direction) ** 2)


def relative_residuals(
    data: Reduced, answers: Sequence[Complex], resonances_hz: Real
) -> tuple[float | None, float | None]:
    """Median over records of measured less predicted over the response, at resonance and away from it; noise taken off.

    Args:
        data: what was measured.
        answers: what a twin says, in the order of `forward`.
        resonances_hz: (p,) frequencies of the modes.
    """
    width = np.maximum(HALF_WIDTHS * DAMPING * resonances_hz, 1.0)
    sides: tuple[list[float], list[float]] = ([], [])
    for r in records(data):
        near = np.any(np.abs(r.hz[:, None] - resonances_hz) < width, axis=1)
        used = np.isfinite(r.noise)
        off = np.where(used, np.abs(r.y - answers[r.at][:, r.lines]) ** 2 - np.where(used, r.noise, 0.0), 0.0)
        own = np.where(used, np.maximum(np.abs(r.y) ** 2 - np.where(used, r.noise, 0.0), 0.0), 0.0)
        for lines, side in ((near, sides[0]), (~near, sides[1])):
            whole = float(np.sum(own[:, lines]))
            if whole > DROWNED * float(np.sum(np.where(used, r.noise, 0.0)[:, lines])):
                side.append(float(np.sum(off[:, lines])) / whole)
    at, away = (float(np.sqrt(max(float(np.median(side)), 0.0))) if side else None for side in sides)
    return at, away


def discrepancies(data: Reduced, answers: Sequence[Complex]) -> dict[str, float]:
    """Record -> what a twin leaves of it besides noise, as a share of its response; 0 where noise may have left it.

    Records that drown in noise are left out.
    """
    found: dict[str, float] = {}
    for r in records(data):
        used = np.isfinite(r.noise)
        noise = np.where(used, r.noise, 0.0)
        own = float(np.sum(np.where(used, np.abs(r.y) ** 2, 0.0)))
        left = float(np.sum(np.where(used, np.abs(r.y - answers[r.at][:, r.lines]) ** 2, 0.0) - noise))
        # The square of a complex Gaussian number scatters by as much as it is.
        sure = left > CHANCE * float(np.sqrt(np.sum(noise**2)))
        if own > DROWNED * float(np.sum(noise)):
            found[r.name] = float(np.sqrt(left / own)) if sure else 0.0
    return found


def largest_difference(data: Reduced, one: Sequence[Complex], other: Sequence[Complex]) -> float:
    """How far two twins' answers lie apart, as a share of the first, on the channel and in the test where it is most.

    Rms over the records of a test; a channel at a node is measured by what the others of its record answer.
    """
    return _most(data, one, other, noisy=False)


def unexplained(data: Reduced, answers: Sequence[Complex]) -> float:
    """How far a twin's answers lie from what was measured, as a share of that, where it is most; noise taken off."""
    return _most(data, [r.y for r in all_rows(data)], answers, noisy=True)


def _most(data: Reduced, one: Sequence[Complex], other: Sequence[Complex], noisy: bool) -> float:
    by_test: dict[str, list[Real]] = {}
    for r in records(data):
        used = np.isfinite(r.noise)
        noise = np.where(used, r.noise, 0.0)
        a, b = one[r.at][:, r.lines], other[r.at][:, r.lines]
        own = np.sum(np.where(used, np.abs(a) ** 2, 0.0), axis=1)
        off = np.sum(np.where(used, np.abs(a - b) ** 2 - noisy * noise, 0.0), axis=1)
        if float(np.sum(own)) > DROWNED * float(np.sum(noise)):
            by_test.setdefault(r.test, []).append(off / np.maximum(own, max(NODE * float(np.mean(own)), 1e-300)))
    squares = [float(np.max(np.mean(listed, axis=0))) for listed in by_test.values()]
    return float(np.sqrt(max(*squares, 0.0))) if squares else 0.0


def weighed_by_record(data: Reduced) -> tuple[Real, Reduced]:
    """The data weighed so that each record's squares are 1, and the squares that noise alone leaves then.

    The squares of noise are one for each entry of a residual, real parts first.

    Records that drown in noise, and channels that are not to be used, weigh nothing.
    """
    listed = all_rows(data)
    sigma = [np.full(rows.sigma.shape, np.inf) for rows in listed]
    squares = [np.zeros(rows.sigma.shape) for rows in listed]
    for r in records(data):
        used = np.isfinite(r.noise)
        noise = float(np.sum(np.where(used, r.noise, 0.0)))
        own = float(np.sum(np.where(used, np.abs(r.y) ** 2, 0.0)))
        if own > DROWNED * noise:
            sigma[r.at][:, r.lines] = np.where(used, np.sqrt(own), np.inf)
            squares[r.at][:, r.lines] = np.where(used, r.noise, 0.0) / own
    weighed = [replace(rows, sigma=s, common=np.zeros_like(rows.common)) for rows, s in zip(listed, sigma, strict=True)]
    impacts = tuple(replace(d, rows=rows) for d, rows in zip(data.impacts, weighed, strict=False))
    sines = replace(data.sines, rows=weighed[-1]) if data.sines is not None else None
    halves = np.concatenate([s.ravel() for s in squares]) / 2
    return np.concatenate([halves, halves]), replace(data, impacts=impacts, sines=sines)
