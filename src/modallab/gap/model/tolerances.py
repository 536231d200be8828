"""The tolerances that a rig file states beyond those of the beam, as free numbers with their priors.

Each number is normal with deviation 1. What may have either sign is that many deviations. What has one sign only is
half-normal: its prior is the normal one of the same mean and deviation (Johnson, Kotz and Balakrishnan, Continuous
Univariate Distributions 1, 1994, ch. 13), which keeps fits straight. A root has no negative compliance: there the
quantile transform keeps the sign.
"""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from modallab.core.arrays import Real
from modallab.core.rig import FORCE_SHARE, Rig, Tolerance
from modallab.twin.bench import Twin
from modallab.twin.elements import FIELD_TERMS
from modallab.twin.structure import root_of_rig_file

FREE = 3.0
"""Deviations of a tolerance up to which they are free."""
MOST = 4.5
"""Deviations of a tolerance above which no number goes."""
LEAST = -5.0
"""Smallest coordinate of a root's compliance."""
MEAN, SPREAD = float(np.sqrt(2 / np.pi)), float(np.sqrt(1 - 2 / np.pi))
"""Of a half-normal number, in its tolerance."""

Departed = dict[str, dict[float, float]]
"""Numbers by the tolerance's name and by channel, place in m or term."""
DAMPERS = 12
"""Places at which dampers stand for one that may be anywhere: two for each half wave of the products of two modes."""


@dataclass(frozen=True, slots=True)
class Deviation:
    """One free number.

    Attributes:
        tolerance: its name in the rig file.
        at: channel, place in m, or term of a field, where there are several.
        sigma: its deviation, in the tolerance's unit.
        sign: 1 or -1 where it has one sign only, else 0.
    """

    tolerance: str
    at: float
    sigma: float
    sign: int = 0

    def value(self, u: float) -> float:
        """The number at coordinate u."""
        deviations = limited_number(u)
        if self.tolerance == "clamp_compliance":
            return float(_root(self.sigma, deviations))
        return float(_number(self.sigma, self.sign, deviations))


@dataclass(frozen=True, eq=False, slots=True)
class Scales:
    """What makes numbers of coordinates, of many deviations at once: a fit asks for all of them at every step.

    Attributes:
        of: the deviations.
        sigma: (deviations,) of each.
        sign: (deviations,) as in `Deviation`.
        roots: those whose numbers are quantiles.
        named: (tolerance, where its deviations are, their places): those of a tolerance follow one another.
    """

    of: tuple[Deviation, ...]
    sigma: Real
    sign: NDArray[np.int64]
    roots: tuple[int, ...]
    named: tuple[tuple[str, slice, tuple[float, ...]], ...]

    @classmethod
    def of_all(cls, of: tuple[Deviation, ...]) -> "Scales":
        """Of these deviations."""
        roots = tuple(k for k, d in enumerate(of) if d.tolerance == "clamp_compliance")
        signs = np.array([d.sign for d in of], dtype=np.int64)
        named: list[tuple[str, slice, tuple[float, ...]]] = []
        for name, own in groupby(of, lambda d: d.tolerance):
            at = tuple(d.at for d in own)
            begin = named[-1][1].stop if named else 0
            named.append((name, slice(begin, begin + len(at)), at))
        return cls(of, np.array([d.sigma for d in of]), signs, roots, tuple(named))

    def values(self, u: Real) -> Real:
        """(..., deviations) the numbers at coordinates u, as `Deviation.value` has each."""
        h = u if np.all(np.abs(u) < FREE) else limit_smoothly(u)
        values = _number(self.sigma, self.sign, h)
        for k in self.roots:
            values[..., k] = _root(self.sigma[k], h[..., k])
        return values

    def by_tolerance(self, values: list[float]) -> Departed:
        """These numbers (deviations,) by tolerance and place."""
        return {name: dict(zip(at, values[own], strict=True)) for name, own, at in self.named}


def by_tolerance(numbers: Iterable[tuple[Deviation, float]]) -> Departed:
    """Deviations, each with its number, by tolerance and place."""
    values: Departed = {}
    for deviation, value in numbers:
        values.setdefault(deviation.tolerance, {})[deviation.at] = value
    return values


def _root(sigma: Any, deviations: Any) -> Real:
    """The compliance of a root so many deviations off: of a half-normal number the quantile."""
    return np.asarray(sigma * -ndtri(ndtr(-np.maximum(deviations, LEAST)) / 2))


def _number(sigma: Any, sign: Any, deviations: Any) -> Real:
    """The number so many deviations off, half-normal where it has one sign only."""
    return np.asarray(sigma * np.where(sign, sign * (MEAN + SPREAD * deviations), deviations))


def limited_number(u: float) -> float:
    """`held` of one number, which is next to always free."""
    return u if abs(u) < FREE else float(limit_smoothly(u))


def limit_smoothly(u: Any, free: float = FREE, most: float = MOST) -> Real:
    """As it is up to `free` deviations, and ever slower towards `most`: a fit that strayed can find its way back."""
    room = most - free
    return np.where(np.abs(u) < free, u, np.sign(u) * (free + room * np.tanh((np.abs(u) - free) / room)))


def with_tolerances(rig: Rig) -> Rig:
    """The rig with a lab's usual tolerances, where its file states none: no part is ever without any."""
    if rig.tolerance.stated:
        return rig
    own = {name: getattr(rig.tolerance, name) for name in rig.tolerance.model_fields_set}
    return rig.model_copy(update={"tolerance": Tolerance.usual().model_copy(update=own)})


def deviations(rig: Rig, hits: Collection[tuple[float, int]]) -> tuple[Deviation, ...]:
    """The free numbers of the tolerances that a rig file states.

    Args:
        rig: the bench as believed.
        hits: place in m and number of the hits at each drive point: what is left of many hits is their mean.
    """
    t = rig.tolerance
    assert rig.beam is not None
    tip = rig.beam.length_m - 1e-9
    sensors = [(float(c.index), rig.x_of(c.point)) for c in rig.responses if c.point is not None]
    # A root whose spring the rig file states has a tolerance of its own.
    one = [] if root_of_rig_file(rig.beam) else [Deviation("clamp_compliance", 0.0, t.clamp_compliance, 1)]
    if rig.shaker_point is not None:
        one += [Deviation(name, 0.0, getattr(t, name), 1) for name in ("shaker_mass_kg", "stinger_rotation")]
    # A sensitivity that the rig file does not mention is no licence to turn it.
    force = FORCE_SHARE * t.sensitivity if "sensitivity" in t.model_fields_set else 0.0
    found = [
        Deviation("sensitivity", float(rig.force_channel.index), force),
        # Nothing sits beyond the tip.
        *(Deviation("position_m", c, t.position_m, -int(x >= tip)) for c, x in sensors),
        *(Deviation("sensor_mass_kg", c, t.sensor_mass_kg, 1) for c, _ in sensors),
        *(Deviation("hit_position_m", x, t.hit_position_m / np.sqrt(count), -int(x >= tip)) for x, count in hits),
        *(Deviation("hit_gain", x, t.hit_gain / np.sqrt(count)) for x, count in hits),
        *(Deviation("stiffness_field", float(k), t.stiffness_field) for k in range(FIELD_TERMS)),
        *(Deviation("mass_field", float(k), t.mass_field) for k in range(FIELD_TERMS)),
        Deviation("stiffness_drift", 0.0, t.stiffness_drift),
        *(Deviation("damper_n_s_per_m", tip * k / DAMPERS, t.damper_n_s_per_m) for k in range(1, DAMPERS + 1)),
        *one,
    ]
    return tuple(d for d in found if d.sigma)


def sensors_x_m(rig: Rig) -> dict[float, float]:
    """Place of each accelerometer, by its row."""
    return {float(c.index): rig.x_of(c.point) for c in rig.responses if c.point is not None}


def apply_tolerances(twin: Twin, rig: Rig, values: Departed, x_of: Mapping[float, float] | None = None) -> Twin:
    """The twin with these numbers of its tolerances; `x_of` is `sensors_x_m` where that is known."""
    nothing: dict[float, float] = {}

    def of(name: str) -> dict[float, float]:
        return values.get(name, nothing)

    def one(name: str) -> float:
        return of(name).get(0.0, 0.0)

    s = twin.structure
    x_of = sensors_x_m(rig) if x_of is None else x_of
    structure = replace(
        s,
        ei_field=_added(s.ei_field, of("stiffness_field")),
        mass_field=_added(s.mass_field, of("mass_field")),
        root_rotation=s.root_rotation + one("clamp_compliance"),
        masses=(*s.masses, *((x_of[c], kg) for c, kg in of("sensor_mass_kg").items())),
        # A damper of nothing would couple the modes, which takes time, to no effect.
        dampers=(*s.dampers, *((x, c) for x, c in of("damper_n_s_per_m").items() if c)),
    )
    return replace(
        twin,
        structure=structure,
        chain=replace(
            twin.chain,
            shift={int(c): dx for c, dx in of("position_m").items()},
            force_gain=1 + of("sensitivity").get(float(rig.force_channel.index), 0.0),
        ),
        ei_drift=one("stiffness_drift"),
        hit_offsets_m=tuple(of("hit_position_m").items()),
        hit_gains=tuple((x, 1 + gain) for x, gain in of("hit_gain").items()),
        shaker_mass_kg=one("shaker_mass_kg"),
        stinger_k_rot=one("stinger_rotation") * s.bending_stiffness / s.length_m,
    )


def _added(field: Real, terms: dict[float, float]) -> Real:
    total = field.copy()
    for k, a in terms.items():
        total[int(k)] += a
    return total
