"""Which refined poles are called modes where two have run onto one."""

import numpy as np
import pytest

from modallab.identification.likelihood.basis import LineBlock
from modallab.identification.likelihood.excitation import BlockLines, UnitExcitation
from modallab.identification.likelihood.fit import LikelihoodFit
from modallab.identification.likelihood.projection import LikelihoodProblem, SearchParameters
from modallab.identification.likelihood.search import search_minimum
from modallab.identification.selection.prune import is_mode

TRUE_HZ, ZETA = np.array([60.0, 100.0]), 0.005


def fitted(start_hz, seed):
    f = np.linspace(20.0, 160.0, 1500)
    s, w = 2j * np.pi * f, 2 * np.pi * TRUE_HZ[:, None]
    rng = np.random.default_rng(seed)
    clean = rng.uniform(0.5, 1.5, (4, 2)) @ (s / (s**2 + 2 * ZETA * w * s + w**2))
    noise = 0.02 * np.sqrt(np.mean(np.abs(clean) ** 2)) * (rng.standard_normal((2, *clean.shape)) / np.sqrt(2))
    omega = 2 * np.pi * np.array(start_hz)
    problem = LikelihoodProblem(
        blocks=[LineBlock(UnitExcitation(BlockLines(2 * np.pi * f, 0, 0.0, 1)), clean + noise[0] + 1j * noise[1], 0)],
        powers=(-2, 0, 2),
        n_inputs=1,
        state_sigma=None,
        drive_sigma=None,
        zeta_prior=np.tile([0.0, np.inf], (omega.size, 1)),
    )
    nothing = np.zeros((1, omega.size), complex)
    start = SearchParameters(omega, np.full(omega.size, ZETA), nothing, np.zeros(1, complex))
    return LikelihoodFit(problem, search_minimum(problem, start), (None,), (4, 1))


@pytest.mark.parametrize(
    ("seed", "start"), [(16, (99.8, 100.4)), (34, (99.8, 100.4)), (2, (99.97, 100.05)), (25, (99.97, 100.05))]
)
def test_of_two_poles_on_one_mode_one_is_kept(seed, start):
    """Side by side neither is known, and both were once taken for noise."""
    fit = fitted([60.0, *start], seed)
    kept = np.sort(fit.point.parameters.omega[is_mode(fit, (20.0, 160.0))]) / (2 * np.pi)
    np.testing.assert_allclose(kept, TRUE_HZ, rtol=5e-3)
