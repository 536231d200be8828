"""One burst of a sine test: how long, how hard, and what its block shows."""

from dataclasses import dataclass, field
from math import inf, isfinite, pi

import numpy as np

from modallab.acquisition.monitor.burst_watch import BurstWatch
from modallab.acquisition.monitor.context import RunContext
from modallab.acquisition.procedures.settling import Settled, SettlingFit, amplitude_at, fit_settling
from modallab.bench.protocol import Burst
from modallab.core.errors import SafetyError
from modallab.core.plan import SinePlan
from modallab.core.rig import Limits
from modallab.storage import BlockNote

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
class SineDrive:
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

    def force_error(self, level: str, measured: MeasuredBurst) -> str:
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
        if control is None or not self.force_error(level, measured):
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

    def remember_good_voltage(self, level: str, measured: MeasuredBurst) -> None:
        """Remember what was good here for the next frequency."""
        self.last_v[level] = measured.volts

    def _allowed_v(self, frequency_hz: float) -> float:
        return min(self.limits.drive_v, self.limits.slew_v_per_s / (2 * pi * frequency_hz))


HOLD_MARGIN_S = 0.1
"""Past the block's end: a converter delays its samples by up to some 40 periods of its rate."""

FIT_BLOCKS = 5
"""The stretch a settling fit looks at, at most; as long as the stream remembers it."""


@dataclass(frozen=True, slots=True)
class BurstSetting:
    """What a burst is set to.

    Attributes:
        volts: amplitude of the drive.
        settle_s: from its start to its block.
        number: of bursts at this step, from 1.
    """

    volts: float
    settle_s: float
    number: int = 1


@dataclass(frozen=True, slots=True)
class BurstCheck:
    """What a burst's block shows.

    Attributes:
        measured: force and the part of the limits that was used.
        settled: whether the decays are gone; "" where that is not judged.
        further_wait_s: how much longer to wait for it.
        unsettled: in words, if it has not settled.
        facts: for the catalogue.
    """

    measured: MeasuredBurst
    settled: Settled | str = ""
    further_wait_s: float = 0.0
    unsettled: str = ""
    facts: dict[str, float | str] = field(default_factory=dict[str, float | str])


def burst_of(plan: SinePlan, frequency_hz: float, amplitude_v: float, settle_s: float | None = None) -> Burst:
    """The burst whose settled part holds the block."""
    settle = plan.settle_s if settle_s is None else settle_s
    return Burst(frequency_hz, amplitude_v, plan.ramp_s, settle - plan.ramp_s + plan.block_s + HOLD_MARGIN_S)


def longest_burst_s(plan: SinePlan) -> float:
    """How long the longest burst of a plan may last, from 0 V to 0 V."""
    return burst_of(plan, 1.0, 1.0, max(plan.settle_s, plan.max_settle_s or 0.0)).duration_s


def time_to_end_of_burst_s(plan: SinePlan) -> float:
    """From the end of a block to the end of its burst."""
    return HOLD_MARGIN_S + plan.ramp_s


def check_burst(
    context: RunContext, plan: SinePlan, watch: BurstWatch, note: BlockNote, setting: BurstSetting
) -> BurstCheck:
    """Look at the block that has just been read."""
    block = context.stream.copy_samples(note.first_sample, context.block)
    force_n = context.conversion.force_n(block)
    assert note.frequency_hz is not None
    measured = MeasuredBurst(
        volts=setting.volts,
        force_n=amplitude_at(force_n, context.stream.rate_hz, note.frequency_hz),
        used=float(watch.share_of_limit(block)),
    )
    facts: dict[str, float | str] = {"force_n": measured.force_n, "limit_used": measured.used}
    settling = _settling(context, plan, note, setting) if plan.modes else None
    if settling is None:
        return BurstCheck(measured, facts=facts)
    verdict = settling.verdict(plan.settled_ratio)
    return BurstCheck(
        measured,
        verdict,
        settling.further_wait_s(plan.settled_ratio),
        _unsettled_reason(settling, plan) if verdict == "no" else "",
        facts | settling.facts(plan.settled_ratio),
    )


def _settling(context: RunContext, plan: SinePlan, note: BlockNote, setting: BurstSetting) -> SettlingFit | None:
    rate_hz = context.stream.rate_hz
    # Only what lies between the two ramps is a steady sine.
    steady = int((setting.settle_s - plan.ramp_s) * rate_hz)
    before = max(0, min(steady, (FIT_BLOCKS - 1) * context.block))
    samples = context.stream.copy_samples(note.first_sample - before, before + context.block)
    motion = list(context.conversion.motion)
    values = samples[motion] * context.conversion.si_per_count[motion, None]
    assert note.frequency_hz is not None
    return fit_settling(
        context.conversion.force_n(samples), values.astype(np.float64), rate_hz, before, note.frequency_hz, plan.modes
    )


def _unsettled_reason(settling: SettlingFit, plan: SinePlan) -> str:
    worst = int(np.argmax(settling.ratio))
    return (
        f"not settled: the free decay at {settling.mode_hz[worst]:.4g} Hz is {100 * settling.total_decay:.3g} % of the "
        "response,"
        f" at most {100 * plan.settled_ratio:g} %"
    )
