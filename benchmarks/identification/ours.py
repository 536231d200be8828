"""The project's own identification of a case, as a user would call it, and the Cramer-Rao bound of the case."""

import numpy as np
from cases import Case, mobility
from numpy.typing import NDArray

from modallab.core.errors import IdentificationError
from modallab.core.frf import Frf
from modallab.core.model import ModalModel
from modallab.core.rig import Channel, Point, Rig
from modallab.identification.frf_model import identify_frf
from modallab.identification.likelihood.basis import LineBlock
from modallab.identification.likelihood.excitation import BlockLines, UnitExcitation
from modallab.identification.likelihood.normal_matrix import normal_equations
from modallab.identification.likelihood.projection import LikelihoodProblem, SearchParameters, solve_at
from modallab.identification.options import IdentificationOptions


def rig_of(n: int) -> Rig:
    channels = [Channel(index=0, name="force", quantity="force", unit="N")]
    channels += [Channel(index=i, name=f"v{i:03d}", quantity="velocity", unit="m/s", point=i) for i in range(1, n + 1)]
    points = tuple(Point(id=i, x_m=0.01 * i) for i in range(1, n + 1))
    return Rig(name="case", model="unknown", points=points, channels=tuple(channels))


def frf_of(case: Case) -> Frf:
    n = len(case.mobility)
    return Frf(
        frequency_hz=case.frequency_hz,
        values=case.mobility,
        quantity="mobility",
        outputs=tuple(f"v{i:03d}" for i in range(1, n + 1)),
        output_points=tuple(range(1, n + 1)),
        input_points=tuple(d + 1 for d in case.truth.drive),
    )


def identified(case: Case, max_order: int | None = None) -> ModalModel | None:
    """The model, or None where there is none to be found."""
    try:
        return identify_frf(frf_of(case), rig_of(len(case.mobility)), IdentificationOptions(max_order=max_order))[0]
    except IdentificationError:
        return None


def cramer_rao(case: Case) -> NDArray[np.float64]:
    """(modes, 2) least sigma of f (Hz) and zeta that any unbiased estimator can have, residues unknown."""
    truth = case.truth
    f = case.frequency_hz[case.frequency_hz > 0]
    clean = mobility(truth, f)[: len(case.mobility)].reshape(-1, f.size)
    problem = LikelihoodProblem(
        blocks=[LineBlock(UnitExcitation(BlockLines(2 * np.pi * f, 0, 0.0, 1)), clean, 0)],
        powers=(),
        n_inputs=1,
        state_sigma=None,
        drive_sigma=None,
        zeta_prior=np.tile([0.0, np.inf], (truth.zeta.size, 1)),
    )
    at = SearchParameters(
        2 * np.pi * truth.frequency_hz, truth.zeta, np.zeros((1, truth.zeta.size), complex), np.zeros(1, complex)
    )
    # The noise of a line's real part is a half of the complex number's variance.
    point = solve_at(problem, at, case.sigma.ravel() / np.sqrt(2))
    matrix = normal_equations(problem, point).whole()
    scale = 1 / np.sqrt(np.diag(matrix))
    covariance = np.linalg.inv(matrix * np.outer(scale, scale)) * np.outer(scale, scale)
    sigma = np.sqrt(np.diag(covariance)).reshape(-1, 2)
    return sigma / np.array([2 * np.pi, 1])
