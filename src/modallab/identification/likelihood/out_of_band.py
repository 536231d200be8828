"""Modes above the band: a few poles stand in for all of them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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
