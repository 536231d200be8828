"""The periodic motion of the simulated beam with a cubic spring, by harmonic balance instead of by steps in time.

The beam is linear but for the spring, so that its displacement at the spring is U = H_s F + H_ss G, with G the spectrum
of the spring's force -k3 u^3. Both spectra have lines at multiples of one period alone; the products of lines are made
on a fine grid of times. Nothing of a record is used but the force that was played: no noise, no decay, no converter.
Source: Krack and Gross, "Harmonic Balance for Nonlinear Vibration Problems" (2019), section 2.4, alternating frequency
and time.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import circulant

from modallab.core.rig import Rig
from modallab_simulators.cantilever.address import parse_address
from modallab_simulators.cantilever.basis import Basis
from modallab_simulators.cantilever.truth import draw_truth

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

STEPS = 8
CLOSE = 1e-9
FIRST_SHARE = 0.02
LEAST_SHARE = 1e-4
"""Of the spring, by which it is made stiffer from motion to motion: a step that fails is made smaller."""


@dataclass(frozen=True)
class Balance:
    """The linear beam at multiples of one frequency, and the spring.

    Attributes:
        from_force: (lines,) displacement at the spring per force of the shaker, lines from 0.
        from_spring: (lines,) the same per force of the spring.
        to_sensors: (2, outputs, lines) acceleration at the sensors per force of the shaker, and of the spring.
        k3: N/m^3.
    """

    from_force: Complex
    from_spring: Complex
    to_sensors: Complex
    k3: float

    @classmethod
    def beam_candidates(cls, url: str, rig: Rig, line_hz: float, count: int, x_m: float, k3: float) -> "Balance":
        """A bench at its address; its own effects are left out."""
        assert rig.shaker_point is not None
        basis = draw_truth(parse_address(url), rig).basis(2000.0, "pseudo-random", 0.0, 4)
        omega = 2 * np.pi * line_hz * np.arange(count)
        drive, sensors = rig.x_of(rig.shaker_point), np.array([rig.x_of(c.point or 0) for c in rig.responses])
        both = np.stack([-(omega**2) * receptance(basis, sensors, at, omega) for at in (drive, x_m)])
        here = np.array([x_m])
        return cls(receptance(basis, here, drive, omega)[0], receptance(basis, here, x_m, omega)[0], both, k3)

    def accelerations(self, force: Complex, about: Complex) -> Complex:
        """(outputs, lines) from a force (lines,), both as spectra of one period, scaled as numpy's rfft is.

        Of several periodic motions that one force may have, it is the one near `about`, if there is one: beyond some
        force the symmetric motion is no longer the one that the beam takes.

        Args:
            force: what was played.
            about: (lines,) displacement at the spring with which the search begins.

        Raises:
            ArithmeticError: no periodic motion is found: the spring is too stiff for it.
        """
        linear = np.fft.irfft(self.from_force * force)
        answer = circulant(np.fft.irfft(self.from_spring))
        try:
            u = balanced(np.fft.irfft(about), linear, answer, self.k3)
        except ArithmeticError:
            u = self._from_linear(linear, answer)
        spring = -np.fft.rfft(self.k3 * u**3)
        return self.to_sensors[0] * force + self.to_sensors[1] * spring

    def _from_linear(self, linear: Real, answer: Real) -> Real:
        """The motion that the linear beam's turns into when the spring is made stiffer little by little."""
        u, k3, step = linear, 0.0, FIRST_SHARE * self.k3
        while k3 < self.k3:
            try:
                u, k3, step = balanced(u, linear, answer, k3 + step), k3 + step, min(2 * step, self.k3 - k3 - step)
            except ArithmeticError:
                step /= 4
                if step < LEAST_SHARE * self.k3:
                    raise
        return u


def balanced(u: Real, linear: Real, answer: Real, k3: float) -> Real:
    """The wave u (n,) of u + answer (k3 u^3) = linear, by Newton.

    Raises:
        ArithmeticError: it does not come near.
    """
    left = u + answer @ (k3 * u**3) - linear
    for _ in range(STEPS):
        u = u - np.linalg.solve(np.eye(u.size) + answer * (3 * k3 * u**2), left)
        left = u + answer @ (k3 * u**3) - linear
        if np.linalg.norm(left) < CLOSE * np.linalg.norm(linear):
            return u
    raise ArithmeticError(f"no periodic motion was found in {STEPS} steps at {k3:.3g} N/m^3")


def receptance(basis: Basis, at_m: Real, force_m: float, omega: Real) -> Complex:
    """(points, lines) displacement per force, with what the modes beyond add."""
    constants = basis.shapes(at_m) * basis.shapes(np.array([force_m]))[0] / basis.scale
    poles, s = basis.poles, 1j * omega[:, None]
    one = [((c / (s - poles) - c.conj() / (s - poles.conj())) / 2j).sum(axis=1) for c in constants.astype(complex)]
    return np.stack(one) + basis.remainder(at_m, force_m)[:, None]
