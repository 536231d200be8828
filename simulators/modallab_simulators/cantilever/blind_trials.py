"""What blind trials ask of this bench: effects drawn to a size, and whole campaigns in a moment."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import exp, hypot, log, sqrt

import numpy as np

from modallab.core.arrays import Real
from modallab.core.block import Block, Campaign
from modallab.core.effect import AlongBeam, NoPlace, OneChannel, Place, TwoChannels
from modallab.core.effects import Effect, Parameter
from modallab.core.rig import Converter, Rig
from modallab_simulators.cantilever.beam import RandomStream, random_generator
from modallab_simulators.cantilever.effect_part import EffectPart, Ties
from modallab_simulators.cantilever.effects import allowed_range, kinds, part_of
from modallab_simulators.cantilever.injected_effects import inject_effects
from modallab_simulators.cantilever.trial import LEVELS_N, make_trial, sound_trial

NODE = 0.03
"""Share of a record's mean squares below which a channel counts as at a node: its own response is no measure there."""

_CLOSE = 0.05
_TRIES = 10
_NARROW = 0.02


def gap_of_effects(rig: Rig, seed: int, effects: Sequence[Effect]) -> float:
    """The gap some effects open in the trial of a seed, in noise units."""
    return GapMeter(rig, seed).gap(effects)


class GapMeter:
    """Measures gaps in the trials of one seed."""

    def __init__(self, rig: Rig, seed: int) -> None:
        converter = rig.converter or Converter()
        self._seed, self._noise_v = seed, converter.noise_rms_v
        self._floor_v = hypot(converter.noise_rms_v, converter.volts_per_count / sqrt(12))
        # Without noise, and with counts too fine to matter, nothing but the effects makes the difference.
        noiseless = converter.model_copy(update={"noise_rms_v": 0.0, "bits": 30})
        self._rig = rig.model_copy(update={"converter": noiseless})
        self._sound: Campaign | None = None

    def gap(self, effects: Sequence[Effect]) -> float:
        """In noise units."""
        recorded, _ = make_trial(self._rig, self._seed, effects)
        chain = inject_effects(effects, self._rig).altered.chain
        squares = _mean_square(recorded, self._sound_for(effects), chain.force_gain) / self._floor_v**2
        share = (self._noise_v / self._floor_v) ** 2 / len(self._rig.responses)
        for factor in chain.noise.values():
            squares += (factor**2 - 1) * share
        return sqrt(squares)

    def moves(self, effects: Sequence[Effect]) -> float:
        """Share of the response that they move, on the channel and in the test where it is most.

        Rms over the records of a test; a channel at a node is measured by what the others of its record answer.
        """
        recorded, _ = make_trial(self._rig, self._seed, effects)
        chain = inject_effects(effects, self._rig).altered.chain
        rows = [c.index for c in recorded.rig.responses]
        noise = {row: (factor**2 - 1) * self._noise_v**2 for row, factor in chain.noise.items()}
        shares: dict[str, list[Real]] = {}
        for one, other in zip(recorded.blocks, self._sound_for(effects).blocks, strict=True):
            shares.setdefault(one.test, []).append(_shares(one, other, rows, chain.force_gain, noise))
        return sqrt(max(float(np.max(np.mean(listed, axis=0))) for listed in shares.values()))

    def _sound_for(self, effects: Sequence[Effect]) -> Campaign:
        clock = inject_effects(effects, self._rig).altered.chain.clock
        if clock or any(part_of(e.effect).seen_by_force for e in effects):
            return sound_trial(self._rig, self._seed, effects)
        if self._sound is None:
            self._sound = sound_trial(self._rig, self._seed, ())
        return self._sound


def _shares(one: Block, other: Block, rows: list[int], gain: float, noise: dict[int, float]) -> Real:
    """Squares of each channel's difference in one record over those of its response."""
    difference = (one.samples[rows] - gain * other.samples[rows]) * one.scale[rows, None]
    own = np.mean((other.samples[rows] * other.scale[rows, None]) ** 2, axis=1)
    off = np.mean(difference**2, axis=1) + np.array([noise.get(row, 0.0) for row in rows])
    return off / np.maximum(own, NODE * np.mean(own))


def _mean_square(recorded: Campaign, sound: Campaign, gain: float) -> float:
    rows = [c.index for c in recorded.rig.responses]
    total, count = 0.0, 0
    for one, other in zip(recorded.blocks, sound.blocks, strict=True):
        difference = (one.samples[rows] - gain * other.samples[rows]) * one.scale[rows, None]
        total += float(np.sum(difference**2))
        count += difference.size
    return total / count


def size_for_gap(
    gap: Callable[[float], float], span: tuple[float, float], slope: float, requested: float
) -> tuple[float, float]:
    """The size at which the gap is within 5 % of the requested one; else the nearest that was met.

    A secant on logarithms, kept between the nearest sizes below and above. Gaps that have grown out of all proportion
    say little about the slope, so it is not taken for less than a third of what it is for a small effect.
    """
    below, above = span if slope > 0 else (span[1], span[0])
    size, met = sum(span) / 2, list[tuple[float, float]]()
    for _ in range(_TRIES):
        off = log(max(gap(size), 1e-12) / requested)
        met.append((size, off))
        below, above = (size, above) if off < 0 else (below, size)
        if abs(off) < log(1 + _CLOSE) or abs(above - below) < _NARROW:
            break
        guess = size - off / _slope(met, slope)
        inside = min(below, above) < guess < max(below, above)
        size = guess if inside else _between(below, above, met)
    size, off = min(met, key=lambda pair: abs(pair[1]))
    return size, requested * exp(off)


def _slope(met: Sequence[tuple[float, float]], small: float) -> float:
    if len(met) < 2:
        return small
    (one, first), (two, second) = met[-2:]
    steepness = (second - first) / (two - one) / small
    return small * min(max(steepness, 1 / 3), 3.0)


def _between(below: float, above: float, met: Sequence[tuple[float, float]]) -> float:
    # An end that was never tried may itself be the answer.
    tried = {size for size, _ in met}
    for end in (below, above):
        if end not in tried and (met[-1][1] < 0) == (end == above):
            return end
    return (below + above) / 2


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
    return exp(random_generator(seed, RandomStream.GAP).uniform(log(low), log(high)))


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
        effect = shape.at(random_generator(seed, RandomStream.GAP, 1).uniform(*shape.span))
        return _read(ruler, effect, target)
    size, gap = size_for_gap(lambda s: ruler.gap((shape.at(s),)), shape.span, part.drawn.slope, target)
    return DrawnEffect(shape.at(size), target, gap, ruler.moves((shape.at(size),)))


def _read(ruler: GapMeter, effect: Effect, requested: float) -> DrawnEffect:
    return DrawnEffect(effect, requested, ruler.gap((effect,)), ruler.moves((effect,)))


class _Shape:
    """An effect of which all is drawn but one size, the logarithm of its main number."""

    def __init__(self, rig: Rig, seed: int, part: EffectPart) -> None:
        self._part, self._kind = part, part.kind
        self._rng = random_generator(seed, RandomStream.EFFECT, *part.name.encode())
        assert rig.beam is not None
        self.main: Parameter | None = next((p for p in self._kind.parameters if p.high > p.low * 1.5), None)
        self._place = _drawn_place(rig, self._rng, part)
        self._others = self._drawn_others()
        self._tied = self._drawn_ties(rig)
        self._sign = float(self._rng.choice([-1.0, 1.0])) if self.main and self.main.signed else 1.0
        self.span = (0.0, 0.0)
        if self.main:
            low, high = self.main.bounds(rig.beam)
            top = allowed_range(part, self.main.name)[1]
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
