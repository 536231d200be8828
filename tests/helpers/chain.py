"""A chain of masses and springs, whose modes, changes and responses are known in closed form."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from modallab.core.model import ModalModel

Real = NDArray[np.float64]


@dataclass(frozen=True)
class Chain:
    """Mass, damping and stiffness matrices."""

    mass: Real
    damping: Real
    stiffness: Real

    @classmethod
    def of(cls, masses: list[float], springs: list[float], damping: float = 2e-5) -> "Chain":
        """Springs (masses + 1): the first and the last to ground; damping proportional to stiffness, s."""
        n = len(masses)
        k = np.zeros((n, n))
        for i, spring in enumerate(springs):
            ends = [e for e in (i - 1, i) if 0 <= e < n]
            k[np.ix_(ends, ends)] += spring * (np.array([[1, -1], [-1, 1]]) if len(ends) == 2 else np.ones((1, 1)))
        return cls(np.diag(masses), damping * k, k)

    def poles(self) -> NDArray[np.complex128]:
        """Those with a positive imaginary part, by rising frequency."""
        n = len(self.mass)
        zero, one = np.zeros((n, n)), np.eye(n)
        roots: Any = linalg.eigvals(
            np.block([[zero, one], [-self.stiffness, -self.damping]]), np.block([[one, zero], [zero, self.mass]])
        )
        roots = roots[np.isfinite(roots) & (roots.imag > 1e-9)]
        return roots[np.argsort(roots.imag)]

    def model(self, driven: tuple[int, ...] = (1,)) -> ModalModel:
        """Exact, of all modes, with a sensor at every mass; points count from 1."""
        square, phi = linalg.eigh(self.stiffness, self.mass)
        omega = np.sqrt(square)
        zeta = np.einsum("or,op,pr->r", phi, self.damping, phi) / (2 * omega)
        n, into = len(omega), [p - 1 for p in driven]
        constants = np.einsum("or,ir->roi", phi, phi[into]).astype(np.complex128)
        return ModalModel(
            method="exact",
            band_hz=(0.1, float(2 * omega[-1] / (2 * np.pi))),
            frequency_hz=omega / (2 * np.pi),
            damping_ratio=zeta,
            frequency_sigma_hz=np.zeros(n),
            damping_sigma=np.zeros(n),
            outputs=tuple(f"a{p + 1}" for p in range(n)),
            output_points=tuple(range(1, n + 1)),
            input_points=driven,
            modal_constants=constants,
            modal_constant_sigma=np.zeros(constants.shape),
            residuals=np.zeros((0, n, len(driven))),
            half_power=np.full(n, np.nan),
            half_power_floor=np.full(n, np.nan),
        )

    def receptance(self, s: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """(lines, outputs, inputs)."""
        z = s[:, None, None]
        return np.linalg.inv(z**2 * self.mass + z * self.damping + self.stiffness)


BARE = Chain.of([1.0, 2.0, 1.5, 0.8], [4e4, 3e4, 5e4, 2e4, 1e4])
OTHER = Chain.of([0.7, 1.1], [2e4, 1e4, 0.0])
