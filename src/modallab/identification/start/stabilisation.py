"""Stabilisation: poles that stay where they are as the order rises belong to the structure."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False, slots=True)
class OrderPoles:
    """What one polynomial order found: poles (n,) in rad/s with positive imaginary part, by rising frequency."""

    order: int
    poles: NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class StabilityLimits:
    """When a pole counts as the same at the next order: distance |d lambda| as a share of |lambda|."""

    frequency: float = 2e-3
    damping: float = 4e-3
    max_zeta: float = 0.1
    min_zeta: float = -2e-3
    min_run: int = 5
    min_share: float = 0.25

    def plausible(self, poles: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Those that a structure may have, by their damping."""
        zeta = -poles.real / np.abs(poles)
        return poles[(zeta > self.min_zeta) & (zeta < self.max_zeta)]


@dataclass(frozen=True, eq=False, slots=True)
class StablePole:
    """A pole found again at rising orders.

    Attributes:
        pole: rad/s, the median of the run.
        run: how many orders in a row held it.
        spread: median absolute deviation of the run's poles, as a share of |pole|.
    """

    pole: complex
    run: int
    spread: float


def stable_poles(orders: Sequence[OrderPoles], tolerance: StabilityLimits | None = None) -> list[StablePole]:
    """Poles that hold over enough orders in a row, each once, by rising frequency.

    Enough is `min_run`, and `min_share` of all the orders: noise holds for some orders by chance, the more the more
    orders there are.

    Args:
        orders: poles by rising order.
        tolerance: when two poles are the same.
    """
    limits = tolerance or StabilityLimits()
    open_runs: list[list[complex]] = []
    closed: list[list[complex]] = []
    for found in orders:
        poles = limits.plausible(found.poles)
        free = np.ones(poles.size, dtype=np.bool_)
        continued: list[list[complex]] = []
        for run in sorted(open_runs, key=len, reverse=True):
            match = _nearest_pole(run[-1], poles, free, limits)
            if match is None:
                closed.append(run)
            else:
                free[match] = False
                continued.append([*run, complex(poles[match])])
        open_runs = continued + [[complex(pole)] for pole in poles[free]]
    closed += open_runs
    enough = max(limits.min_run, int(limits.min_share * len(orders)))
    return _distinct_runs([_stable_pole(run) for run in closed if len(run) >= enough], limits)


def _nearest_pole(
    pole: complex, candidates: NDArray[np.complex128], free: NDArray[np.bool_], limits: StabilityLimits
) -> int | None:
    off = candidates - pole
    same = (np.abs(off.imag) < limits.frequency * abs(pole)) & (np.abs(off.real) < limits.damping * abs(pole))
    near = np.flatnonzero(same & free)
    return int(near[np.argmin(np.abs(off[near]))]) if near.size else None


def _stable_pole(run: list[complex]) -> StablePole:
    tail: NDArray[np.complex128] = np.array(run[-max(5, len(run) // 2) :], dtype=np.complex128)
    centre = complex(np.median(tail.real), np.median(tail.imag))
    return StablePole(centre, len(run), float(np.median(np.abs(tail - centre)) / abs(centre)))


def _distinct_runs(poles: list[StablePole], limits: StabilityLimits) -> list[StablePole]:
    """Longest runs first; a shorter run beside one already taken is its double."""
    taken: list[StablePole] = []
    for candidate in sorted(poles, key=lambda p: p.run, reverse=True):
        if all(abs(candidate.pole - other.pole) > limits.frequency * abs(other.pole) for other in taken):
            taken.append(candidate)
    return sorted(taken, key=lambda p: p.pole.imag)
