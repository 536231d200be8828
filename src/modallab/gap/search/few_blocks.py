"""The few sine blocks on which stepped effects are compared: evenly over the frequencies, and with most overtones."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modallab.gap.conditioning.overtones import Harmonic
from modallab.gap.conditioning.rows import Reduced, Rows, SineData
from modallab.gap.search.overtone_lines import with_overtones

LOUDEST = 5
"""Sines with the most overtones that are looked at as well."""


def compared_sines(data: Reduced, overtones: Sequence[Harmonic], count: int) -> Reduced:
    """One sine at each of so many frequencies, and those with the most overtones, with the lines about these."""
    assert data.sines is not None
    clear = [(o.record, int(np.count_nonzero(o.is_clear))) for o in overtones]
    counts = [sum(n for record, n in clear if record == p.name) for p in data.sines.pieces]
    loudest = [int(j) for j in np.argsort(counts, kind="stable")[::-1][:LOUDEST] if counts[j]]
    chosen = sorted({*_evenly_spaced(data.sines, count), *loudest})
    return with_overtones(replace(data, impacts=(), sines=_subset(data.sines, chosen)), overtones)


def _evenly_spaced(d: SineData, count: int) -> list[int]:
    """Blocks evenly over the frequencies there are, the levels in turn."""
    hz = np.round(d.source.frequency_hz, 3)
    each = np.unique(hz)
    places = np.unique(np.linspace(0, len(each) - 1, min(count, len(each))).round().astype(int))
    chosen: list[int] = []
    for turn, at in enumerate(places):
        own = np.flatnonzero(hz == each[at])
        chosen.append(int(own[turn % len(own)]))
    return sorted(chosen)


def _subset(d: SineData, at: list[int]) -> SineData:
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
