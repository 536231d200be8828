"""The modes that are integrated in time: real ones with a damping ratio each, or complex ones of a local damper.

In both, a mode is a first-order oscillator z' = p z + f, and a point moves as Im(sum of psi(x) psi(x_f) z / s).
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from modallab.core.arrays import Complex128, Real
from modallab_simulators.cantilever.modes import Modes


class Basis(Protocol):
    """What the bench integrates in time."""

    @property
    def poles(self) -> Complex128:
        """p, with an imaginary part from 0, (modes,)."""
        ...

    @property
    def scale(self) -> Real:
        """s, (modes,)."""
        ...

    def shapes(self, x_m: Real, order: int = 0) -> Real | Complex128:
        """psi, displacement (order 0) or slope (1), in kg^-1/2, (points, modes)."""
        ...

    @property
    def modes(self) -> Modes:
        """The undamped modes behind it."""
        ...

    def project(self, rows: Real) -> Real | Complex128:
        """psi of loads known by what they do to each undamped mode, (loads, modes behind) to (loads, modes)."""
        ...

    def remainder(self, x_m: Real, force_x_m: float, put: int = 0) -> Real:
        """Static displacement per force (put = 0) or moment (1) that all modes beyond add, (points,)."""
        ...

    @property
    def participation(self) -> Real | Complex128:
        """What an acceleration of the base puts into each mode, in kg^1/2, (modes,)."""
        ...

    def base_remainder(self, x_m: Real) -> Real:
        """Static displacement per acceleration of the base that all modes beyond add, in s^2, (points,)."""
        ...


@dataclass(frozen=True, eq=False)
class ModalBasis:
    """The first len(omega) modes of a structure, each with a damping ratio of its own."""

    beam: Modes
    omega: Real
    zeta: Real

    @property
    def poles(self) -> Complex128:
        """p = -zeta omega + j omega sqrt(1 - zeta^2)."""
        return self.omega * (-self.zeta + 1j * np.sqrt(1 - self.zeta**2))

    @property
    def scale(self) -> Real:
        """omega sqrt(1 - zeta^2)."""
        return self.poles.imag

    def shapes(self, x_m: Real, order: int = 0) -> Real:
        """At unit modal mass in kg^-1/2, (points, modes)."""
        return self.beam.shapes(x_m, len(self.omega), order)

    @property
    def modes(self) -> Modes:
        """The undamped modes behind it."""
        return self.beam

    def project(self, rows: Real) -> Real:
        """The first of them."""
        return rows[..., : len(self.omega)]

    def remainder(self, x_m: Real, force_x_m: float, put: int = 0) -> Real:
        """Static flexibility of all modes beyond, (points,)."""
        own = self.shapes(x_m) * self.shapes(np.array([force_x_m]), put) / self.omega**2
        return self.beam.flexibility(x_m, force_x_m, 0, put) - own.sum(axis=1)

    @property
    def participation(self) -> Real:
        """Integral of mass times shape, against the base's acceleration."""
        return -self.beam.participation(len(self.omega))

    def base_remainder(self, x_m: Real) -> Real:
        """Of the modes beyond, up to three times as many."""
        return _base_remainder(self.beam, x_m, len(self.omega))


def _base_remainder(modes: Modes, x_m: Real, kept: int) -> Real:
    count = min(3 * kept, max(80, kept))
    share = -modes.participation(count) / modes.omega(count) ** 2
    return modes.shapes(x_m, count)[:, kept:] @ share[kept:]


class JoinedBasis:
    """A basis beside another family of modes, which loads drive and sensors see by a share."""

    def __init__(self, main: Basis, side: ModalBasis, share: float) -> None:
        self._main, self._side, self._share = main, side, share

    @property
    def poles(self) -> Complex128:
        """p of both, (modes,)."""
        return np.concatenate([self._main.poles, self._side.poles])

    @property
    def scale(self) -> Real:
        """s of both, (modes,)."""
        return np.concatenate([self._main.scale, self._side.scale])

    def shapes(self, x_m: Real, order: int = 0) -> Complex128:
        """psi; a moment knows nothing of the family beside, (points, modes)."""
        count = len(self._side.omega)
        side = np.zeros((len(x_m), count)) if order else self._share * self._side.shapes(x_m)
        return _beside(self._main.shapes(x_m, order), side)

    @property
    def modes(self) -> Modes:
        """The undamped modes behind the main family."""
        return self._main.modes

    def project(self, rows: Real) -> Complex128:
        """psi of loads on the main family's undamped modes."""
        main = self._main.project(rows)
        return _beside(main, np.zeros((*main.shape[:-1], len(self._side.omega))))

    def remainder(self, x_m: Real, force_x_m: float, put: int = 0) -> Real:
        """Static displacement that all modes beyond add, (points,)."""
        main = self._main.remainder(x_m, force_x_m, put)
        return main if put else main + self._share**2 * self._side.remainder(x_m, force_x_m)

    @property
    def participation(self) -> Complex128:
        """Of the main family: the base shakes along the drive."""
        return _beside(self._main.participation, np.zeros(len(self._side.omega)))

    def base_remainder(self, x_m: Real) -> Real:
        """Of the main family."""
        return self._main.base_remainder(x_m)


def _beside(main: Real | Complex128, side: Real) -> Complex128:
    return np.concatenate([main.astype(np.complex128), side.astype(np.complex128)], axis=-1)


class TruncatedBasis:
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
