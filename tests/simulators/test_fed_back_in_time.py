"""What an element feeds back acts at its own time, no internal sample before and none after.

A play that is never left takes its spring's force off for good, so that one of negative stiffness is a spring, and the
frequency response of a beam on a spring follows in closed form from that of the beam alone.
"""

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from test_cantilever_structure import BEAM, OUTPUTS, X, basis, receptance, strike

from modallab_simulators.cantilever.feedback.elements import PointElement
from modallab_simulators.cantilever.feedback.structure import FeedbackStructure
from modallab_simulators.cantilever.hammer import ContactPulse
from modallab_simulators.cantilever.structure import LinearStructure
from modallab_simulators.cantilever.truth import oversampling

RATE_HZ = 2000.0
BLOCKS = 24
NEVER_LEFT = 1e9


def struck(element: PointElement, point: int) -> NDArray[np.float64]:
    """All outputs after a hit, (outputs, samples)."""
    times = oversampling(RATE_HZ)
    linear = LinearStructure(basis(RATE_HZ, 0.03), OUTPUTS, RATE_HZ, times)
    fed = FeedbackStructure(linear, [element], None, 1 / (RATE_HZ * times))
    return strike(fed, RATE_HZ, float(X[point]), ContactPulse(0.0123, 0.0015, 100.0), BLOCKS)[0]


@pytest.mark.parametrize("stiffness", [0.3, 30.0])
def test_a_play_that_is_never_left_is_a_spring(stiffness: float):
    tip, point = BEAM.length_m, 4
    spring = stiffness * 3 * BEAM.bending_stiffness_n_m2 / tip**3
    seen = struck(PointElement(tip, 0, "play", (-spring, NEVER_LEFT)), point)
    f = np.fft.rfftfreq(seen.shape[1], 1 / RATE_HZ)
    spectra = np.fft.rfft(seen, axis=1)
    used = (f > 0.5) & (f < 200)
    omega, modes = 2 * math.pi * f[used], basis(RATE_HZ, 0.03)
    free, pushed = receptance(modes, X, float(X[point]), omega), receptance(modes, X, tip, omega)
    exact = -(omega**2) * (free - pushed * spring * free[-1] / (1 + spring * pushed[-1]))
    error = np.abs(spectra[1:, used] / spectra[0, used] - exact)
    assert (error / np.maximum(np.abs(exact), 0.1)).max() < 2e-3
