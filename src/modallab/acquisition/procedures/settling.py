"""Whether a sine block has settled: the forced sine and the free decays of the known modes, fitted together.

A gate on amplitude and phase is fooled by beats. Here all motion channels are fitted by least squares with
x(t) = c + Re(A exp(j omega t)) + sum_r Re(B_r exp(s_r t)), s_r the poles of the modes that are known, t from the
block's first sample; the stretch that is fitted may begin before it. The decay beside the response is |B| / |A|.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.core.plan import KnownMode
from modallab.signals.tone_fit import fit_at, frequency_of_sine

Settled = Literal["yes", "no", "unknown"]


@dataclass(frozen=True, eq=False, slots=True)
class SettlingFit:
    """What a fit says.

    Attributes:
        frequency_hz: of the drive, on the converter's clock.
        ratio: (modes,) amplitude of each mode's decay at the block's start over that of the response, both as the root
            of the sum of squares over channels, with what noise adds taken off.
        sigma: (modes,) of it.
        zeta_omega: (modes,) decay rates in 1/s.
        mode_hz: (modes,)
    """

    frequency_hz: float
    ratio: Real
    sigma: Real
    zeta_omega: Real
    mode_hz: Real

    @property
    def total_decay(self) -> float:
        """All decays over the response."""
        return float(np.linalg.norm(self.ratio))

    def verdict(self, limit: float) -> Settled:
        """Whether the decays are below `limit`; unknown where the fit cannot decide it."""
        spread = float(np.linalg.norm(self.sigma))
        if self.total_decay - 2 * spread > limit:
            return "no"
        return "yes" if self.total_decay <= limit and spread <= limit else "unknown"

    def further_wait_s(self, limit: float) -> float:
        """How much longer to wait until every decay is below its share of `limit`."""
        share = limit / np.sqrt(len(self.ratio))
        return float(max(0.0, (np.log(np.maximum(self.ratio, 1e-12) / share) / self.zeta_omega).max()))

    def facts(self, limit: float) -> dict[str, float | str]:
        """For the catalogue."""
        worst = int(np.argmax(self.ratio))
        return {
            "settled": self.verdict(limit),
            "decay_ratio": self.total_decay,
            "decay_sigma": float(np.linalg.norm(self.sigma)),
            "decay_mode_hz": float(self.mode_hz[worst]),
        }


def fit_settling(
    force: Real, motion: Real, rate_hz: float, before: int, drive_hz: float, modes: Sequence[KnownMode]
) -> SettlingFit | None:
    """Fit a stretch of a burst's settled part.

    Args:
        force: (n,) any unit.
        motion: (channels, n) in units that may be summed.
        rate_hz: of both.
        before: samples of the stretch before the block's first.
        drive_hz: what the generator was set to.
        modes: known ones.

    Returns:
        None where no mode can be looked for: none is known below half the rate, or nothing moves.
    """
    seen = [mode for mode in modes if mode.frequency_hz < rate_hz / 2]
    if not seen or motion.shape[0] == 0:
        return None
    t = (np.arange(force.size) - before) / rate_hz
    frequency = frequency_of_sine(force, rate_hz, drive_hz)
    omega = 2 * np.pi * np.array([mode.frequency_hz for mode in seen])
    zeta = np.array([mode.damping_ratio for mode in seen])
    poles = -zeta * omega + 1j * omega * np.sqrt(1 - zeta**2)
    waves: NDArray[np.complex128] = np.exp(np.outer(np.concatenate([[2j * np.pi * frequency], poles]), t))
    basis = np.vstack([np.ones_like(t), waves.real, -waves.imag]).T
    q, r = np.linalg.qr(basis)
    coefficients = np.linalg.solve(r, q.T @ motion.T)
    residual = motion.T - basis @ coefficients
    variance = (residual**2).sum(axis=0) / max(1, t.size - basis.shape[1])
    spread = np.diag(np.linalg.inv(r.T @ r))
    count = len(seen) + 1
    power = (coefficients[1 : count + 1] ** 2 + coefficients[count + 1 :] ** 2).sum(axis=1)
    noise = (spread[1 : count + 1] + spread[count + 1 :]) * variance.sum()
    response = power[0]
    if response <= 0:
        return None
    return SettlingFit(
        frequency_hz=frequency,
        ratio=np.sqrt(np.maximum(power[1:] - noise[1:], 0) / response),
        sigma=np.sqrt(noise[1:] / response),
        zeta_omega=zeta * omega,
        mode_hz=omega / (2 * np.pi),
    )


def amplitude_at(values: Real, rate_hz: float, drive_hz: float) -> float:
    """Peak amplitude of the sine in (n,) values, at its own frequency near `drive_hz`."""
    fit = fit_at(values[None], rate_hz, frequency_of_sine(values, rate_hz, drive_hz))
    return float(np.abs(fit.amplitude[0]))
