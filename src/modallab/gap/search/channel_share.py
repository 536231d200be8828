"""How much of a misfit stands in each channel."""

import numpy as np

from modallab.core.arrays import Real
from modallab.gap.model.fit import Fit, all_rows, with_relative_noise
from modallab.gap.model.forward import forward
from modallab.gap.search.fitting import forgivable_error


def channel_share(fit: Fit) -> Real:
    """(channels,) share of the relative misfit that stands in each channel, big responses no more than small ones."""
    twin, floor = fit.problem.twin(fit.u), forgivable_error(fit.problem, fit.u)
    total = np.zeros(len(fit.problem.data.channels))
    for rows, y in zip(all_rows(fit.problem.data), forward(twin, fit.problem.data), strict=True):
        r = with_relative_noise(rows, floor / 3).in_noise_units(rows.y - y)
        total += np.sum(np.minimum(np.abs(r) ** 2, 400.0), axis=1)
    return total / max(float(np.sum(total)), 1e-300)
