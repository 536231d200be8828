"""Modes of the beam where its bending stiffness is locally less.

A cantilever is statically determinate: the bending moment of a load does not depend on EI. With the inertia load of a
mode taken as a sum of those of the intact modes, the flexibility of the weaker beam is therefore that of the intact
one plus an integral over their moments, exactly:
(diag(1 / omega^2) + D) a = a / omega'^2 with D_ij = int (1 / EI'(s) - 1 / EI) M_i M_j ds, M_i = EI W_i'' / omega_i^2.
Moments stay smooth where the curvature does not, so few modes are enough even for a deep loss.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real, gauss_legendre
from modallab_simulators.cantilever.beam import CantileverBeam
from modallab_simulators.cantilever.modes import SolvedModes, eigh

HALF_WIDTH = 0.04
"""Of a loss, over L: it falls as exp(-((x - x0) / (0.04 L))^2)."""

_REACH = 5.0
_PANELS = 100
_BASE = 160


@dataclass(frozen=True, slots=True)
class LocalStiffnessLoss:
    """The share of EI that is gone at `x_m`."""

    x_m: float
    share: float


class CrackedBeam(SolvedModes):
    """A beam with losses of bending stiffness, or slow waves of it, behind the interface of its modes.

    Args:
        beam: the intact beam.
        losses: of bending stiffness.
        waves: (k, a): EI times 1 + a cos(k pi x / L).
    """

    def __init__(
        self, beam: CantileverBeam, losses: Sequence[LocalStiffnessLoss], waves: Sequence[tuple[int, float]] = ()
    ) -> None:
        super().__init__(beam)
        self._beam = beam
        self._s, weights = _everywhere(beam.length_m, losses) if waves else _nodes(beam.length_m, losses)
        left = np.ones_like(self._s)
        for loss in losses:
            left *= 1 - loss.share * np.exp(-(((self._s - loss.x_m) / (HALF_WIDTH * beam.length_m)) ** 2))
        for k, a in waves:
            left *= 1 + a * np.cos(k * np.pi * self._s / beam.length_m)
        self._compliance = weights * (1 / left - 1) / beam.bending_stiffness_n_m2

    def shapes(self, x_m: Real, count: int, order: int = 0) -> Real:
        """Displacement or slope of the modes: that of their inertia load on the weaker beam, (points, count)."""
        omega, vectors = self._solved
        deflected = self._beam.shapes(x_m, _BASE, order) / self._beam.omega(_BASE) ** 2
        turned = (_moments(x_m, self._s, order) * self._compliance) @ self._modal_moments
        return (deflected + turned) @ vectors[:, :count] * omega[:count] ** 2

    def participation(self, count: int) -> Real:
        """Integral of mass times shape, in kg^1/2, (count,)."""
        return self._beam.participation(_BASE) @ self._solved[1][:, :count]

    def flexibility(self, x_m: Real, force_x_m: float, seen: int = 0, put: int = 0) -> Real:
        """Static answer at `x_m` to a load at `force_x_m`, (points,)."""
        more = _moments(np.array([force_x_m]), self._s, put)[0] * self._compliance
        return self._beam.flexibility(x_m, force_x_m, seen, put) + _moments(x_m, self._s, seen) @ more

    @cached_property
    def _modal_moments(self) -> Real:
        beam = self._beam
        return beam.shapes(self._s, _BASE, 2) * (beam.bending_stiffness_n_m2 / beam.omega(_BASE) ** 2)

    @cached_property
    def _solved(self) -> tuple[Real, Real]:
        moments = self._modal_moments
        flexibility = np.diag(self._beam.omega(_BASE) ** -2.0) + moments.T @ (moments * self._compliance[:, None])
        values, vectors = eigh(flexibility)
        return values[::-1] ** -0.5, vectors[:, ::-1]


def _nodes(length_m: float, losses: Sequence[LocalStiffnessLoss]) -> tuple[Real, Real]:
    """Gauss-Legendre nodes and weights in fine panels wherever EI is less."""
    half = _REACH * HALF_WIDTH * length_m
    edges = np.unique(
        np.concatenate([np.clip(np.linspace(c.x_m - half, c.x_m + half, _PANELS + 1), 0, length_m) for c in losses])
    )
    mid = (edges[1:] + edges[:-1]) / 2
    inside = np.any([np.abs(mid - loss.x_m) < half for loss in losses], axis=0)
    return _gauss(edges, inside)


def _everywhere(length_m: float, losses: Sequence[LocalStiffnessLoss]) -> tuple[Real, Real]:
    """The same along the whole beam, where any EI is other than believed."""
    half = _REACH * HALF_WIDTH * length_m
    fine = [np.clip(np.linspace(c.x_m - half, c.x_m + half, _PANELS + 1), 0, length_m) for c in losses]
    edges = np.unique(np.concatenate([np.linspace(0, length_m, _PANELS + 1), *fine]))
    return _gauss(edges, np.full(len(edges) - 1, True))


def _gauss(edges: Real, inside: NDArray[np.bool_]) -> tuple[Real, Real]:
    mid = (edges[1:] + edges[:-1]) / 2
    at, weights = gauss_legendre(4)
    width = np.diff(edges)[inside] / 2
    nodes = mid[inside, None] + width[:, None] * at
    return nodes.ravel(), np.multiply.outer(width, weights).ravel()


def _moments(x_m: Real, s: Real, order: int) -> Real:
    """Bending moment at s of a unit force (order 0) or moment (1) at x, (points, nodes)."""
    arm = np.subtract.outer(x_m, s)
    return np.maximum(arm, 0.0) if order == 0 else (arm > 0).astype(np.float64)
