"""What the simulated bench's part of an effect declares: how it is played, and how a blind trial draws it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import exp, inf, log

import numpy as np

from modallab.core.arrays import Real
from modallab.core.block import Block
from modallab.core.effects import Effect, EffectKind, kind_of
from modallab.core.rig import Beam, Rig
from modallab_simulators.cantilever.attached import Absorber, Attachment
from modallab_simulators.cantilever.beam import CantileverBeam, TrueBeam
from modallab_simulators.cantilever.cracked import LocalStiffnessLoss
from modallab_simulators.cantilever.feedback.elements import CrackElement, Drag, PointElement
from modallab_simulators.cantilever.modes import Damper, Modes
from modallab_simulators.cantilever.sensor import SensorTransfer

Element = PointElement | CrackElement
Rows = Mapping[int, float]

SIDE_ZETA = 0.004
"""Damping ratio of modes that are none of bending in the drive's direction, unless it is given."""
DRIFT_S = 1800.0
"""Bench time over which a drift runs, unless it says otherwise."""


def _no_rows() -> Rows:
    return {}


def _no_curves() -> Mapping[int, Callable[[Real], Real]]:
    return {}


@dataclass(frozen=True, eq=False, slots=True)
class SideFamily:
    """Modes beside those of bending in the drive's direction.

    Attributes:
        modes: of the true beam and its width.
        share: in which loads drive and sensors see them.
        zeta: their damping ratio.
    """

    modes: Callable[[TrueBeam, float], Modes]
    share: float
    zeta: float = SIDE_ZETA


@dataclass(frozen=True, eq=False, slots=True)
class StructureChanges:
    """What is other than believed about the structure.

    Attributes:
        root_nm_rad: springs at the root, one behind the other, joints at their stiffest.
        root_n_m: spring against which the root shifts.
        losses: of bending stiffness.
        waves: (k, a): EI times 1 + a cos(k pi x / L).
        mass_waves: the same of rho A.
        preload_n: axial force.
        attachments: masses and springs on the beam in every test.
        at_shaker: those on it in the sine test only.
        absorbers: masses on springs.
        dampers: to ground.
        elements: nonlinear ones, each made for the beam on its root.
        drag: of the air.
        side_modes: families of modes beside those of bending.
        drift: relative change of EI over a campaign.
        drift_s: bench time over which it runs.
    """

    root_nm_rad: tuple[float, ...] = ()
    root_n_m: float = inf
    losses: tuple[LocalStiffnessLoss, ...] = ()
    waves: tuple[tuple[int, float], ...] = ()
    mass_waves: tuple[tuple[int, float], ...] = ()
    preload_n: float = 0.0
    attachments: tuple[Attachment, ...] = ()
    at_shaker: tuple[Attachment, ...] = ()
    absorbers: tuple[Absorber, ...] = ()
    dampers: tuple[Damper, ...] = ()
    elements: tuple[Callable[[CantileverBeam], Element], ...] = ()
    drag: Drag | None = None
    side_modes: tuple[SideFamily, ...] = ()
    drift: float = 0.0
    drift_s: float = DRIFT_S


@dataclass(frozen=True, slots=True)
class ClippedRow:
    """A row cut at a fraction of what it reaches; `peak_v` where that is known."""

    row: int
    fraction: float
    peak_v: float | None


@dataclass(frozen=True, eq=False, slots=True)
class ChainChanges:
    """What is other than believed between the motion and the counts. Rows are numbered as in the rig, 0 the force.

    Attributes:
        exchanged: pairs of rows whose sensors are exchanged.
        moved_m: row -> how much farther from the clamp its sensor sits.
        filters: what a row's accelerometer passes, in this order; None for all rows.
        gain: row -> factor on a response.
        force_gain: factor on the force.
        skew_s: row k is sampled k times that much later than row 0.
        delay_s: how much later than the force all responses are sampled.
        noise: row -> factor on its noise.
        clips: rows cut at a level.
        knee_v: row -> towards which it saturates softly.
        curves: row -> what it reads of what it would read, both in V.
        lost_share: row -> of its samples.
        holds: rows that read the sample before in place of a lost one; others read 0.
        jitter_s: standard deviation of every instant.
        hum: volts and frequency in Hz of the mains; None without.
        clock: relative error of the converter's rate.
    """

    exchanged: tuple[tuple[int, int], ...] = ()
    moved_m: Rows = field(default_factory=_no_rows)
    filters: tuple[tuple[int | None, SensorTransfer], ...] = ()
    gain: Rows = field(default_factory=_no_rows)
    force_gain: float = 1.0
    skew_s: float = 0.0
    delay_s: float = 0.0
    noise: Rows = field(default_factory=_no_rows)
    clips: tuple[ClippedRow, ...] = ()
    knee_v: Rows = field(default_factory=_no_rows)
    curves: Mapping[int, Callable[[Real], Real]] = field(default_factory=_no_curves)
    lost_share: Rows = field(default_factory=_no_rows)
    holds: frozenset[int] = frozenset()
    jitter_s: float = 0.0
    hum: tuple[float, float] | None = None
    clock: float = 0.0


@dataclass(frozen=True, slots=True)
class ExcitationChanges:
    """What is other than believed about the forces.

    Attributes:
        hit_shift_m: how much farther from the clamp every hit lands.
        ringing: size of the knock before each hit that the transducer does not feel, in hits.
        harmonics: share of overtones the power amplifier adds.
        floor_rms: acceleration of the base in m/s^2.
        scatter_m: standard deviation of the place of each hit.
        gain_scatter: the same, relative, of what the beam gets of it over what the transducer feels.
    """

    hit_shift_m: float = 0.0
    ringing: float = 0.0
    harmonics: float = 0.0
    floor_rms: float = 0.0
    scatter_m: float = 0.0
    gain_scatter: float = 0.0


@dataclass(frozen=True, eq=False, slots=True)
class AlteredBench:
    """The bench as effects leave it."""

    structure: StructureChanges = field(default_factory=StructureChanges)
    chain: ChainChanges = field(default_factory=ChainChanges)
    excitation: ExcitationChanges = field(default_factory=ExcitationChanges)


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
