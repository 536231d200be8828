"""Normal equations of blocks whose inputs share nothing but the poles, solved input by input.

With the Schur complement on the poles the cost is the sum of the cubes of what the inputs have to themselves, not the
cube of their sum.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy import linalg
from scipy.linalg import lapack

from modallab.core.arrays import Real

LEAST_KNOWN = 1e-200


@dataclass(frozen=True, eq=False, slots=True)
class BlockEquations:
    """What the blocks of one input have to themselves.

    Attributes:
        at: (m,) places among all parameters.
        matrix: (m, m) of J^T J.
        across: (poles' n, m) of J^T J.
    """

    at: NDArray[np.int64]
    matrix: Real
    across: Real


@dataclass(frozen=True, eq=False, slots=True)
class ParameterCovariance:
    """Of the poles (n, n), and for each input of the poles and of what its blocks have to themselves (n + m, n + m)."""

    poles: Real
    inputs: Sequence[Real]

    @classmethod
    def of_poles(cls, poles: Real) -> Self:
        """Of one input, whose blocks have nothing to themselves."""
        return cls(poles, (poles,))


@dataclass(frozen=True, eq=False, slots=True)
class NormalEquations:
    """J^T J and J^T residual in noise units.

    Attributes:
        poles: (n, n) of J^T J; the poles' parameters stand before all others.
        inputs: of each input.
        pull: (parameters,) J^T residual.
    """

    poles: Real
    inputs: Sequence[BlockEquations]
    pull: Real

    @property
    def diagonal(self) -> Real:
        """(parameters,) of J^T J."""
        found = np.empty(self.pull.size)
        found[: len(self.poles)] = np.diag(self.poles)
        for own in self.inputs:
            found[own.at] = np.diag(own.matrix)
        return found

    def scaled(self, scale: Real) -> "NormalEquations":
        """Of parameters in units of `scale` (parameters,)."""
        n = len(self.poles)
        inputs = [
            BlockEquations(
                own.at,
                own.matrix * np.outer(scale[own.at], scale[own.at]),
                own.across * np.outer(scale[:n], scale[own.at]),
            )
            for own in self.inputs
        ]
        return NormalEquations(self.poles * np.outer(scale[:n], scale[:n]), inputs, self.pull * scale)

    def step(self, damping: float) -> Real:
        """(parameters,) the move that solves (J^T J + damping) move = pull.

        Raises:
            LinAlgError: rounding has made it indefinite.
        """
        n = len(self.poles)
        left, pull = _damp_matrix(self.poles, damping), self.pull[:n]
        solved: list[Real] = []
        for own in self.inputs:
            both = np.concatenate([own.across.T, self.pull[own.at, None]], axis=1)
            both = linalg.cho_solve(linalg.cho_factor(_damp_matrix(own.matrix, damping)), both)
            left, pull = left - own.across @ both[:, :n], pull - own.across @ both[:, n]
            solved.append(both)
        move = np.empty(self.pull.size)
        move[:n] = linalg.cho_solve(linalg.cho_factor(left), pull)
        for own, both in zip(self.inputs, solved, strict=True):
            move[own.at] = both[:, n] - both[:, :n] @ move[:n]
        return move

    def covariance(self) -> ParameterCovariance:
        """Covariance of the parameters, even if some are undetermined."""
        n = len(self.poles)
        scale = _scale_to_unit(self.diagonal)
        found = self.scaled(scale)._inverse()
        if found is None:
            whole = covariance_of(self.whole())
            return ParameterCovariance(whole[:n, :n], [whole[np.ix_(at, at)] for at in self._places()])
        inputs = [part * np.outer(scale[at], scale[at]) for part, at in zip(found.inputs, self._places(), strict=True)]
        return ParameterCovariance(found.poles * np.outer(scale[:n], scale[:n]), inputs)

    def _places(self) -> list[NDArray[np.int64]]:
        """Of the poles and of what each input has to itself."""
        return [np.concatenate([np.arange(len(self.poles)), own.at]) for own in self.inputs]

    def _inverse(self) -> ParameterCovariance | None:
        """None where rounding may tell in it."""
        least = self.pull.size**2 * np.finfo(float).eps
        left = self.poles
        found: list[tuple[Real, Real]] = []
        for own in self.inputs:
            inverse = _symmetric_inverse(own.matrix, least)
            if inverse is None:
                return None
            across = inverse @ own.across.T
            left = left - own.across @ across
            found.append((inverse, across))
        # What is left of the poles' part is as far from nothing as that part's own size lets it be.
        poles = _symmetric_inverse(left, least, size=_norm_of_matrix(self.poles))
        if poles is None:
            return None
        shared = [(inverse, across, -across @ poles) for inverse, across in found]
        inputs = [np.block([[poles, b.T], [b, inverse - b @ a.T]]) for inverse, a, b in shared]
        return ParameterCovariance(poles, inputs)

    def whole(self) -> Real:
        """(parameters, parameters) J^T J."""
        n = len(self.poles)
        whole = np.zeros((self.pull.size,) * 2)
        whole[:n, :n] = self.poles
        for own in self.inputs:
            whole[np.ix_(own.at, own.at)] = own.matrix
            whole[:n, own.at], whole[own.at, :n] = own.across, own.across.T
        return whole


def covariance_of(matrix: Real) -> Real:
    """Covariance of the parameters of normal equations J^T J (n, n) in noise units, even if some are undetermined."""
    scale = _scale_to_unit(np.diag(matrix))
    scaled = matrix * np.outer(scale, scale)
    inverse = _symmetric_inverse(scaled, len(scaled) ** 2 * np.finfo(float).eps)
    if inverse is not None:
        return inverse * np.outer(scale, scale)
    values, vectors = np.linalg.eigh(scaled)
    # What rounding has made zero or less is not known at all, as between two poles that hardly differ.
    least = len(values) * np.finfo(float).eps * values[-1]
    root = vectors * (scale[:, None] / np.sqrt(np.maximum(values, least)))
    return root @ root.T


def _scale_to_unit(diagonal: Real) -> Real:
    """What scales a diagonal to one: rad/s beside damping ratios differ by many powers of ten.

    What is not known at all has a variance that can still be multiplied.
    """
    return 1 / np.sqrt(np.maximum(diagonal, LEAST_KNOWN))


def _damp_matrix(matrix: Real, damping: float) -> Real:
    damped = matrix.copy()
    damped.flat[:: len(matrix) + 1] += damping
    return damped


def _norm_of_matrix(matrix: Real) -> float:
    return float(np.abs(matrix).sum(axis=0).max(initial=0.0))


def _symmetric_inverse(matrix: Real, least: float, size: float | None = None) -> Real | None:
    """Of a symmetric matrix, in a tenth of the time its eigenvectors take; None where rounding may tell in it.

    Args:
        matrix: scaled.
        least: reciprocal condition.
        size: 1-norm that the condition goes by; None for the matrix's own.
    """
    if not matrix.size:
        return matrix
    factor, failed = lapack.dpotrf(matrix, lower=1)
    if failed:
        return None
    reciprocal_condition, _ = lapack.dpocon(factor, _norm_of_matrix(matrix) if size is None else size, uplo="L")
    if reciprocal_condition < least:
        return None
    lower, _ = lapack.dpotri(factor, lower=1)
    lower = np.tril(lower)
    return lower + np.tril(lower, -1).T
