"""The few sine blocks on which stepped effects are compared: where a linear beam is wrong, and others."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modallab.gap.conditioning.overtones import Harmonic
from modallab.gap.conditioning.rows import Reduced, Rows, SineData
from modallab.gap.model.fit import Fit
from modallab.gap.model.forward import forward
from modallab.gap.search.overtone_lines import with_overtones

SPREAD = 5
"""Every so many frequencies are looked at as well: about a resonance a start is right or wrong, not nearly right."""
LOUDEST = 5
"""Sines with the most overtones that are looked at as well."""


def worst_blocks(data: Reduced, base: Fit, count: int) -> Reduced:
    """The sine blocks that a linear beam explains worst, relative to their size; the hits where there are none."""
    if data.sines is None:
        return data
    d = data.sines
    y = forward(base.problem.twin(base.u), data)[-1]
    off = np.abs(np.where(np.isfinite(d.rows.sigma), d.rows.y - y, 0)) / d.rows.sigma
    by_block = np.sqrt(np.mean(off.reshape(len(off), *d.source.lines.shape) ** 2, axis=(0, 2)))
    chosen: list[int] = []
    for j in np.argsort(by_block)[::-1]:
        pair = [k for k, hz in enumerate(d.source.frequency_hz) if abs(hz - d.source.frequency_hz[j]) < 1e-3]
        chosen += [k for k in pair if k not in chosen]
        if len(chosen) >= count:
            break
    spread = np.unique(np.round(d.source.frequency_hz, 3))[SPREAD // 2 :: SPREAD]
    chosen += [k for k, hz in enumerate(d.source.frequency_hz) if round(float(hz), 3) in spread and k not in chosen]
    return replace(data, impacts=(), sines=_blocks(d, sorted(chosen)))


def looked_at(data: Reduced, overtones: Sequence[Harmonic], count: int) -> Reduced:
    """One sine at each of so many frequencies, and those with the most overtones, with the lines about these."""
    assert data.sines is not None
    clear = [(o.record, int(np.count_nonzero(o.clear))) for o in overtones]
    counts = [sum(n for record, n in clear if record == p.name) for p in data.sines.pieces]
    loudest = [int(j) for j in np.argsort(counts, kind="stable")[::-1][:LOUDEST] if counts[j]]
    chosen = sorted({*_even(data.sines, count), *loudest})
    return with_overtones(replace(data, impacts=(), sines=_blocks(data.sines, chosen)), overtones)


def _even(d: SineData, count: int) -> list[int]:
    """Blocks evenly over the frequencies there are, the levels in turn."""
    hz = np.round(d.source.frequency_hz, 3)
    each = np.unique(hz)
    places = np.unique(np.linspace(0, len(each) - 1, min(count, len(each))).round().astype(int))
    chosen: list[int] = []
    for turn, at in enumerate(places):
        own = np.flatnonzero(hz == each[at])
        chosen.append(int(own[turn % len(own)]))
    return sorted(chosen)


def _blocks(d: SineData, at: list[int]) -> SineData:
    s = d.source
    lines = s.lines.shape[1]
    rows = np.concatenate([np.arange(j * lines, (j + 1) * lines) for j in at])
    rise = replace(
        s.rise,
        history_s=s.rise.history_s[at],
        ramp_s=s.rise.ramp_s[at],
        cosine=s.rise.cosine[at],
        counted=s.rise.counted[at],
    )
    source = replace(s, lines=s.lines[at], frequency_hz=s.frequency_hz[at], force=s.force[at], rise=rise)
    kept = Rows(d.rows.y[:, rows], d.rows.sigma[:, rows], d.rows.common[rows], d.rows.direction[:, rows])
    return replace(d, pieces=tuple(d.pieces[j] for j in at), source=source, rows=kept)
