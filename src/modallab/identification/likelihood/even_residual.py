"""Whether what a fit leaves is noise of one size over lines and hits, as the fit takes it.

Bartlett's test: in every output the variances of pieces (a hit, some lines) are held against their mean. White noise
lets them differ by chance; hits beside their points, a drift and modes that are missing do not.
Source: Bartlett, "Properties of sufficiency and statistical tests", Proc. Royal Society A 160 (1937).
"""

import numpy as np
from scipy.special import chdtrc

from modallab.core.arrays import Real
from modallab.identification.likelihood.fit import LikelihoodFit
from modallab.identification.likelihood.projection import InputSolution, sum_of_squares

ROWS = 40
"""Of a piece: real and imaginary parts of twenty lines."""
CHANCE = 1e-6
"""The motion left from the hit before, which a fit also searches, makes noise a little uneven."""


def is_even(fit: LikelihoodFit) -> bool:
    """Whether chance lets noise of one size be as uneven as the residual is."""
    parts = [_squares_by_piece(group) for group in fit.point.groups]
    spare = np.concatenate([part[0] for part in parts])
    squares = np.concatenate([part[1] for part in parts])
    if len(spare) < 2:
        return True
    total = spare.sum()
    variance = np.maximum(squares / spare[:, None], np.finfo(float).tiny)
    likely = total * np.log(squares.sum(axis=0) / total) - np.sum(spare[:, None] * np.log(variance), axis=0)
    small = 1 + (np.sum(1 / spare) - 1 / total) / (3 * (len(spare) - 1))
    freedom = (len(spare) - 1) * squares.shape[1]
    return bool(chdtrc(freedom, np.sum(likely) / small) > CHANCE)


def _squares_by_piece(group: InputSolution) -> tuple[Real, Real]:
    """(pieces,) degrees of freedom and (pieces, outputs) squares of the residual."""
    rows = group.columns[0].phi.shape[0]
    # What the columns take up is no residual.
    left = 1 - sum_of_squares(group.q.T)
    pieces = [
        m * rows + own
        for m in range(len(group.members))
        for own in np.array_split(np.arange(rows), max(1, rows // ROWS))
    ]
    found = [(float(left[own].sum()), sum_of_squares(group.residual[own])) for own in pieces]
    return np.array([n for n, _ in found]), np.stack([square for _, square in found])
