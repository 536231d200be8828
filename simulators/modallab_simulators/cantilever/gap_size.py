"""How large a gap some effects open, and how large an effect must be to open a requested one.

The gap is the rms over all accelerometer records of the difference between a trial with the effects and the one a
perfect twin without them would predict from the same forces, in units of the channels' own noise.
"""

from collections.abc import Callable, Sequence
from math import exp, hypot, log, sqrt

import numpy as np

from modallab.core.arrays import Real
from modallab.core.block import Block, Campaign
from modallab.core.effects import Effect
from modallab.core.rig import Converter, Rig
from modallab_simulators.cantilever.effects import part_of
from modallab_simulators.cantilever.injected_effects import inject_effects
from modallab_simulators.cantilever.trial import make_trial, sound_trial

NODE = 0.03
"""Share of a record's mean squares below which a channel counts as at a node: its own response is no measure there."""

_CLOSE = 0.05
_TRIES = 10
_NARROW = 0.02


def gap_of(rig: Rig, seed: int, effects: Sequence[Effect]) -> float:
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


def solve(
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
