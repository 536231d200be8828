"""Draws effects for blind trials: where they are, and how large, so that the gap they open has a requested size."""

from dataclasses import dataclass
from math import exp, log

import numpy as np

from modallab.core.effects import Effect, Parameter, Place
from modallab.core.errors import ConfigurationError
from modallab.core.rig import Rig
from modallab_simulators.cantilever.draw import Stream, generator
from modallab_simulators.cantilever.effects.kinds import KINDS, OPTIONS, allowed
from modallab_simulators.cantilever.gap_size import Ruler, gap_of, solve
from modallab_simulators.cantilever.trial import LEVELS_N

__all__ = ["DrawnEffect", "draw_effect", "draw_gap", "gap_of"]

GAP_RANGE = (1.5, 300.0)

PLACES: dict[str, tuple[float, float]] = {
    "added_mass": (0.3, 1.0),
    "stiffness_loss": (0.08, 0.7),
    "breathing_crack": (0.08, 0.3),
    "ground_spring": (0.3, 1.0),
    "local_damper": (0.3, 1.0),
    "cubic_spring": (0.5, 1.0),
    "support_resonance": (0.3, 1.0),
}
"""Between which shares of the length an effect is put; elsewhere it would hardly show."""

SEEN_BY_FORCE = frozenset({"amplifier_harmonics"})
"""What the force channel sees opens no gap, of whatever size it is: a diagnosis had better not be misled."""

_SLOPES: dict[tuple[str, str], float] = {
    ("clamp_rotation", "k_rot"): -1.0,
    ("clamp_translation", "k_trans"): -1.0,
    ("loose_mount", "hz"): -2.0,
    ("clipping", "fraction_of_peak"): -1.0,
    ("clamp_friction", "k_slip"): -1.0,
    ("torsion", "offset"): 2.0,
    ("cross_axis", "share"): 2.0,
    ("preamp_lag", "corner_hz"): -1.0,
    ("soft_saturation", "volts"): -2.0,
    ("dropouts", "share"): 0.5,
    ("clearance", "k_contact"): -1.0,
}
"""How the gap of a small effect goes with its main number, on logarithms; 1 for all others."""


@dataclass(frozen=True, slots=True)
class DrawnEffect:
    """An effect and the gap it opens.

    Attributes:
        effect: with its numbers.
        requested: the gap that was aimed at, in noise units.
        gap: the gap it has; another one where the effect has no size, or none that is large or small enough.
    """

    effect: Effect
    requested: float
    gap: float


def draw_gap(seed: int) -> float:
    """A size of the gap, log-uniform from 1.5 to 300 noise units."""
    low, high = GAP_RANGE
    return exp(generator(seed, Stream.GAP).uniform(log(low), log(high)))


def draw_effect(rig: Rig, seed: int, name: str, requested: float | None = None) -> DrawnEffect:
    """Draw where and how an effect is, then scale it until it opens a gap of the requested size.

    Args:
        rig: of the trial.
        seed: of the trial; it also draws place, sign and secondary numbers, and the size where none is requested.
        name: of the catalogue, or of this bench's own.
        requested: the gap, in noise units.

    Raises:
        ConfigurationError: no effect is called so, or the rig has no place for it.
    """
    if name not in KINDS:
        raise ConfigurationError(f"no effect is called {name!r}", remedy=f"use one of {', '.join(sorted(KINDS))}")
    target = draw_gap(seed) if requested is None else requested
    shape = _Shape(rig, seed, name)
    ruler = Ruler(rig, seed)
    if shape.main is None:
        return DrawnEffect(shape.at(0.0), target, ruler.gap((shape.at(0.0),)))
    if name in SEEN_BY_FORCE:
        effect = shape.at(generator(seed, Stream.GAP, 1).uniform(*shape.span))
        return DrawnEffect(effect, target, ruler.gap((effect,)))
    slope = _SLOPES.get((name, shape.main.name), 1.0)
    size, gap = solve(lambda s: ruler.gap((shape.at(s),)), shape.span, slope, target)
    return DrawnEffect(shape.at(size), target, gap)


class _Shape:
    """An effect of which all is drawn but one size, the logarithm of its main number."""

    def __init__(self, rig: Rig, seed: int, name: str) -> None:
        self._kind = KINDS[name]
        self._rng = generator(seed, Stream.EFFECT, *name.encode())
        assert rig.beam is not None
        self.main: Parameter | None = next((p for p in self._kind.parameters if p.high > p.low * 1.5), None)
        self._place = _drawn_place(rig, self._rng, name)
        self._others = self._drawn_others()
        self._tied = self._drawn_ties(rig)
        self._sign = float(self._rng.choice([-1.0, 1.0])) if self.main and self.main.signed else 1.0
        if self.main:
            low, high = self.main.bounds(rig.beam)
            top = allowed(self._kind, self.main.name)[1]
            self.span = (log(low), log(min(high, top, self._room(rig))))

    def at(self, size: float) -> Effect:
        """The effect of a size."""
        parameters = dict(self._others)
        if self.main:
            value = self._sign * exp(size)
            parameters[self.main.name] = 1 + value if self.main.name == "gain" else value
            parameters |= {name: share * value**power for name, (share, power) in self._tied.items()}
        names = [*(p.name for p in self._kind.parameters), *OPTIONS.get(self._kind.name, ())]
        ordered = {name: parameters[name] for name in names if name in parameters}
        return Effect(effect=self._kind.name, parameters=ordered, place=self._place)

    def _drawn_others(self) -> dict[str, float]:
        drawn = {
            "sign": -1.0,
            "hz": self._drawn_hz(),
            "zeta": exp(self._rng.uniform(log(0.02), log(0.1))),
        }
        return {p.name: drawn[p.name] for p in self._kind.parameters if p is not self.main and p.name in drawn}

    def _drawn_hz(self) -> float:
        if self._kind.name == "mains_hum":
            return float(self._rng.choice([50.0, 60.0]))
        return exp(self._rng.uniform(log(10.0), log(100.0)))

    def _drawn_ties(self, rig: Rig) -> dict[str, tuple[float, float]]:
        """Numbers that go with the main one, as (share, power): share times its power."""
        beam, rng = rig.beam, self._rng
        assert beam is not None
        ei = beam.youngs_modulus_pa * beam.width_m * beam.thickness_m**3 / 12
        moment = LEVELS_N["high"] * 0.4 * beam.length_m
        if self._kind.name == "clamp_friction":
            ratio = rng.uniform(3.0, 8.0)
            limit = exp(rng.uniform(log(0.02), log(0.2))) * moment * (1 - 1 / ratio)
            return {"k_stick": (ratio, 1.0), "moment_limit": (limit, 0.0)}
        if self._kind.name == "clearance":
            play = exp(rng.uniform(log(0.1), log(0.5))) * moment
            return {"gap": (play, -1.0), "k_within": (rng.uniform(6.0, 11.0) * ei / beam.length_m, 0.0)}
        return {}

    def _room(self, rig: Rig) -> float:
        """How far a sensor or a hit can move without leaving the beam."""
        if self.main is None or self.main.name != "dx" or rig.beam is None:
            return float("inf")
        length = rig.beam.length_m
        if self._kind.place == "hit":
            return 0.08 * length
        row = self._place["channel"]
        assert isinstance(row, int)
        point = rig.channels[row].point
        x = 0.0 if point is None else rig.x_of(point)
        if length - x < 1e-9 * length:
            self._sign = -1.0
        return max(x if self._sign < 0 else length - x, 1e-6 * length)


def _drawn_place(rig: Rig, rng: np.random.Generator, name: str) -> dict[str, Place]:
    kind = KINDS[name]
    if kind.place == "x":
        return {"x": round(float(rng.uniform(*PLACES.get(name, (0.1, 1.0)))), 3)}
    if kind.place == "shaker" and rig.shaker_point is not None and rig.beam is not None:
        return {"x": rig.x_of(rig.shaker_point) / rig.beam.length_m}
    rows = [c.index for c in rig.responses]
    if kind.place == "channel":
        return {"channel": int(rng.choice(rows))}
    if kind.place == "pair":
        return {"channel": tuple(sorted(int(row) for row in rng.choice(rows, 2, replace=False)))}
    fixed: dict[str, dict[str, Place]] = {
        "root": {"x": 0.0},
        "force": {"channel": 0},
        "base": {"where": "base"},
        "hit": {"where": "hit"},
        "impact": {"where": "impact"},
        "all": {"x" if kind.stage == "structure" else "channel": "all"},
    }
    return fixed.get(kind.place, {})
