"""Whether a hit has struck the point that was requested: compared with the hits before and the expected modes.

A point that was not struck yet is known in part, where a sensor stands at it: by reciprocity what that sensor read of
hits at another point is what a sensor at that point would read of hits here.
"""

from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import NDArray

from modallab.acquisition.procedures.struck_point.participation import ExpectedModes, HitResponse, participation
from modallab.core.arrays import Complex128, Real
from modallab.core.rig import Rig
from modallab.signals.conversion import Conversion


@dataclass(frozen=True, eq=False, slots=True)
class AccumulatedFrfs:
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

    def add_hit(self, name: str, point: int, frf: Complex128) -> None:
        """A hit counts."""
        self.of_hit[name], self.point_of[name] = frf, point

    def remove_hit(self, name: str) -> None:
        """It counts no longer."""
        self.of_hit.pop(name, None)
        self.point_of.pop(name, None)

    def hits_at(self, point: int) -> int:
        """How many count at a point."""
        return sum(p == point for p in self.point_of.values())

    def distances_to_points(self, frf: Complex128) -> dict[int, float]:
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


NEARER = 0.6
"""Another point must be nearer than the requested one by this factor before a hit is said to be there."""
FAR_BY_MODES = 0.12
"""Distance in shape, as part of each mode's largest, that a hit at the right point does not reach: 0.05 for 2 mm and
1 %. Neighbouring points of a cantilever with ten are 0.2 to 0.5 apart."""
FAR_BY_FRFS = 0.12
"""Distance of FRFs that hits at one point do not reach among each other: 0.06 for 2 mm and 1 %."""
FEWEST_MODES = 3
OFF_SCALE = 0.2
"""A hit that moved the beam by so much more or less than those before at this point was oblique, or the hammer's
reading is wrong: the cosine of 37 degrees."""

SCATTER = 0.05
"""Hits at other points say something of a new point only if the model fits them alike, to this part."""

NEAR = 1.5
"""A hit is said to be at another point only if it is within this factor of `FAR_...` of it: where a sensor is turned or
the beam is another than believed it is near to none, and nothing follows."""


@dataclass(frozen=True, slots=True)
class HitLocation:
    """What one hit says of where it landed.

    Attributes:
        nearest_point: the point it is nearest to; 0 if nothing is known.
        distance: from what is known of the requested point, 0 for the same; NaN if nothing is.
        scale: motion a newton over what is known of the requested point; NaN if nothing is.
        reasons: why it is rejected; empty if it may count.
    """

    nearest_point: int = 0
    distance: float = float("nan")
    scale: float = float("nan")
    reasons: tuple[str, ...] = ()

    def facts(self) -> dict[str, float]:
        """For the catalogue."""
        found = {
            "looks_like_point": float(self.nearest_point),
            "point_distance": self.distance,
            "hit_scale": self.scale,
        }
        return {name: value for name, value in found.items() if value and not np.isnan(value)}


@dataclass(frozen=True, eq=False, slots=True)
class _Look:
    frf: NDArray[np.complex128]
    modes: NDArray[np.int64]
    shape: Real


@dataclass(frozen=True, eq=False, slots=True)
class StruckPointCheck:
    """Knows what the hits so far were like.

    Attributes:
        frfs: of the hits that count.
        channels: rows of the motion channels.
        up_to_hz: band in which FRFs are compared.
        expected: the modes that are believed; None without a model.
        shapes: shapes found where hits landed, (modes,) with NaN where not excited, by name of the record.
        looks: hits that were looked at since the last that counts, by the name they have if rejected.
    """

    frfs: AccumulatedFrfs
    channels: tuple[int, ...]
    up_to_hz: float
    expected: ExpectedModes | None
    shapes: dict[str, Real] = field(default_factory=dict[str, Real])
    looks: dict[str, _Look] = field(default_factory=dict[str, _Look])

    @classmethod
    def of(cls, rig: Rig, conversion: Conversion, up_to_hz: float, expected: ExpectedModes | None) -> Self:
        """Nothing was struck yet."""
        sensors = [rig.channels[i] for i in conversion.motion]
        kinds = sorted({c.quantity for c in sensors})
        alike = tuple(kinds.index(c.quantity) for c in sensors)
        return cls(AccumulatedFrfs(tuple(c.point or 0 for c in sensors), alike), conversion.motion, up_to_hz, expected)

    @property
    def checked_rows(self) -> tuple[int, ...]:
        """Places in the rig of the channels that are looked at."""
        return tuple(sorted({*self.channels, *(self.expected.channels if self.expected is not None else ())}))

    def check_hit(self, name: str, point: int, answer: HitResponse) -> HitLocation:
        """Hold a hit against all that is known; `name` is that of its record should it be rejected."""
        look = self._measure(answer)
        self.looks[name] = look
        by_modes = self._by_modes(point, look)
        if by_modes is None or not self.frfs.hits_at(point):
            return by_modes or self._by_frfs(point, look)
        # Measured against measured: what is wrong with the bench is in both. The model may know more points by name.
        by_frfs = self._by_frfs(point, look)
        return by_modes if by_frfs.reasons and by_modes.nearest_point != point else by_frfs

    def keep_hit(self, looked_at: str, name: str, point: int) -> None:
        """The hit that was looked at under one name counts, at this point, and its record has the other."""
        look = self.looks.get(looked_at)
        self.looks.clear()
        if look is None:
            return
        self.frfs.add_hit(name, point, look.frf)
        if self.expected is not None:
            shape = np.full(len(self.expected.frequency_hz), np.nan)
            shape[look.modes] = look.shape
            self.shapes[name] = shape

    def remove_hit(self, name: str) -> None:
        """A hit was dropped."""
        self.frfs.remove_hit(name)
        self.shapes.pop(name, None)

    def _measure(self, answer: HitResponse) -> _Look:
        frf = answer.frf(self.channels, self.up_to_hz)
        if self.expected is None:
            return _Look(frf, np.zeros(0, dtype=np.int64), np.zeros(0))
        found = participation(answer, self.expected)
        return _Look(frf, found.modes, found.shape)

    def _by_modes(self, point: int, look: _Look) -> HitLocation | None:
        expected = self.expected
        if expected is None or len(look.modes) < FEWEST_MODES or point not in expected.points:
            return None
        largest = np.abs(expected.at_points[:, look.modes]).max(axis=0)
        known = {p: self._known(p)[look.modes] / largest for p in expected.points}
        shape = look.shape / largest
        away = {p: float(np.sqrt(np.mean((shape - k) ** 2))) for p, k in known.items()}
        struck = self.frfs.hits_at(point)
        scale = _scale_of_shape(shape, known[point]) if struck else self._scale_beside_others(point, look)
        return _judge_point(point, away, scale, FAR_BY_MODES, struck)

    def _scale_beside_others(self, point: int, look: _Look) -> float:
        """Motion a newton over what the model says, beside the same of hits at other points; NaN without any.

        A gain of the hammer or a mass that is not as believed is in all of them.
        """
        assert self.expected is not None
        others: list[float] = []
        for name, seen in self.shapes.items():
            found = np.flatnonzero(~np.isnan(seen))
            others.append(_scale_of_shape(seen[found], self._believed(self.frfs.point_of[name])[found]))
        usual = float(np.median(others)) if others else float("nan")
        if not others or float(np.std(others)) > SCATTER * usual:
            return float("nan")
        return _scale_of_shape(look.shape, self._believed(point)[look.modes]) / usual

    def _believed(self, point: int) -> Real:
        assert self.expected is not None
        return self.expected.at_points[self.expected.points.index(point)]

    def _known(self, point: int) -> Real:
        """(modes,) what hits there have shown; where none has, what is expected."""
        believed = self._believed(point)
        seen = [self.shapes[name] for name, at in self.frfs.point_of.items() if at == point and name in self.shapes]
        if not seen:
            return believed
        count = np.sum(~np.isnan(seen), axis=0)
        return np.where(count > 0, np.nansum(seen, axis=0) / np.maximum(count, 1), believed)

    def _by_frfs(self, point: int, look: _Look) -> HitLocation:
        away = self.frfs.distances_to_points(look.frf)
        if point not in away:
            return HitLocation()
        return _judge_point(point, away, self.frfs.scale(look.frf, point), FAR_BY_FRFS, self.frfs.hits_at(point))


def _scale_of_shape(shape: Real, known: Real) -> float:
    return float(shape @ known / (known @ known))


def _judge_point(point: int, away: dict[int, float], scale: float, far: float, struck: int) -> HitLocation:
    nearest = min(away, key=lambda p: away[p])
    own = away[point]
    reasons: list[str] = []
    if own > far and nearest != point and away[nearest] < min(NEARER * own, NEAR * far):
        reasons.append(f"this looks like point {nearest}; {point} was requested")
    elif abs(scale - 1) > OFF_SCALE:
        than = f"after the {struck} before at point {point}" if struck else "hits at other points predict"
        reasons.append(
            f"the structure moved {scale:.2g} times as much a newton as {than},"
            f" at least {1 - OFF_SCALE:g}, at most {1 + OFF_SCALE:g}: struck obliquely, or beside the point"
        )
    elif struck and own > far:
        reasons.append(
            f"{100 * own:.0f} % off the {struck} before at point {point}, at most {100 * far:.0f} %: struck beside the"
            " point, or something touched the structure"
        )
    return HitLocation(nearest, own, scale, tuple(reasons))
