"""What to do on the bench, as data."""

from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import Field, PositiveFloat, PositiveInt

from modallab.core.frozen import Frozen, Truth, is_not_stated
from modallab.core.units import Broadband, Test

BLOCK_S = 1.024
"""The paper's block, which sets df = 0.9766 Hz."""

PAPER_LINES = (3, 4, 5, 6, 8, 12, 18, 24, 28, 30, 31, 32, 33, 35, 40, 50, 60, 72, 84, 88, 90, 92, 96, 108)
"""24 multiples of df in the paper's band of 3 to 110 Hz, closer together about the three modes."""


class HitAcceptance(Frozen):
    """Limits for the acceptance of a hit. Each rejection states its value.

    The wait for rest ends when the remaining motion is below `max_residual_ratio` times that of the expected hit.
    With `check_point` a hit that fits another point is rejected.

    Attributes:
        min_force_n: smallest peak of the force.
        max_force_n: largest peak of the force.
        double_hit_ratio: largest second contact, relative to the first.
        max_contact_s: longest contact.
        max_residual_ratio: largest motion before the hit, relative to that of the hit.
        min_band_hz: frequency up to which a hit must excite.
        band_drop_db: largest fall of the force spectrum up to `min_band_hz`.
        check_point: whether a hit that looks like one at another point is rejected.
    """

    min_force_n: PositiveFloat = 10.0
    max_force_n: PositiveFloat = 480.0
    double_hit_ratio: Annotated[float, Field(gt=0, lt=1)] = 0.05
    max_contact_s: PositiveFloat = 0.02
    max_residual_ratio: PositiveFloat = 0.01
    min_band_hz: PositiveFloat = 110.0
    band_drop_db: PositiveFloat = 20.0
    check_point: Truth = True


class SetUp(Frozen):
    """Places of the sensors in a part of a test.

    Attributes:
        name: name of the set-up, unique in its plan.
        points: point by channel name; other sensors stay as in the rig file.
    """

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]{0,31}$")]
    points: dict[str, PositiveInt] = Field(default_factory=dict)


class Precision(Frozen):
    """Target uncertainty of the modes; a test may end once it is reached.

    Attributes:
        frequency_ratio: relative standard deviation of every natural frequency.
        damping_ratio: relative standard deviation of every damping ratio.
    """

    frequency_ratio: Annotated[float, Field(gt=0, lt=1)] = 0.0001
    damping_ratio: Annotated[float, Field(gt=0, lt=1)] = 0.01


class ImpactPlan(Frozen):
    """An impact test: a number of good hits at each point.

    `rate_hz` is set on the device, which may give a higher rate; blocks have the whole number of samples nearest
    to `block_s`. With `delivered_hz` blocks are resampled to exactly that rate at reading. Software triggers on the
    continuous stream; `hardware` uses the device's own reference trigger. With `setups` all points are struck in
    every set-up, each a run of its own. `operator_decides` selects hits for the operator's decision, for which the run
    waits.

    Attributes:
        points: points to hit, in this order.
        hits: number of good hits at each point.
        rate_hz: sampling rate to set on the device.
        delivered_hz: sampling rate of the stored blocks (default: that of the device).
        block_s: length of a block.
        pre_trigger_s: part of the block before the hit.
        trigger_n: force of the trigger.
        hysteresis_n: drop of the force below the trigger before the next trigger.
        trigger: software, on the continuous samples; or hardware, in the device.
        hit_timeout_s: longest wait for rest of the structure, and for a hit.
        max_rejections: number of rejected hits at one point that ends the run.
        acceptance: limits for the acceptance of a hit.
        setups: places of the sensors in each set-up (default: those of the rig file).
        operator_decides: hits for which the operator is asked for a decision.
        precision: target uncertainty of the modes, reported to the operator when reached; None: no target.
    """

    renamed: ClassVar[Mapping[str, str]] = {"max_refusals": "max_rejections"}

    kind: Literal["impact"] = "impact"
    points: Annotated[tuple[PositiveInt, ...], Field(min_length=1)]
    hits: PositiveInt = 5
    rate_hz: PositiveFloat = 2000.0
    delivered_hz: PositiveFloat | None = None
    block_s: PositiveFloat = BLOCK_S
    pre_trigger_s: PositiveFloat = 0.05
    trigger_n: PositiveFloat = 2.0
    hysteresis_n: PositiveFloat = 1.0
    trigger: Literal["software", "hardware"] = "software"
    hit_timeout_s: PositiveFloat = 300.0
    max_rejections: PositiveInt = 20
    acceptance: HitAcceptance = HitAcceptance()
    setups: tuple[SetUp, ...] = Field(default=(), exclude_if=is_not_stated)
    operator_decides: Literal["never", "rejected", "every"] = Field(default="never", exclude_if=lambda v: v == "never")
    precision: Precision | None = Field(default=None, exclude_if=is_not_stated)


class KnownMode(Frozen):
    """A known mode of the structure, to predict its free decay.

    Attributes:
        frequency_hz: undamped natural frequency.
        damping_ratio: zeta.
    """

    frequency_hz: PositiveFloat
    damping_ratio: Annotated[float, Field(gt=0, lt=1)]


class ForceControl(Frozen):
    """Force amplitude of each level. The drive is corrected between bursts, never within one.

    Attributes:
        levels_n: force in N by level; `levels_v` gives the first drive of each level.
        tolerance: relative tolerance of the force.
        max_bursts: largest number of bursts for each frequency; the last one counts, and is flagged if its force is
            off.
    """

    levels_n: Annotated[dict[str, PositiveFloat], Field(min_length=1)]
    tolerance: Annotated[float, Field(gt=0, lt=1)] = 0.05
    max_bursts: PositiveInt = 4


class SinePlan(Frozen):
    """A stepped sine test: one burst per frequency and level, each from rest, each ending at exactly 0 V.

    Rates are as in the impact test. With `modes`, every block is tested for their free decays. An unsettled block is
    recorded again with a longer burst, up to `max_settle_s`, and flagged after that.

    Attributes:
        frequencies_hz: drive frequencies, preferably on lines of the block.
        levels_v: amplitude of the drive by level.
        sweep: order of the frequencies: as given, upwards, downwards, or both in turn.
        rate_hz: sampling rate to set on the device.
        delivered_hz: sampling rate of the stored blocks (default: that of the device).
        block_s: length of a block.
        ramp_s: length of the cosine taper at both ends of a burst.
        settle_s: time from the start of a burst to its block.
        max_settle_s: longest time from the start of a burst to its block (default: `settle_s`, so that no burst is
            lengthened).
        modes: modes whose decays are checked; empty: settling is not judged.
        settled_ratio: largest decay of a settled block, relative to the response.
        wait_s: shortest pause after each burst.
        settle_timeout_s: time after which a burst starts although the beam still moves, which is noted in the block.
        force: force amplitude instead of a constant drive.
    """

    renamed: ClassVar[Mapping[str, str]] = {"rest_s": "wait_s", "rest_timeout_s": "settle_timeout_s"}

    kind: Literal["sine"] = "sine"
    frequencies_hz: Annotated[tuple[PositiveFloat, ...], Field(min_length=1)] = tuple(n / BLOCK_S for n in PAPER_LINES)
    levels_v: Annotated[dict[str, PositiveFloat], Field(min_length=1)] = Field(default_factory=lambda: {"low": 0.5})
    sweep: Literal["given", "up", "down", "up-down"] = "given"
    rate_hz: PositiveFloat = 1000.0
    delivered_hz: PositiveFloat | None = None
    block_s: PositiveFloat = BLOCK_S
    ramp_s: PositiveFloat = 1.0
    settle_s: PositiveFloat = 8.0
    max_settle_s: PositiveFloat | None = None
    modes: tuple[KnownMode, ...] = ()
    settled_ratio: Annotated[float, Field(gt=0, lt=1)] = 0.005
    wait_s: PositiveFloat = 10.0
    settle_timeout_s: PositiveFloat = 60.0
    force: ForceControl | None = None


class BroadbandPlan(Frozen):
    """A broadband test: the shaker plays a finite wave, of which blocks are recorded one after another.

    `pseudo-random` and `chirp` repeat with every block, so that a settled block holds whole periods. `burst-random`
    ends within its block, and the decay with it, if the block is long enough. `random` never repeats.

    Attributes:
        signal: kind of signal.
        band_hz: lowest and highest frequency driven.
        levels_v: rms of the drive by level, while it is on; its peak must stay within the rig's limits.
        blocks: number of blocks at each level.
        blocks_per_wave: largest number of blocks in a wave; another wave with other phases follows. None: as many as
            fit.
        shakers: only the first shaker of the rig, or all at once, each with its own wave: independent random drives,
            or periodic drives with phases turned from wave to wave.
        detection_lines: leave out all even lines of a pseudo-random drive, and one of every four odd lines, a
            different one in each wave. Responses at these lines are distortion.
        seed: seed of the random phases; each wave of a test has its own.
        burst_share: share of a block in which a burst-random drive is on.
        rate_hz: sampling rate to set on the device.
        delivered_hz: sampling rate of the stored blocks (default: that of the device).
        block_s: length of a block, and the period of `pseudo-random` and `chirp`.
        ramp_s: length of the cosine taper at both ends of a wave.
        settle_s: time from the start of a wave to its first block.
        wait_s: shortest pause after each wave.
        max_rejections: number of overloaded blocks that ends the run.
    """

    kind: Literal["broadband"] = "broadband"
    signal: Broadband = "pseudo-random"
    band_hz: tuple[PositiveFloat, PositiveFloat] = (2.0, 400.0)
    levels_v: Annotated[dict[str, PositiveFloat], Field(min_length=1)] = Field(default_factory=lambda: {"low": 0.5})
    blocks: PositiveInt = 10
    blocks_per_wave: PositiveInt | None = None
    shakers: Literal["first", "all"] = Field(default="first", exclude_if=lambda v: v == "first")
    detection_lines: Annotated[bool, Field(strict=True)] = False
    seed: Annotated[int, Field(ge=0, strict=True)] = 1
    burst_share: Annotated[float, Field(gt=0, lt=1)] = 0.3
    rate_hz: PositiveFloat = 2000.0
    delivered_hz: PositiveFloat | None = None
    block_s: PositiveFloat = BLOCK_S
    ramp_s: PositiveFloat = 0.5
    settle_s: PositiveFloat = 8.0
    wait_s: PositiveFloat = 10.0
    max_rejections: PositiveInt = 20


def test_of_plan(plan: "ImpactPlan | SinePlan | BroadbandPlan") -> Test:
    """Which test the records of a plan belong to."""
    return plan.signal if isinstance(plan, BroadbandPlan) else plan.kind


def lowest_rate_hz(plan: "ImpactPlan | SinePlan | BroadbandPlan") -> float:
    """The lowest rate the samples of a plan pass through."""
    return min(plan.rate_hz, plan.delivered_hz or plan.rate_hz)


Plan = Annotated[ImpactPlan | SinePlan | BroadbandPlan, Field(discriminator="kind")]
