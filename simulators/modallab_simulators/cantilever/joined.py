"""Two families of modes side by side."""

import numpy as np

from modallab.core.arrays import Complex128, Real
from modallab_simulators.cantilever.basis import Basis, ModalBasis
from modallab_simulators.cantilever.modes import Modes


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
