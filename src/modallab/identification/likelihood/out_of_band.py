"""Modes outside the band: powers of s stand for them, and a few poles for those right above it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

RESIDUAL_POWERS = (-2, 0, 2, 4)
"""Powers of s for what modes outside the band leave. -2 in a receptance is an acceleration like the force itself, as
modes below the band leave it. So do, a little, far modes that are sampled too slowly, and cross-talk. Left out, it
passes for damping of the lowest mode."""
STAND_INS = (1.05,)
"""A pole that begins at this multiple of the upper edge stands for the modes above."""
STAND_IN_SHARE = 0.4
"""The stand-ins are damped as the band's own modes are, give or take this share. The band's lines hardly say: left to
them a damping ratio runs to zero, where a pole rings through the whole block. But it turns the phase of all that lies
below, so that a wrong one that is held too fast makes the upper modes' constants wrong."""


@dataclass(frozen=True, eq=False, slots=True)
class StartPoles:
    """Where a search begins.

    Attributes:
        omega: (poles,) rad/s; the last `stand_ins` stand for modes above the band.
        zeta: (poles,)
        zeta_prior: (poles, 2) centre and sigma.
        stand_ins: how many.
    """

    omega: NDArray[np.float64]
    zeta: NDArray[np.float64]
    zeta_prior: NDArray[np.float64]
    stand_ins: int


def with_stand_ins(
    poles: NDArray[np.complex128], top_hz: float, multiples: tuple[float, ...], zeta_range: tuple[float, float]
) -> StartPoles:
    """Start poles, with stand-ins for the modes above the band appended.

    A power series in s converges slowly for a mode just above the band; a pole there, free to move, does better.

    Args:
        poles: (modes,) rad/s.
        top_hz: upper edge of the band.
        multiples: of the upper edge, where the stand-ins begin.
        zeta_range: damping ratios of the start poles are brought into this range.
    """
    omega = np.concatenate([np.abs(poles), 2 * np.pi * top_hz * np.array(multiples)])
    low, high = zeta_range
    zeta = np.clip(-poles.real / np.abs(poles), low, high)
    like_them = float(np.median(zeta))
    prior = np.tile([0.0, np.inf], (omega.size, 1))
    prior[poles.size :] = like_them, STAND_IN_SHARE * like_them
    zeta = np.append(zeta, np.full(len(multiples), like_them))
    return StartPoles(omega, zeta, prior, len(multiples))


def edges_of_stand_ins(omega: NDArray[np.float64], top_hz: float) -> tuple[float, ...]:
    """Multiples of the upper edge at which stand-ins begin again: where a fit has moved them to, if that is above.

    Args:
        omega: (poles,) rad/s of the fit, its stand-in last.
        top_hz: upper edge of the band.
    """
    moved = float(omega[-1]) / (2 * np.pi * top_hz)
    return STAND_INS if moved < 1 else (moved,)
