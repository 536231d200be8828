"""The modes of a basis when only so many of them exist: what lies beyond answers nothing, not even statically."""

import numpy as np

from modallab.core.arrays import Complex128, Real
from modallab_simulators.cantilever.basis import Basis
from modallab_simulators.cantilever.modes import Modes


class FewModes:
    """A basis of a structure that has `count` modes in all; those not integrated in time answer statically.

    The undamped modes behind it stay complete: nonlinear elements need what holds them.
    """

    def __init__(self, main: Basis, count: int) -> None:
        self._main, self._count = main, count

    @property
    def poles(self) -> Complex128:
        """p, (modes,)."""
        return self._main.poles

    @property
    def scale(self) -> Real:
        """s, (modes,)."""
        return self._main.scale

    @property
    def modes(self) -> Modes:
        """The undamped modes behind it, all of them."""
        return self._main.modes

    def shapes(self, x_m: Real, order: int = 0) -> Real | Complex128:
        """psi, (points, modes)."""
        return self._main.shapes(x_m, order)

    def project(self, rows: Real) -> Real | Complex128:
        """psi of loads on the undamped modes."""
        return self._main.project(rows)

    def remainder(self, x_m: Real, force_x_m: float, put: int = 0) -> Real:
        """Of the modes up to the last one that are not integrated, (points,)."""
        load = self.modes.shapes(np.array([force_x_m]), self._count, put)[0]
        return self._static(x_m, load) - self._kept(x_m, self.shapes(np.array([force_x_m]), put)[0])

    @property
    def participation(self) -> Real | Complex128:
        """What an acceleration of the base puts into each mode."""
        return self._main.participation

    def base_remainder(self, x_m: Real) -> Real:
        """Of the modes up to the last one that are not integrated, (points,)."""
        return self._static(x_m, -self.modes.participation(self._count)) - self._kept(x_m, self.participation)

    def _static(self, x_m: Real, load: Real) -> Real:
        return self.modes.shapes(x_m, self._count) @ (load / self.modes.omega(self._count) ** 2)

    def _kept(self, x_m: Real, load: Real | Complex128) -> Real:
        return (self.shapes(x_m) * load / (-self.poles * self.scale)).imag.sum(axis=1)
