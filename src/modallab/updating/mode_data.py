"""What a test says of modes: frequencies and shapes with their covariance."""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.core.rig import Tolerance
from modallab.modification.known import KnownStructure
from modallab.modification.samples import samples_of

PER_NUMBER = 4
"""Samples for each number, whose covariance is estimated from them."""
FEWEST = 400


@dataclass(frozen=True, eq=False, slots=True)
class ModeData:
    """Measured modes as one vector: all frequencies over their value, then all shapes.

    Attributes:
        frequency_hz: (modes,).
        frequency_sigma_hz: (modes,).
        shapes: (modes, freedoms) real, at unit modal mass, kg^-1/2.
        covariance: (numbers, numbers) of logarithms of frequencies and of shapes over `size`.
        uneven: by how much frequencies of an even model are off, relative: no structure is even, as its rig states.
    """

    frequency_hz: Real
    frequency_sigma_hz: Real
    shapes: Real
    covariance: Real
    uneven: float = 0.0

    @property
    def size(self) -> Real:
        """(modes, 1) root mean square of each shape over the freedoms."""
        return np.sqrt(np.mean(self.shapes**2, axis=1, keepdims=True))

    @property
    def modes(self) -> int:
        """How many there are."""
        return self.frequency_hz.size

    def of_modes(self, modes: list[int]) -> "ModeData":
        """Some of the modes."""
        points = self.shapes.shape[1]
        rows = [*modes, *(self.modes + r * points + k for r in modes for k in range(points))]
        return replace(
            self,
            frequency_hz=self.frequency_hz[modes],
            frequency_sigma_hz=self.frequency_sigma_hz[modes],
            shapes=self.shapes[modes],
            covariance=self.covariance[np.ix_(rows, rows)],
        )

    def misfit(self, frequency_hz: Real, shapes: Real) -> Real:
        """(numbers,) predicted less measured of modes that are paired and have the sign of the measured ones."""
        off = (shapes - self.shapes) / self.size
        return np.concatenate([np.log(frequency_hz / self.frequency_hz), off.ravel()])


def measured_modes(known: KnownStructure) -> ModeData:
    """The modes of a measured model, with the covariance that its noise and its rig's tolerances give."""
    structure = known.structure
    hz, shapes = _real_modes(structure.poles[None], structure.psi[None])
    size = np.sqrt(np.mean(shapes[0] ** 2, axis=1, keepdims=True))
    count = max(FEWEST, PER_NUMBER * (hz.size + shapes.size))
    many = samples_of(known.model, known.rig, count)
    sampled_hz, sampled = _real_modes(many.poles, many.psi)
    sign = np.sign(np.sum(sampled * shapes, axis=2, keepdims=True))
    off = np.concatenate([np.log(sampled_hz / hz), ((sign * sampled - shapes) / size).reshape(count, -1)], axis=1)
    # A covariance of few samples has an inverse that is too large (Hartlap, Simon and Schneider, A&A 464, 2007, 399).
    covariance = off.T @ off / (count - off.shape[1] - 2)
    sigma = hz[0] * np.sqrt(np.diag(covariance))[: hz.size]
    tolerance = Tolerance() if known.rig is None else known.rig.tolerance
    # A frequency goes with the square root of stiffness over mass.
    uneven = np.hypot(tolerance.stiffness_field, tolerance.mass_field) / 2
    return ModeData(hz[0], sigma, shapes[0], covariance, float(uneven))


def _real_modes(poles: Complex, psi: Complex) -> tuple[Real, Real]:
    """(..., modes) undamped Hz and (..., modes, freedoms) shapes without the phase that damping gives them."""
    phi = psi * np.sqrt(2j * poles.imag)[..., None]
    phase = np.sqrt(np.sum(phi**2, axis=-1, keepdims=True))
    return np.abs(poles) / (2 * np.pi), np.real(phi * np.abs(phase) / phase)
