"""What a test says of the parameters of a model."""

from dataclasses import dataclass, replace
from math import isfinite

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.core.errors import DataError
from modallab.core.rig import Tolerance
from modallab.modification.known import KnownStructure
from modallab.modification.samples import sample_structures


@dataclass(frozen=True, slots=True)
class Prior:
    """A normal distribution, or a log-normal one for a positive parameter.

    Attributes:
        value: most probable, in SI units.
        sigma: one standard deviation; of `relative` ones that of the logarithm, 0.05 for 5 %.
        relative: whether the parameter is positive with a relative deviation.
        unit: in words.
    """

    value: float
    sigma: float
    relative: bool = False
    unit: str = ""

    def __post_init__(self) -> None:
        """Reject what is no distribution."""
        if not (isfinite(self.value) and isfinite(self.sigma) and self.sigma > 0):
            raise DataError(
                f"a prior of {self.value:g} with deviation {self.sigma:g} is none",
                remedy="give a finite value and a deviation above 0",
            )
        if self.relative and self.value <= 0:
            raise DataError(
                f"a relative deviation about {self.value:g} is none", remedy="give a value above 0, or an absolute one"
            )

    def at(self, u: float | Real) -> Real:
        """Values at u standard deviations from the most probable one."""
        off = self.sigma * np.asarray(u, np.float64)
        return np.asarray(self.value * np.exp(off) if self.relative else self.value + off)


DETERMINED = 0.5
"""Of the prior's deviation: where more of it is left, the data have said little of a parameter."""
TOGETHER = 0.9
"""Correlation from which two parameters are known together, and neither alone."""


@dataclass(frozen=True, eq=False, slots=True)
class ModeCheck:
    """Predicted modes beside the measured ones.

    Attributes:
        frequency_hz: (modes,) of the pair of each measured mode.
        mac: (modes,) of the two.
    """

    frequency_hz: Real
    mac: Real


@dataclass(frozen=True, eq=False, slots=True)
class UpdatedParameters:
    """Parameters estimated from measured modes.

    Attributes:
        priors: parameter -> what was believed of it.
        numbers: parameter -> the most probable value.
        interval: parameter -> 95 % interval.
        narrowed: (parameters,) deviation that is left, over that of the prior.
        correlation: (parameters, parameters) of what is left.
        off: what the model's frequencies and shapes are off by with the best numbers, relative.
        measured_hz: (modes,).
        measured_sigma_hz: (modes,).
        before: with what was believed.
        after: with the estimate.
        held_out: modes, from 1, that the estimate did not see.
    """

    priors: dict[str, Prior]
    numbers: dict[str, float]
    interval: dict[str, tuple[float, ...]]
    narrowed: Real
    correlation: Real
    off: tuple[float, float]
    measured_hz: Real
    measured_sigma_hz: Real
    before: ModeCheck
    after: ModeCheck
    held_out: tuple[int, ...]

    @property
    def undetermined_parameters(self) -> tuple[str, ...]:
        """Parameters of which most of what is left open was open before."""
        return tuple(n for n, left in zip(self.numbers, self.narrowed, strict=True) if left > DETERMINED)

    @property
    def correlated_pairs(self) -> tuple[tuple[str, str], ...]:
        """Pairs of parameters that only a combination is known of."""
        names, size = list(self.numbers), np.abs(self.correlation)
        return tuple((names[i], names[j]) for i in range(len(names)) for j in range(i) if size[i, j] > TOGETHER)

    @property
    def errors(self) -> tuple[Real, Real]:
        """(modes,) relative error of each frequency before and after."""
        return self.before.frequency_hz / self.measured_hz - 1, self.after.frequency_hz / self.measured_hz - 1

    def rms_error(self, modes: tuple[int, ...]) -> tuple[float, float]:
        """Root mean square of the errors of some modes, from 1, before and after."""
        chosen = [r - 1 for r in modes]
        before, after = (float(np.sqrt(np.mean(e[chosen] ** 2))) for e in self.errors)
        return before, after


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
    many = sample_structures(known.model, known.rig, count)
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
