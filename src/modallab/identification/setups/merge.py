"""Poles of many points merged into modes: near in frequency, alike in what they do at the common channels.

A pole that only a few points find, or whose signature nobody shares, fits noise or the disagreement of other set-ups.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.identification.setups.roving import ModesOfPoint

WIDEST = 8e-3
"""Relative distance of two points' frequencies of one mode at most: four times the largest scatter of set-ups."""
NARROWEST = 3e-4
REACH = 5.0
"""Scatters within which a pole belongs to a mode, once the scatter is known."""
LIKE = 0.85
"""MAC of two signatures of one mode."""
LEAST_POINTS = 4
LEAST_SHARE = 0.25
"""Of the points that were asked, which must find a mode by themselves."""


@dataclass(frozen=True, eq=False, slots=True)
class MergedModes:
    """Modes that points agree on.

    Attributes:
        centre: (modes, 2) median omega in rad/s and zeta.
        spread: (modes, 2) robust standard deviation of the points' about it.
        share: (modes,) of the points that were asked, which found it.
    """

    centre: Real
    spread: Real
    share: Real


def merge_modes(seen: ModesOfPoint, asked: int) -> MergedModes:
    """The modes, by rising frequency.

    Args:
        seen: what each point found alone.
        asked: how many points were.
    """
    likeness = np.abs(seen.signature.conj() @ seen.signature.T) ** 2
    groups = _group_modes(seen, likeness, np.full(seen.pole.size, WIDEST), asked)
    if groups:
        scatter = float(
            np.median([_spread_of_values(np.abs(seen.pole[g]))[1] / np.median(np.abs(seen.pole[g])) for g in groups])
        )
        reach = float(np.clip(REACH * scatter, NARROWEST, WIDEST))
        groups = _group_modes(seen, likeness, np.full(seen.pole.size, reach), asked)
    rows = []
    for g in groups:
        size = np.abs(seen.pole[g])
        omega, zeta = _spread_of_values(size), _spread_of_values(-seen.pole[g].real / size)
        rows.append((omega[0], zeta[0], omega[1], zeta[1], len(g) / asked))
    table = np.array(sorted(rows)).reshape(-1, 5)
    return MergedModes(table[:, :2], table[:, 2:4], table[:, 4])


def _spread_of_values(values: Real) -> tuple[float, float]:
    middle = float(np.median(values))
    return middle, 1.4826 * float(np.median(np.abs(values - middle)))


def _group_modes(seen: ModesOfPoint, likeness: Real, reach: Real, asked: int) -> list[NDArray[np.int64]]:
    """Members of each mode, one a point; the mode that most points see comes first."""
    size = np.abs(seen.pole)
    near = (np.abs(size[:, None] / size - 1) < reach) & (likeness > LIKE)
    free = np.ones(size.size, bool)
    least = max(LEAST_POINTS, LEAST_SHARE * asked)
    found: list[NDArray[np.int64]] = []
    while True:
        support = _supporting_points(near & free & free[:, None], seen.point)
        if not support.size or support.max() < least:
            return found
        best = np.flatnonzero(support == support.max())
        # Of seeds that as many points share, the one in their middle.
        inner = near[best] & free
        around = [float(np.median(np.abs(size[row] / size[b] - 1))) for row, b in zip(inner, best, strict=True)]
        seed = int(best[int(np.argmin(around))])
        members = np.flatnonzero(near[seed] & free)
        centre = float(np.median(size[members]))
        members = np.flatnonzero((np.abs(size / centre - 1) < reach[seed]) & (likeness[seed] > LIKE) & free)
        found.append(_one_a_point(members, seen.point, np.abs(size / centre - 1)))
        free[members] = False


def _supporting_points(near: NDArray[np.bool_], point: NDArray[np.int64]) -> NDArray[np.int64]:
    """(seen,) how many points hold a neighbour."""
    which, place = np.unique(point, return_inverse=True)
    count = np.zeros((len(point), which.size), bool)
    np.logical_or.at(count.T, place, near.T)
    return count.sum(axis=1)


def _one_a_point(members: NDArray[np.int64], point: NDArray[np.int64], distance: Real) -> NDArray[np.int64]:
    ordered = members[np.argsort(distance[members], kind="stable")]
    _, first = np.unique(point[ordered], return_index=True)
    return ordered[np.sort(first)]
