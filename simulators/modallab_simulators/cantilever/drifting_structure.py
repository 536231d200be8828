"""The modes of a structure that drifts a little: those at its beginning, middle and end, and a parabola through them.

To assemble a structure again takes far longer than to let it move on. A drift of EI by a thousandth moves poles and
shapes along as good as a straight line, and what a parabola leaves of them is of the third order: with the bend at most
`BEND`, below the rounding of the eigenvalue problem itself (1e-9 of a frequency). Where they bend more, as where two
modes come close, the structure is assembled anew at every step.
"""

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from modallab.core.arrays import Complex128, Real
from modallab_simulators.cantilever.basis import Basis
from modallab_simulators.cantilever.modes import Modes

NODES = (0.0, 0.5, 1.0)
"""Shares of the drift at which the structure is assembled."""

BEND = 1e-6
"""The middle may lie so far from the line between the ends, of a pole's or a shape's size."""

_ALONG = 101
_MOST = 256


class DriftingStructure:
    """A structure's bases along its drift.

    Args:
        at: assembles the basis at a share of the drift, 0 to 1.
    """

    def __init__(self, at: Callable[[float], Basis]) -> None:
        self._at = at

    def basis(self, progress: float) -> Basis:
        """The basis at a share of the drift."""
        if progress == NODES[0]:
            return self._first
        return self._at(progress) if self._nodes is None else BetweenBases(self._nodes, progress)

    @cached_property
    def _first(self) -> Basis:
        return self._at(NODES[0])

    @cached_property
    def _nodes(self) -> "tuple[_Node, ...] | None":
        """What stands at the nodes; None where no parabola may be laid through it."""
        bases = [self._first, *(self._at(progress) for progress in NODES[1:])]
        if len({len(basis.poles) for basis in bases}) > 1:
            return None
        along = np.linspace(0.0, self._first.modes.length_m, _ALONG)
        shapes = [basis.shapes(along) for basis in bases]
        signs = [relative_sign(shape, shapes[0]) for shape in shapes]
        straight = _straight([basis.poles for basis in bases]) and _straight(
            [shape * sign for shape, sign in zip(shapes, signs, strict=True)]
        )
        return tuple(_Node(basis, sign) for basis, sign in zip(bases, signs, strict=True)) if straight else None


def relative_sign(shapes: Real | Complex128, others: Real | Complex128) -> Real:
    """-1 for each mode whose shape stands upside down to the other's, else 1, (modes,) of two (points, modes)."""
    along: Real = np.sum(shapes * others.conj(), axis=0).real
    return np.where(along < 0, -1.0, 1.0)


def _straight(values: Sequence[Real | Complex128]) -> bool:
    """Whether the middle of three (modes,) or (points, modes) lies on the line between the others."""
    first, middle, last = values
    return bool(np.all(np.abs(middle - (first + last) / 2) <= BEND * np.max(np.abs(middle), axis=0)))


class _Node:
    """A basis that remembers what it was asked; its shapes stand the same way as those at the other nodes."""

    def __init__(self, basis: Basis, sign: Real) -> None:
        self.basis, self.poles, self.scale, self._sign = basis, basis.poles, basis.scale, sign
        self._known: dict[tuple[bytes, float, int], Real | Complex128] = {}

    @cached_property
    def participation(self) -> Real | Complex128:
        return self.basis.participation * self._sign

    def project(self, rows: Real) -> Real | Complex128:
        return self.basis.project(rows) * self._sign

    def shapes(self, x_m: Real, order: int) -> Real | Complex128:
        return self._remembered((x_m.tobytes(), -1.0, order), lambda: self.basis.shapes(x_m, order) * self._sign)

    def remainder(self, x_m: Real, force_x_m: float, put: int) -> Real | Complex128:
        return self._remembered((x_m.tobytes(), force_x_m, put), lambda: self.basis.remainder(x_m, force_x_m, put))

    def base_remainder(self, x_m: Real) -> Real | Complex128:
        return self._remembered((x_m.tobytes(), -2.0, 0), lambda: self.basis.base_remainder(x_m))

    def _remembered(self, key: tuple[bytes, float, int], asked: Callable[[], Real | Complex128]) -> Real | Complex128:
        if key not in self._known:
            if len(self._known) > _MOST:
                self._known.clear()
            self._known[key] = asked()
        return self._known[key]


class BetweenBases:
    """The basis on the parabola through three."""

    def __init__(self, nodes: Sequence[_Node], progress: float) -> None:
        self._nodes, p = tuple(nodes), progress
        self._weights = ((1 - p) * (1 - 2 * p), 4 * p * (1 - p), p * (2 * p - 1))
        self._nearest = nodes[round(2 * p)]

    @property
    def poles(self) -> Complex128:
        """p, (modes,)."""
        return self._between([node.poles for node in self._nodes])

    @property
    def scale(self) -> Real:
        """s, (modes,)."""
        return self._between([node.scale for node in self._nodes])

    def shapes(self, x_m: Real, order: int = 0) -> Real | Complex128:
        """psi, (points, modes)."""
        return self._between([node.shapes(x_m, order) for node in self._nodes])

    @property
    def modes(self) -> Modes:
        """The undamped modes at the nearest node."""
        return self._nearest.basis.modes

    def project(self, rows: Real) -> Real | Complex128:
        """psi of loads on the undamped modes."""
        return self._between([node.project(rows) for node in self._nodes])

    def remainder(self, x_m: Real, force_x_m: float, put: int = 0) -> Real:
        """Static displacement that all modes beyond add, (points,)."""
        return self._between([node.remainder(x_m, force_x_m, put) for node in self._nodes])

    @property
    def participation(self) -> Real | Complex128:
        """What an acceleration of the base puts into each mode."""
        return self._between([node.participation for node in self._nodes])

    def base_remainder(self, x_m: Real) -> Real:
        """Static displacement per acceleration of the base that all modes beyond add."""
        return self._between([node.base_remainder(x_m) for node in self._nodes])

    def _between(self, values: Sequence[Any]) -> Any:
        first, middle, last = self._weights
        return first * values[0] + middle * values[1] + last * values[2]
