"""From internal steps to delivered samples: many steps of an oscillator, and the filter, as one set of weights."""

import numpy as np
from numpy.typing import NDArray

from modallab_simulators.cantilever.hold import TAPS, step_taps


def modal_taps(
    poles: NDArray[np.complex128], step_s: float, lowpass_taps: NDArray[np.float64]
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """What a filtered mode owes to each force sample, (modes, taps), and to the state before, (modes,).

    Samples and taps run from the oldest to the newest.
    """
    step = np.exp(poles * step_s)
    length = len(lowpass_taps) - 1
    after = np.empty((length, len(poles)), dtype=np.complex128)
    total = np.full(len(poles), lowpass_taps[length], dtype=np.complex128)
    for s in range(length - 1, -1, -1):
        after[s] = total
        total = total * step + lowpass_taps[s]
    holds = step_taps(poles, step_s)
    modal = np.array([np.convolve(after[:, r], holds[r]) for r in range(len(poles))]).reshape(len(poles), -1)
    return modal, total


def state_taps(poles: NDArray[np.complex128], step_s: float, oversample: int) -> NDArray[np.complex128]:
    """Weights of the force samples in the state after one delivered sample, (taps, modes)."""
    step = np.exp(poles * step_s)
    holds = step_taps(poles, step_s)
    taps = np.zeros((oversample + TAPS - 1, len(poles)), dtype=np.complex128)
    for s in range(oversample):
        taps[s : s + TAPS] += (holds * step[:, None] ** (oversample - 1 - s)).T
    return taps
