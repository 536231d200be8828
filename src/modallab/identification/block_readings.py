"""What the half-power rule reads for the modes of an impact test, and what it would read without any damping."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.rig import Rig
from modallab.frf.estimate import convert, impact_frf
from modallab.identification.estimators.half_power import reading_near, summed_amplitude
from modallab.identification.likelihood.excitation import HitExcitation
from modallab.identification.likelihood.fit import Fit
from modallab.signals.signals import Signals

Groups = Sequence[Sequence[Signals]]


def half_power_readings(
    fit: Fit, groups: Groups, rig: Rig, band: tuple[float, float], keep: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """What the half-power rule reads for each kept mode, and what it would read without any damping, each (kept,)."""
    measured = convert(impact_frf(groups, rig, band), "mobility")
    requested = fit.point.parameters.omega[keep] / (2 * np.pi)
    order = np.sort(requested)
    amplitude = summed_amplitude(measured)
    read = np.array([reading_near(measured.frequency_hz, amplitude, f) for f in order])
    floor = np.array([_floor(fit, measured.frequency_hz, f) for f in order])
    return read, floor


def _floor(fit: Fit, frequency_hz: NDArray[np.float64], requested_hz: float) -> float:
    """Half-power reading of this mode alone in the first block, had it no damping at all."""
    excitation = fit.problem.blocks[0].excitation
    if not isinstance(excitation, HitExcitation):
        return float("nan")
    grid = replace(excitation.grid, p=1)
    pole = np.array([2j * np.pi * requested_hz * (1 + 1e-9j)])
    bare = replace(excitation, grid=grid)
    residue = 1 / (2j * 2 * np.pi * requested_hz)
    response = residue * bare.forced(pole)[0][0] - residue * bare.forced(pole.conj())[0][0]
    force = bare.static(-1)
    quiet = np.any(force == 0)
    return float("nan") if quiet else reading_near(frequency_hz, np.abs(response / force), requested_hz)
