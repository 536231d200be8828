"""What blind trials ask of this bench: effects drawn to a size, and whole campaigns in a moment."""

from dataclasses import dataclass
from math import exp, log

import numpy as np

from modallab.core.effects import Effect, Parameter
from modallab.core.places import AlongBeam, NoPlace, OneChannel, Place, TwoChannels
from modallab.core.rig import Rig
from modallab_simulators.cantilever.draw import Stream, generator
from modallab_simulators.cantilever.effect_part import EffectPart, Ties
from modallab_simulators.cantilever.effects import allowed, kinds, part_of
from modallab_simulators.cantilever.gap_size import GapMeter, solve
from modallab_simulators.cantilever.trial import LEVELS_N, make_trial

GAP_RANGE = (1.5, 300.0)
WHOLE = 0.8
"""Share of a factor that an effect may take away."""


@dataclass(frozen=True, slots=True)
class DrawnEffect:
    """An effect and the gap it opens.

    Attributes:
        effect: with its numbers.
        requested: the gap that was aimed at, in noise units.
        gap: the gap it has; another one where the effect has no size, or none that is large or small enough.
        moves: share of the response that it moves, on the channel and in the test where it is most.
    """

    effect: Effect
    requested: float
    gap: float
    moves: float


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
    part = part_of(name)
    target = draw_gap(seed) if requested is None else requested
    shape = _Shape(rig, seed, part)
    ruler = GapMeter(rig, seed)
    if shape.main is None:
        return _read(ruler, shape.at(0.0), target)
    if part.seen_by_force:
        # What the force channel sees opens no gap: a diagnosis had better not be misled.
        effect = shape.at(generator(seed, Stream.GAP, 1).uniform(*shape.span))
        return _read(ruler, effect, target)
    size, gap = solve(lambda s: ruler.gap((shape.at(s),)), shape.span, part.drawn.slope, target)
    return DrawnEffect(shape.at(size), target, gap, ruler.moves((shape.at(size),)))


def _read(ruler: GapMeter, effect: Effect, requested: float) -> DrawnEffect:
    return DrawnEffect(effect, requested, ruler.gap((effect,)), ruler.moves((effect,)))


class _Shape:
    """An effect of which all is drawn but one size, the logarithm of its main number."""

    def __init__(self, rig: Rig, seed: int, part: EffectPart) -> None:
        self._part, self._kind = part, part.kind
        self._rng = generator(seed, Stream.EFFECT, *part.name.encode())
        assert rig.beam is not None
        self.main: Parameter | None = next((p for p in self._kind.parameters if p.high > p.low * 1.5), None)
        self._place = _drawn_place(rig, self._rng, part)
        self._others = self._drawn_others()
        self._tied = self._drawn_ties(rig)
        self._sign = float(self._rng.choice([-1.0, 1.0])) if self.main and self.main.signed else 1.0
        self.span = (0.0, 0.0)
        if self.main:
            low, high = self.main.bounds(rig.beam)
            top = allowed(part, self.main.name)[1]
            self.span = (log(low), log(min(high, top, self._room(rig), self._whole())))

    def at(self, size: float) -> Effect:
        """The effect of a size."""
        parameters = dict(self._others)
        if self.main:
            value = self._sign * exp(size)
            parameters[self.main.name] = self.main.none + value
            parameters |= {name: share * value**power for name, (share, power) in self._tied.items()}
        names = [*(p.name for p in self._kind.parameters), *self._part.options]
        ordered = {name: parameters[name] for name in names if name in parameters}
        return Effect(effect=self._kind.name, parameters=ordered, place=self._place)

    def _drawn_others(self) -> dict[str, float]:
        drawn = {
            "sign": -1.0,
            "hz": self._part.drawn.hz(self._rng),
            "zeta": exp(self._rng.uniform(log(0.02), log(0.1))),
        }
        return {p.name: drawn[p.name] for p in self._kind.parameters if p is not self.main and p.name in drawn}

    def _drawn_ties(self, rig: Rig) -> Ties:
        assert rig.beam is not None
        return self._part.drawn.ties(self._rng, rig.beam, LEVELS_N["high"] * 0.4 * rig.beam.length_m)

    def _whole(self) -> float:
        """How far a factor may fall: what is turned over goes by another name."""
        turned = self.main is not None and self.main.none > 0 and self._sign < 0
        return WHOLE * self.main.none if turned and self.main else float("inf")

    def _room(self, rig: Rig) -> float:
        """How far a sensor or a hit can move without leaving the beam."""
        if self.main is None or self.main.name != "dx" or rig.beam is None:
            return float("inf")
        length = rig.beam.length_m
        if self._kind.place == "hit":
            return 0.08 * length
        assert isinstance(self._place, OneChannel)
        point = rig.channels[self._place.channel].point
        x = 0.0 if point is None else rig.x_of(point)
        if length - x < 1e-9 * length:
            self._sign = -1.0
        return max(x if self._sign < 0 else length - x, 1e-6 * length)


def _drawn_place(rig: Rig, rng: np.random.Generator, part: EffectPart) -> Place:
    kind = part.kind
    if kind.place == "x":
        return AlongBeam(x=round(float(rng.uniform(*part.drawn.places)), 3))
    if kind.place == "shaker" and rig.shaker_point is not None and rig.beam is not None:
        return AlongBeam(x=rig.x_of(rig.shaker_point) / rig.beam.length_m)
    rows = [c.index for c in rig.responses]
    if kind.place == "channel":
        return OneChannel(channel=int(rng.choice(rows)))
    if kind.place == "pair":
        first, second = sorted(int(row) for row in rng.choice(rows, 2, replace=False))
        return TwoChannels(channel=(first, second))
    return kind.fixed_place or NoPlace()


__all__ = ["draw_effect", "draw_gap", "kinds", "make_trial"]
