"""What the simulated bench's part of an effect declares: how it is played, and how a blind trial draws it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import exp, log

import numpy as np

from modallab.core.block import Block
from modallab.core.effects import Effect, EffectKind, kind_of
from modallab.core.rig import Beam, Rig
from modallab_simulators.cantilever.altered_bench import AlteredBench

Change = Callable[[AlteredBench, Effect, Rig], AlteredBench]
Ties = dict[str, tuple[float, float]]


def _any_hz(rng: np.random.Generator) -> float:
    return exp(rng.uniform(log(10.0), log(100.0)))


def _no_ties(rng: np.random.Generator, beam: Beam, moment: float) -> Ties:
    return {}


def _no_problem(effect: Effect, rig: Rig) -> list[str]:
    return []


@dataclass(frozen=True, slots=True)
class Drawn:
    """How a blind trial draws an effect whose main number is to open a gap of a requested size.

    Attributes:
        slope: how the gap of a small effect goes with the main number, on logarithms.
        places: between which shares of the length it is put; elsewhere it would hardly show.
        hz: draws a number called hz that is not the main one.
        ties: draws numbers that go with the main one, as (share, power): share times its power. From the beam, and the
            root's moment at the high level of the sines.
    """

    slope: float = 1.0
    places: tuple[float, float] = (0.1, 1.0)
    hz: Callable[[np.random.Generator], float] = _any_hz
    ties: Callable[[np.random.Generator, Beam, float], Ties] = _no_ties


@dataclass(frozen=True, slots=True, kw_only=True)
class EffectPart:
    """All that the simulated bench knows of one effect.

    Attributes:
        name: of the effect.
        rank: its turn when several change the same thing, smallest first.
        change: the bench with it.
        several: whether a bench may have it more than once; on one channel it is once in any case.
        outside: its entry in a catalogue of this bench's own; None for an effect of the project's catalogue.
        options: numbers that say how this bench plays it, and are no part of it.
        limits: parameter -> (low, high) beyond which it makes no sense, or no bench.
        check: what is wrong with it on a rig, a sentence each.
        joint: whether it is the joint at the root, of which there is one.
        seen_by_force: whether the force channel sees it, so that it opens no gap of whatever size it is.
        lasts: the option that says over how many seconds it runs; a trial sets it to its own length.
        on_campaign: what it makes of the records of a whole trial, whose bench then does not play it.
        drawn: how a blind trial draws it.
    """

    name: str
    rank: int
    change: Change
    several: bool
    outside: EffectKind | None = None
    options: tuple[str, ...] = ()
    limits: Mapping[str, tuple[float, float]] = field(default_factory=dict[str, tuple[float, float]])
    check: Callable[[Effect, Rig], list[str]] = _no_problem
    joint: bool = False
    seen_by_force: bool = False
    lasts: str | None = None
    on_campaign: Callable[[Sequence[Block], Effect], list[Block]] | None = None
    drawn: Drawn = Drawn()

    @property
    def kind(self) -> EffectKind:
        """Its entry in its catalogue.

        Raises:
            FormatError: neither catalogue has it.
        """
        return self.outside or kind_of(self.name)
