"""The FRFs of the hits that count, point by point, and how far those of a new hit are from them.

A point that was not struck yet is known in part, where a sensor stands at it: by reciprocity what that sensor read of
hits at another point is what a sensor at that point would read of hits here.
"""

from dataclasses import dataclass, field

import numpy as np

from modallab.core.arrays import Complex128, Real


@dataclass(frozen=True, eq=False, slots=True)
class FrfsSoFar:
    """FRFs of one test.

    Attributes:
        sensed_at: (sensors,) point of each row, 0 where it has none.
        alike: (sensors,) rows of the same quantity have the same number; reciprocity holds among these only.
        of_hit: (sensors, lines) by the name of the hit's record.
        point_of: point of each hit, by the same name.
    """

    sensed_at: tuple[int, ...]
    alike: tuple[int, ...]
    of_hit: dict[str, Complex128] = field(default_factory=dict[str, Complex128])
    point_of: dict[str, int] = field(default_factory=dict[str, int])

    def keep(self, name: str, point: int, frf: Complex128) -> None:
        """A hit counts."""
        self.of_hit[name], self.point_of[name] = frf, point

    def forget(self, name: str) -> None:
        """It counts no longer."""
        self.of_hit.pop(name, None)
        self.point_of.pop(name, None)

    def hits_at(self, point: int) -> int:
        """How many count at a point."""
        return sum(p == point for p in self.point_of.values())

    def distances(self, frf: Complex128) -> dict[int, float]:
        """How far an FRF (sensors, lines) is from that of each known point: 0 is the same, 1 has nothing in common.

        Lines count alike, so that no resonance alone decides.
        """
        struck = {point: self._mean(point) for point in sorted(set(self.point_of.values()))}
        if not struck:
            return {}
        weight = _weight_of_lines(list(struck.values()))
        found = {point: _frf_distance(frf, known, weight) for point, known in struck.items()}
        for point in set(self.sensed_at) - set(struck) - {0}:
            partial = self._by_reciprocity(point, struck)
            if partial:
                rows = list(partial)
                found[point] = _frf_distance(frf[rows], np.array(list(partial.values())), weight)
        return found

    def scale(self, frf: Complex128, point: int) -> float:
        """How many times as much as after the hits at a point the structure moved a newton; NaN if there are none."""
        if not self.hits_at(point):
            return float("nan")
        known = self._mean(point)
        weight = _weight_of_lines([known])
        return float(np.sum(weight * np.real(frf * known.conj())) / np.sum(weight * np.abs(known) ** 2))

    def _mean(self, point: int) -> Complex128:
        return np.mean([self.of_hit[name] for name, at in self.point_of.items() if at == point], axis=0)

    def _by_reciprocity(self, point: int, struck: dict[int, Complex128]) -> dict[int, Complex128]:
        """Rows of a hit at `point`, which has a sensor, that hits elsewhere have shown."""
        here = self.sensed_at.index(point)
        return {
            row: struck[at][here]
            for row, at in enumerate(self.sensed_at)
            if at in struck and self.alike[row] == self.alike[here]
        }


def _weight_of_lines(known: list[Complex128]) -> Real:
    power = np.mean([np.sum(np.abs(one) ** 2, axis=0) for one in known], axis=0)
    return 1 / np.maximum(power, 1e-12 * power.max())


def _frf_distance(one: Complex128, other: Complex128, weight: Real) -> float:
    difference = np.sum(weight * np.abs(one - other) ** 2)
    total = np.sum(weight * (np.abs(one) ** 2 + np.abs(other) ** 2))
    return float(np.sqrt(difference / total)) if total else 0.0
