"""Whether the levels of a sine test disagree: per newton a bench that answers in proportion answers both alike."""

import numpy as np

from modallab.core.arrays import Real
from modallab.gap.conditioning.rows import SineData
from modallab.gap.model.fit import Fit, all_rows
from modallab.gap.model.forward import forward
from modallab.twin.response import SineBlocks

DEVIATIONS = 5.0
"""Deviations by which the levels of a frequency disagree clearly."""
MOST_RELATIVE = 2e-4
"""Relative difference that converters have without being wrong."""
SEVERAL = 2
"""Frequencies that disagree from which it is no chance."""


def levels_differ(base: Fit) -> bool:
    """Whether what one level answers per newton is not what the other answers, at some frequencies.

    What still rings from the start of a sine, and from the sine before, differs by level on a linear bench too. A
    model that is wrong may have that as wrong as it is large.
    """
    sines = base.problem.data.sines
    return sines is not None and bool(np.count_nonzero(_differences(base, sines) > DEVIATIONS) >= SEVERAL)


def _differences(base: Fit, sines: SineData) -> Real:
    """(frequencies,) deviations between the weakest and the strongest level of each, median over channels."""
    said = forward(base.problem.twin(base.u), base.problem.data)[-1]
    rows, shape = all_rows(base.problem.data)[-1], (len(said), *sines.source.lines.shape)
    of_noise = np.linalg.norm(np.reshape(rows.y / rows.sigma, shape), axis=0)
    middle = shape[-1] // 2
    common = (np.sqrt(rows.common).reshape(shape[1:]) / np.maximum(of_noise, 1e-300))[:, middle]
    y, model, sigma = (np.reshape(v, shape)[:, :, middle] for v in (rows.y, said, rows.sigma))
    found: list[float] = []
    for a, b in _pairs(sines.source):
        rings = np.abs(model[:, a] - model[:, b])
        usual = np.abs(model[:, b]) * (np.hypot(common[a], common[b]) + MOST_RELATIVE)
        noise = np.hypot(sigma[:, a], sigma[:, b]) + usual + rings
        apart = np.abs(y[:, a] - y[:, b] - model[:, a] + model[:, b])
        used = np.isfinite(noise)
        found += [float(np.median(apart[used] / noise[used]))] if np.any(used) else []
    return np.array(found)


def _pairs(source: SineBlocks) -> list[tuple[int, int]]:
    """The weakest and the strongest sine of each frequency that was driven more than once."""
    by_frequency: dict[float, list[int]] = {}
    for j, hz in enumerate(source.frequency_hz):
        by_frequency.setdefault(round(float(hz), 4), []).append(j)
    size = np.abs(source.force)
    driven = [sorted(own, key=lambda j: size[j]) for own in by_frequency.values()]
    return [(own[0], own[-1]) for own in driven if len(own) > 1]
