"""What can be fed back: an element's place on the beam as rows of modal numbers, and its law as numbers."""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from modallab.core.arrays import Complex128, Real, gauss_legendre
from modallab_simulators.cantilever.attached import KEPT
from modallab_simulators.cantilever.basis import Basis
from modallab_simulators.cantilever.cracked import HALF_WIDTH
from modallab_simulators.cantilever.modes import Modes

Law = Literal["cubic", "friction", "play", "crack"]

_SPAN = 5.0
_NODES = 400

FITTED = 2
"""Numbers of the line that is fitted to the moment over a crack."""


@dataclass(frozen=True, slots=True)
class PointElement:
    """A force on the displacement (order 0) or a moment on the slope (1) at a point.

    Attributes:
        x_m: where.
        order: which motion it works on.
        law: cubic (k3), friction (k, limit) or play (k, gap).
        numbers: of the law.
    """

    x_m: float
    order: int
    law: Law
    numbers: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class CrackElement:
    """A loss of bending stiffness that is there only while the moment at its middle is positive.

    What an open crack adds to the curvature is c(s) M(s), with c its compliance per length, and M a straight line
    fitted to the moment over the crack. Its channels are that line's numbers; a channel's load on the intact beam is
    the curvature c(s) (s - x)^i forced upon it.

    Attributes:
        x_m: its middle.
        share: of EI that is lost there while it is open.
        bending_stiffness_n_m2: EI of the intact beam.
    """

    x_m: float
    share: float
    bending_stiffness_n_m2: float
    law: Law = field(default="crack", init=False)
    numbers: tuple[float, ...] = field(default=(), init=False)

    def compliance(self, length_m: float) -> Real:
        """Integrals of c(s) (s - x)^(i + j), (channels, channels)."""
        s, weights, powers, _ = self._along(length_m)
        c = weights * self._excess(s, length_m)
        return powers @ (powers * c).T

    def rows(self, modes: Modes) -> Real:
        """What each channel's forced curvature puts into each mode, (channels, KEPT)."""
        length = modes.length_m
        s, weights, powers, slopes = self._along(length)
        ei, excess = self.bending_stiffness_n_m2, self._excess(s, length)
        # By parts, so that the slope of the modes is enough: c W'' = (c W')' - c' W'.
        falls = -2 * (s - self.x_m) / (HALF_WIDTH * length) ** 2
        gauss = self.share * np.exp(-(((s - self.x_m) / (HALF_WIDTH * length)) ** 2))
        change = falls * gauss / (1 - gauss) ** 2 / ei
        inner = (powers * change + slopes * excess) * weights
        ends = np.array([0.0, length])
        at_ends = (ends - self.x_m) ** np.arange(FITTED)[:, None] * self._excess(ends, length) * [-1.0, 1.0]
        return ei * (at_ends @ modes.shapes(ends, KEPT, 1) - inner @ modes.shapes(s, KEPT, 1))

    def _along(self, length_m: float) -> tuple[Real, Real, Real, Real]:
        half = _SPAN * HALF_WIDTH * length_m
        low, high = max(self.x_m - half, 0.0), min(self.x_m + half, length_m)
        at, weights = gauss_legendre(_NODES)
        s = low + (high - low) * (at + 1) / 2
        orders = np.arange(FITTED)[:, None]
        powers = (s - self.x_m) ** orders
        slopes = orders * (s - self.x_m) ** np.maximum(orders - 1, 0)
        return s, weights * (high - low) / 2, powers, slopes

    def _excess(self, s: Real, length_m: float) -> Real:
        """c(s): what the crack adds to 1 / EI."""
        gauss = self.share * np.exp(-(((s - self.x_m) / (HALF_WIDTH * length_m)) ** 2))
        return (1 / (1 - gauss) - 1) / self.bending_stiffness_n_m2


@dataclass(frozen=True, slots=True)
class Drag:
    """A drag c2 |v| v per length along the whole beam."""

    c2_per_m: float

    MODES = 6
    POINTS = 16

    def sensed_motion(self, modes: Modes) -> Real:
        """Shapes of the modes it works on at the points where it is taken, (points, MODES)."""
        return modes.shapes(self._points(modes)[0], self.MODES)

    def put(self, modes: Modes) -> Real:
        """Force on each mode per |v| v at each point, (MODES, points)."""
        x, weights = self._points(modes)
        return self.c2_per_m * weights * modes.shapes(x, self.MODES).T

    def _points(self, modes: Modes) -> tuple[Real, Real]:
        at, weights = gauss_legendre(self.POINTS)
        return modes.length_m * (at + 1) / 2, weights * modes.length_m / 2


@dataclass(frozen=True, eq=False, slots=True)
class ForceChannel:
    """One channel of force in the modes of a basis.

    Attributes:
        psi: what it puts into each oscillator, and its motion sees of each, (modes,).
        row: the same for the undamped modes behind, (KEPT,).
        point: (place, order) of a load at a point, else None.
    """

    psi: Real | Complex128
    row: Real
    point: tuple[float, int] | None = None


def channels_of(element: PointElement | CrackElement, basis: Basis) -> list[ForceChannel]:
    """The channels of an element."""
    if isinstance(element, PointElement):
        at = np.array([element.x_m])
        row = basis.modes.shapes(at, KEPT, element.order)[0]
        return [ForceChannel(basis.shapes(at, element.order)[0], row, (element.x_m, element.order))]
    return [ForceChannel(basis.project(row), row) for row in element.rows(basis.modes)]


def static_remainder(basis: Basis, one: ForceChannel, other: ForceChannel) -> float:
    """What the modes beyond those of the basis add statically between two channels."""
    kept = (one.psi * other.psi / (-basis.poles * basis.scale)).imag.sum()
    if one.point and other.point:
        at, order = one.point
        whole = basis.modes.flexibility(np.array([at]), other.point[0], order, other.point[1])[0]
    else:
        whole = (one.row * other.row / basis.modes.omega(KEPT) ** 2).sum()
    return float(whole - kept)
