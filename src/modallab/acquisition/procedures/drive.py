"""How hard the next burst drives: a constant drive, or one that is corrected towards a force between bursts."""

from dataclasses import dataclass, field
from math import inf, isfinite, pi

from modallab.core.errors import SafetyError
from modallab.core.plan import SinePlan
from modallab.core.rig import Limits

MAX_GROWTH = 3.0
"""A correction multiplies the drive at most by this: what a beam does at three times the force is still foreseeable."""

HEADROOM = 0.8
"""Part of an abort limit up to which a correction may lead, as foreseen from what was measured."""

NO_CHANGE = 0.005
"""A correction smaller than this is none."""


@dataclass(frozen=True, slots=True)
class MeasuredBurst:
    """What a burst gave.

    Attributes:
        volts: the drive's amplitude.
        force_n: the force's amplitude in the block.
        used: largest part of an abort limit that a sample of the block took.
    """

    volts: float
    force_n: float
    used: float


@dataclass(slots=True)
class Drive:
    """The drive of a sine test.

    Attributes:
        plan: levels and, perhaps, forces.
        limits: of the rig.
        last_v: drive that gave the force at the last frequency, by level.
    """

    plan: SinePlan
    limits: Limits
    last_v: dict[str, float] = field(default_factory=dict[str, float])

    def first_v(self, level: str, frequency_hz: float) -> float:
        """To begin a frequency with: never above the plan's own drive, since the beam may answer more than before."""
        return min(self.plan.levels_v[level], self.last_v.get(level, inf), self._allowed_v(frequency_hz))

    def error(self, level: str, measured: MeasuredBurst) -> str:
        """What is wrong with the force of a burst, in words and numbers; empty if nothing."""
        control = self.plan.force
        if control is None:
            return ""
        target_n = control.levels_n[level]
        if abs(measured.force_n / target_n - 1) <= control.tolerance:
            return ""
        return f"force {measured.force_n:.4g} N, {target_n:g} N +- {100 * control.tolerance:g} % was requested"

    def next_v(self, level: str, frequency_hz: float, measured: MeasuredBurst) -> float | None:
        """The drive for another burst; None where no other one may bring the force nearer.

        Raises:
            SafetyError: there is no force to correct by.
        """
        control = self.plan.force
        if control is None or not self.error(level, measured):
            return None
        if not (isfinite(measured.force_n) and measured.force_n > 0):
            raise SafetyError(
                f"the force reads {measured.force_n:g} N at {measured.volts:g} V of drive; nothing more is driven",
                remedy="check the force sensor, its cable and its input",
            )
        factor = min(control.levels_n[level] / measured.force_n, MAX_GROWTH)
        if measured.used > 0:
            factor = min(factor, max(HEADROOM / measured.used, min(factor, 1.0)))
        volts = min(measured.volts * factor, self._allowed_v(frequency_hz))
        return volts if abs(volts / measured.volts - 1) > NO_CHANGE else None

    def good(self, level: str, measured: MeasuredBurst) -> None:
        """Remember what was good here for the next frequency."""
        self.last_v[level] = measured.volts

    def _allowed_v(self, frequency_hz: float) -> float:
        return min(self.limits.drive_v, self.limits.slew_v_per_s / (2 * pi * frequency_hz))
