"""What the twin's part of an effect declares: entry in the catalogue, change of the twin, how a fit finds it."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from math import inf
from typing import Literal

from modallab.core.effect import AlongBeam, NoPlace, OneChannel, Place, TwoChannels
from modallab.core.effects import Effect, EffectKind
from modallab.core.rig import Beam, Rig
from modallab.twin.bench import Twin
from modallab.twin.candidate import CandidateEffect, FreeNumber

Change = Callable[[Twin, Effect, Rig], Twin]
Overtones = Literal["odd", "even"]
Acts = Literal["force", "couple"]
Absorber = Literal["nothing", "damping ratios", "Young's modulus"]


class NoChange(Enum):
    """Why the twin does not change with an effect."""

    NO_FORCE_PREDICTS_IT = "it adds a signal that no force predicts, or changes the finished record"
    NO_MODEL_YET = "the twin has no model of this effect yet"


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplacedTolerance:
    """What an effect is among the numbers that a fit has free anyhow.

    Attributes:
        absorbed_by: which numbers of the beam take its work over in a fit without it.
        replaces_gain: whether it stands for the sensitivity of its channel, which must then not be free beside it.
        replaces: tolerance of the rig file that is the same quantity, and must not be free beside it; "" for none.
        is_clock: whether its one number is the error of the clock that the generator's own lines show.
        deviations: how many deviations of its own tolerance an effect of this size is; infinitely many where the rig
            file states none for it.
        deviations_from: how many deviations of the rig file's tolerances it is off the effect of that name at its own
            place; infinitely many where the two are not alike.
    """

    absorbed_by: Absorber = "nothing"
    replaces_gain: bool = False
    replaces: str = ""
    is_clock: bool = False
    deviations: Callable[[Effect, Rig], float] = lambda effect, rig: inf
    deviations_from: Callable[[Effect, str, Rig], float] = lambda effect, other, rig: inf


@dataclass(frozen=True, slots=True, kw_only=True)
class SteppedLaw:
    """What is particular of an effect that depends on the size of the motion, so that it is stepped in time.

    Attributes:
        overtones: those it makes: odd ones alone where it acts alike both ways, even ones too where it does not.
        acts: what it does at its place along the beam: a force, or a couple that bends it; None where it has no such
            place.
        on_slowest: power of the slowest mode's shape at its place with which its first number acts on that mode, which
            says little more of where it is; 0 where the number has no place.
        smooth: whether its force is a power of the motion, of which the overtones of a small motion drown in the noise.
        behind: name of its stiffness at the root, which acts in series with the compliance of the modes above the band;
            the records hardly determine how many such modes there are. "" for none.
    """

    overtones: Overtones = "odd"
    acts: Acts | None = None
    on_slowest: int = 0
    smooth: bool = False
    behind: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class EffectSearch:
    """How a fit looks for an effect: at each place its kind may have, with these numbers free.

    Attributes:
        rank: its turn among the candidates, smallest first.
        slots: its free numbers on a beam; one called "x" is its place along the beam.
        fixed: parameters that are not free.
        forms: of its law, each by further parameters that are not free: rivals under one name.
        needs: the test, or the shaker, that distinguishes it from what is free anyhow; None if either will do.
        inexact: relative deviation by which its size may be off, however well it fits: what it is on a bench is never
            quite what it is here.
        tolerance: what it is among the numbers that are free anyhow.
        law: of an effect that is stepped in time.
    """

    rank: int
    slots: Callable[[Beam], tuple[FreeNumber, ...]]
    fixed: tuple[tuple[str, float], ...] = ()
    forms: tuple[tuple[tuple[str, float], ...], ...] = ((),)
    needs: Literal["impact", "shaker", "sine"] | None = None
    inexact: float = 0.0
    tolerance: ReplacedTolerance = ReplacedTolerance()
    law: SteppedLaw = SteppedLaw()


@dataclass(frozen=True, slots=True)
class RivalEffect:
    """Another effect that may look the same.

    Attributes:
        effect: its name; "" for any.
        experiment: what distinguishes the two once a campaign has left both standing; "" for nothing in particular.
        rank: where several experiments apply, the smallest goes first.
        plan: what to add to a plan that cannot distinguish them; "" for nothing.
    """

    effect: str
    experiment: str = ""
    rank: int = 100
    plan: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class EffectModel:
    """All that the twin, the fits and the diagnosis know of one effect. Nothing that counts has a default.

    Attributes:
        kind: its entry in the catalogue.
        rank: its place in the catalogue within its stage, smallest first.
        spoken: what a diagnosis calls it in a sentence.
        change: the twin with it; or why there is no such change.
        moves_poles: whether the poles of the ring-down move with it.
        once: whether a bench has it once at most.
        search: how a fit looks for it; None where the twin does not change with it.
        experiment: a sentence that names the experiment which shows it apart from its rivals.
        rivals: effects that may look the same, and what distinguishes them.
    """

    kind: EffectKind
    rank: int
    spoken: str
    change: Change | NoChange
    moves_poles: bool
    once: bool
    search: EffectSearch | None
    experiment: str
    rivals: tuple[RivalEffect, ...] = ()

    def candidates(self, rig: Rig, rows: tuple[int, ...] = ()) -> list[CandidateEffect]:
        """The effect with its numbers free, at its place on a rig; none where the rig has no such place.

        Args:
            rig: with a beam.
            rows: the channel, or the pair of channels, of an effect whose place is one.
        """
        if self.search is None or (self.kind.place == "shaker" and rig.shaker_point is None):
            return []
        assert rig.beam is not None
        slots, place = self.search.slots(rig.beam), self._place(rig, rows)
        return [
            CandidateEffect(self.kind.name, slots, place, (*self.search.fixed, *form)) for form in self.search.forms
        ]

    def _place(self, rig: Rig, rows: tuple[int, ...]) -> Place:
        if self.kind.place == "force":
            # Its row of the rig, whichever that is.
            return OneChannel(channel=rig.force_channel.index)
        fixed = self.kind.fixed_place
        if fixed is not None:
            return fixed
        if self.kind.place == "shaker":
            assert rig.beam is not None
            assert rig.shaker_point is not None
            return AlongBeam(x=rig.x_of(rig.shaker_point) / rig.beam.length_m)
        if self.kind.place == "x":
            return NoPlace()
        return TwoChannels(channel=(rows[0], rows[1])) if self.kind.place == "pair" else OneChannel(channel=rows[0])


def number_in_deviations(value: float, tolerance: float) -> float:
    """A number in deviations of its tolerance; infinitely many where there is none."""
    return abs(value) / tolerance if tolerance else inf
