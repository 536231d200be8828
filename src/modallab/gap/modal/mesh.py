"""Shapes at the nodes of a computed model: between the points of a rig they are known, not interpolated from them."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]

MOST = 400
"""Nodes that shapes are taken along from: n of them cost n^3, and modes of a band are smooth."""


@dataclass(frozen=True, eq=False, slots=True)
class Mesh:
    """Where a model has nodes, and how they move.

    Attributes:
        places_m: (nodes, 3), in the coordinates of the rig.
        motion: axis -> (nodes, modes) at unit modal mass, kg^-1/2; positive along the axis, or along the drive where it
            is its axis. Of the modes of the modal model, in their order and with one sign each for all axes.
    """

    places_m: Real
    motion: Mapping[str, Real]

    def about(self, points_m: Real) -> "Mesh":
        """The same at the nodes that tell most about the surroundings of the points (points, 3); at most so many.

        Those next to the points come first, then one after the other the one farthest from all that were taken.
        """
        near = _next_to(self.places_m, points_m)
        away = np.linalg.norm(self.places_m[:, None] - self.places_m[near][None], axis=2).min(axis=1)
        reach = 2 * _apart(points_m)
        within = np.linalg.norm(self.places_m[:, None] - points_m[None], axis=2).min(axis=1) <= reach
        away[~within] = 0.0
        taken = list(near)
        while len(taken) < MOST and away.max() > 0:
            farthest = int(np.argmax(away))
            taken.append(farthest)
            away = np.minimum(away, np.linalg.norm(self.places_m - self.places_m[farthest], axis=1))
        return Mesh(self.places_m[taken], {axis: values[taken] for axis, values in self.motion.items()})


def _next_to(places_m: Real, points_m: Real) -> list[int]:
    away = np.linalg.norm(points_m[:, None] - places_m[None], axis=2)
    return list(dict.fromkeys(np.argmin(away, axis=1).tolist()))


def _apart(points_m: Real) -> float:
    """Median distance from a point to the nearest other, m."""
    places = np.unique(points_m, axis=0)
    away = np.linalg.norm(places[:, None] - places[None], axis=2)
    np.fill_diagonal(away, np.inf)
    return float(np.median(away.min(axis=1)))
