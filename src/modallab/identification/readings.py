"""What the half-power rule reads for the modes that a fit has found, and what it would read without any damping."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import Real
from modallab.core.frf import Frf
from modallab.frf.estimate import convert_frf
from modallab.identification.likelihood.excitation import HitExcitation
from modallab.identification.likelihood.fit import LikelihoodFit
from modallab.identification.start.half_power import half_power_near, summed_amplitude


def half_power_readings(frf: Frf, found_hz: Real) -> Real:
    """Damping ratios (modes,) that half-power reads in measured FRFs, one for each frequency."""
    amplitude = summed_amplitude(convert_frf(frf, "mobility"))
    return np.array([half_power_near(frf.frequency_hz, amplitude, f) for f in found_hz])


def floor_of_block(fit: LikelihoodFit, frequency_hz: Real, found_hz: Real) -> Real:
    """Readings (modes,) in the first block of an impact test of each mode alone, had it no damping at all.

    NaN where the force has no content at a line.
    """
    return np.array([_undamped_reading(fit, frequency_hz, f) for f in found_hz])


def floor_of_steps(frequency_hz: Real, found_hz: Real) -> Real:
    """Readings (modes,) from the distance of the drive frequencies; a stepped test has no floor from the block."""
    above = np.clip(np.searchsorted(frequency_hz, found_hz), 1, frequency_hz.size - 1)
    return (frequency_hz[above] - frequency_hz[above - 1]) / (2 * found_hz)


def _undamped_reading(fit: LikelihoodFit, frequency_hz: Real, requested_hz: float) -> float:
    excitation = fit.problem.blocks[0].excitation
    if not isinstance(excitation, HitExcitation):
        return float("nan")
    grid = replace(excitation.grid, p=1)
    pole = np.array([2j * np.pi * requested_hz * (1 + 1e-9j)])
    bare = replace(excitation, grid=grid)
    residue = 1 / (2j * 2 * np.pi * requested_hz)
    response = residue * bare.forced(pole)[0][0] - residue * bare.forced(pole.conj())[0][0]
    force = bare.static(-1)
    without_content = np.any(force == 0)
    return float("nan") if without_content else half_power_near(frequency_hz, np.abs(response / force), requested_hz)
