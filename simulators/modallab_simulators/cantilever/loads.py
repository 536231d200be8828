"""What goes into a structure in time and what comes out of it: loads, outputs, stretches."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, Protocol

from modallab.core.arrays import Complex128, Real
from modallab_simulators.cantilever.sensor import SensorTransfer

BLOCK = 960
"""Delivered samples in one stretch: with the filter's length it fills an FFT of 1024."""

_PLAIN = SensorTransfer()

Load = Literal["force", "moment", "base", "spread"]


@dataclass(frozen=True, eq=False, slots=True)
class DistributedLoad:
    """A load spread along the beam.

    Attributes:
        psi: what it puts into each oscillator, (modes,).
        rest: what all modes beyond add statically at each output's place, (outputs,).
    """

    psi: Real | Complex128
    rest: Real


@dataclass(frozen=True, slots=True)
class SensorOutput:
    """What one channel sees.

    Attributes:
        kind: the motion of a point, the force, or the generator's voltage.
        x_m: where, for a motion.
        order: derivative of the displacement: 0, 1 or 2.
        later_s: how much later than the force it is sampled.
        sensor: what becomes of the motion before it is volts.
        shaker: whose force or voltage, from 0; the first one's transducer is the hammer's as well.
    """

    kind: Literal["motion", "force", "voltage"]
    x_m: float = 0.0
    order: int = 0
    later_s: float = 0.0
    sensor: SensorTransfer = _PLAIN
    shaker: int = 0


@dataclass(frozen=True, eq=False, slots=True)
class BeamLoad:
    """A load on the beam.

    Attributes:
        x_m: where.
        force_n: on the internal samples of `Structure.times`; of a moment in N m, of the base in m/s^2.
        volts_per_n: of the generator behind it; 0 for a hammer.
        load: a force, a moment, an acceleration of the base, or a load spread along the beam.
        seen: whether a force transducer feels it.
        spread: which, if it is.
        shaker: whose transducer feels it, from 0.
    """

    x_m: float
    force_n: Real
    volts_per_n: float = 0.0
    load: Load = "force"
    seen: bool = True
    spread: DistributedLoad | None = None
    shaker: int = 0


class MovingStructure(Protocol):
    """A structure in time, with a state of whatever kind."""

    @property
    def oversample(self) -> int:
        """Internal samples per delivered one."""
        ...

    @property
    def force_delay(self) -> int:
        """Delivered samples by which the force is delayed."""
        ...

    @property
    def at_rest(self) -> Any:
        """The state of a beam that has never moved."""
        ...

    def state_from(self, other: Any, state: Any) -> Any:
        """This structure's state where every mode moves as another's does."""
        ...

    def times(self, block: int) -> tuple[int, int]:
        """First internal sample and number of those whose force a stretch needs."""
        ...

    def advance(self, state: Any, drives: Sequence[BeamLoad]) -> tuple[Real, Any]:
        """Filtered outputs of one stretch in SI units, (outputs, BLOCK), and the state for the next."""
        ...

    def skip(self, state: Any, drives: Sequence[BeamLoad]) -> Any:
        """The state after a stretch of which nobody wants the outputs."""
        ...
