"""Whether the two levels of a sine test disagree: per newton a bench that answers in proportion answers both alike."""

import numpy as np

from modallab.gap.model.fit import Fit, all_rows
from modallab.gap.model.forward import forward
from modallab.gap.search.fitting import misfit

DEVIATIONS = 8.0
"""Deviations of the noise by which the levels of a frequency disagree clearly."""
OF_A_WRONG_MODEL = 20.0
"""Deviations more for each unit of the relative misfit: transients that the model has wrong differ by level."""
MOST_RELATIVE = 2e-4
"""Relative difference that converters have without being wrong."""
MANY = 0.2
"""Share of the frequencies that must disagree."""
FEWEST = 3
"""Frequencies at two levels from which a share is known."""
SOME = 2
"""Frequencies that disagree from which it is no chance."""


def levels_differ(base: Fit) -> bool:
    """Whether what one level answers per newton is not what the other answers, at many frequencies."""
    apart, count = frequencies_apart(base)
    return count >= FEWEST and apart > MANY * count


def some_levels_differ(base: Fit) -> bool:
    """The same at a few frequencies, as where only a resonance is large enough."""
    return frequencies_apart(base)[0] >= SOME


def frequencies_apart(base: Fit) -> tuple[int, int]:
    """At how many frequencies the levels disagree, and how many were driven at two."""
    sines = base.problem.data.sines
    if sines is None:
        return 0, 0
    limit = DEVIATIONS + OF_A_WRONG_MODEL * misfit(base.problem, base.u)
    found = _differences_of_levels(base)
    return sum(d > limit for d in found), len(found)


def _differences_of_levels(base: Fit) -> list[float]:
    """Of each frequency with two levels: how far these are apart, in deviations, the median over channels."""
    sines = base.problem.data.sines
    assert sines is not None
    rows, y = all_rows(base.problem.data)[-1], forward(base.problem.twin(base.u), base.problem.data)[-1]
    shape = (y.shape[0], *sines.source.lines.shape)
    middle = shape[-1] // 2
    ratio = (rows.y / y).reshape(shape)[:, :, middle]
    spread = (rows.sigma / np.abs(y)).reshape(shape)[:, :, middle]
    common = np.sqrt(rows.common).reshape(shape[1:])[:, middle] / np.maximum(
        np.linalg.norm((rows.y / rows.sigma).reshape(shape)[:, :, middle], axis=0), 1e-300
    )
    differences: list[float] = []
    by_line: dict[float, list[int]] = {}
    for j, hz in enumerate(sines.source.frequency_hz):
        by_line.setdefault(round(float(hz), 4), []).append(j)
    for pair in by_line.values():
        if len(pair) == 2:
            a, b = pair
            step = ratio[:, a] / np.where(ratio[:, b] == 0, 1, ratio[:, b]) - 1
            noise = np.hypot(spread[:, a], spread[:, b]) + np.hypot(common[a], common[b])
            ok = np.isfinite(noise)
            if np.any(ok):
                differences.append(float(np.median(np.abs(step[ok]) / (noise[ok] + MOST_RELATIVE))))
    return differences
