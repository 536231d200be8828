"""What is wrong with a plan on a rig and a bench: all of it at once, before anything moves."""

from math import pi

from modallab.acquisition.procedures.broadband_checks import driven_points, wave_problems
from modallab.acquisition.procedures.broadband_wave import GROUP
from modallab.acquisition.procedures.burst import HEADROOM, longest_burst_s
from modallab.acquisition.procedures.target import sine_record_name
from modallab.bench.protocol import BenchInfo
from modallab.core.errors import PlanError
from modallab.core.hardware import require_guarded
from modallab.core.plan import BroadbandPlan, ImpactPlan, Plan, SinePlan, lowest_rate_hz, test_of_plan
from modallab.core.rig import Limits, Rig
from modallab.core.setups import rig_in_set_up, sensor_moves, setup_problems

LEAST_LINES = 8

USABLE_BAND = 0.4
"""Anti-alias filters hold the relation between channels up to this part of the rate."""


def require_possible(plan: Plan, rig: Rig, bench: BenchInfo) -> None:
    """Reject a plan that cannot or must not be run.

    Raises:
        PlanError: one message with every problem.
        RigError: a channel has no sensitivity for this test.
        ConfigurationError: nothing would end a burst should this machine die in it.
    """
    for channel in rig.channels:
        channel.sensitivity(test_of_plan(plan))
    if not isinstance(plan, ImpactPlan) and bench.streams_bursts:
        require_guarded(rig.excitation, "rig file")
    if isinstance(plan, ImpactPlan):
        problems = _impact_problems(plan, rig)
    elif isinstance(plan, BroadbandPlan):
        problems = _broadband_problems(plan, rig, bench.can_drive)
    else:
        problems = _sine_problems(plan, rig, bench.can_drive)
    if problems:
        raise PlanError("; ".join(problems), where=f"{plan.kind} plan", remedy="change the plan or the rig file")


def _impact_problems(plan: ImpactPlan, rig: Rig) -> list[str]:
    known = {point.id for point in rig.points}
    accept = plan.acceptance
    problems = [f"points: {p} is not on the rig, which has {sorted(known)}" for p in plan.points if p not in known]
    problems += [f"points: {p} occurs twice" for p in sorted({p for p in plan.points if plan.points.count(p) > 1})]
    if plan.hysteresis_n >= plan.trigger_n:
        problems.append(f"hysteresis_n is {plan.hysteresis_n:g}; allowed: less than trigger_n = {plan.trigger_n:g}")
    if plan.trigger_n > accept.min_force_n:
        problems.append(f"trigger_n is {plan.trigger_n:g}; allowed: up to min_force_n = {accept.min_force_n:g}")
    if accept.min_force_n >= accept.max_force_n:
        problems.append(f"min_force_n is {accept.min_force_n:g}; allowed: less than max_force_n")
    if plan.pre_trigger_s >= plan.block_s / 2:
        problems.append(f"pre_trigger_s is {plan.pre_trigger_s:g}; allowed: less than half of block_s = {plan.block_s}")
    if accept.min_band_hz > USABLE_BAND * lowest_rate_hz(plan):
        problems.append(_too_high("min_band_hz", accept.min_band_hz, lowest_rate_hz(plan)))
    return [*problems, *_setup_problems(plan, rig)]


def _setup_problems(plan: ImpactPlan, rig: Rig) -> list[str]:
    problems = setup_problems(plan, rig)
    if problems or not plan.setups:
        return problems
    if len(plan.setups) > 1:
        return [f"setups: {len(plan.setups)} in one run; allowed: one; modallab campaign run runs several in turn"]
    return [
        f"setups: {setup.name} has {move.channel} at point {move.after}, the rig at {move.before};"
        " allowed: the places of the set-up"
        for setup in plan.setups
        for move in sensor_moves(rig, rig_in_set_up(rig, setup))
    ]


def _drive_problems(plan: SinePlan | BroadbandPlan, rig: Rig, can_drive: bool) -> list[str]:
    problems: list[str] = []
    if not can_drive:
        problems.append("this bench has no excitation output")
    if rig.shaker_point is None:
        problems.append("the rig names no shaker_point")
    if plan.settle_s < plan.ramp_s:
        problems.append(f"settle_s is {plan.settle_s:g}; allowed: at least ramp_s = {plan.ramp_s:g}")
    return problems


def _sine_problems(plan: SinePlan, rig: Rig, can_drive: bool) -> list[str]:
    problems = _drive_problems(plan, rig, can_drive)
    names = [sine_record_name("", f) for f in plan.frequencies_hz]
    problems += [
        f"frequencies_hz: {f:.3f} Hz occurs twice"
        for n, f in enumerate(plan.frequencies_hz)
        if sine_record_name("", f) in names[:n]
    ]
    problems += [
        _too_high("frequencies_hz", f, lowest_rate_hz(plan))
        for f in plan.frequencies_hz
        if f > USABLE_BAND * lowest_rate_hz(plan)
    ]
    problems += _settle_problems(plan)
    if rig.limits is None:
        return [*problems, "the rig has no limits, and without them nothing is driven"]
    return [*problems, *_limit_problems(plan, rig.limits), *_stroke_problems(rig, rig.limits)]


def _broadband_problems(plan: BroadbandPlan, rig: Rig, can_drive: bool) -> list[str]:
    problems = _drive_problems(plan, rig, can_drive)
    low, high = plan.band_hz
    if low + LEAST_LINES / plan.block_s > high:
        problems.append(f"band_hz: {low:g} to {high:g} Hz; allowed: at least {LEAST_LINES} lines of a block wide")
    if high > USABLE_BAND * lowest_rate_hz(plan):
        problems.append(_too_high("band_hz", high, lowest_rate_hz(plan)))
    problems += _detection_problems(plan)
    if rig.limits is None:
        return [*problems, "the rig has no limits, and without them nothing is driven"]
    problems += _stroke_problems(rig, rig.limits)
    return problems or wave_problems(plan, rig.limits, len(driven_points(plan, rig)))


def _detection_problems(plan: BroadbandPlan) -> list[str]:
    if not plan.detection_lines:
        return []
    if plan.signal != "pseudo-random":
        return [f"detection_lines: a {plan.signal} drive leaves no lines out; allowed: with signal: pseudo-random"]
    each = plan.blocks_per_wave or 0
    if each < 2 or plan.blocks < GROUP * each or plan.blocks % each:
        return [
            f"detection_lines: {plan.blocks} blocks, {each or 'as many as fit'} in a wave; allowed: blocks_per_wave"
            f" of 2 or more, and blocks {GROUP} times as many or another multiple above it"
        ]
    return []


def _limit_problems(plan: SinePlan, limits: Limits) -> list[str]:
    problems: list[str] = []
    for level, volts in plan.levels_v.items():
        if volts > limits.drive_v:
            problems.append(f"levels_v: {level} is {volts:g} V; allowed by the rig: {limits.drive_v:g} V")
        highest = max(plan.frequencies_hz)
        slew = 2 * pi * highest * volts
        if slew > limits.slew_v_per_s:
            problems.append(
                f"levels_v: {level} at {highest:.3f} Hz slews {slew:.4g} V/s;"
                f" allowed by the rig: {limits.slew_v_per_s:g} V/s"
            )
    problems += _force_problems(plan, limits)
    duration = longest_burst_s(plan)
    if duration > limits.max_burst_s:
        longest = "settle_s" if plan.max_settle_s is None else "max_settle_s"
        problems.append(
            f"a burst of {longest}, block_s and ramp_s lasts {duration:.4g} s;"
            f" allowed by the rig: {limits.max_burst_s:g} s"
        )
    return problems


def _stroke_problems(rig: Rig, limits: Limits) -> list[str]:
    moved = {c.point for c in rig.responses if c.quantity != "voltage"}
    unseen = [point for point in rig.shaker_points if point not in moved]
    if limits.stroke_m is None or not unseen:
        return []
    listed = ", ".join(map(str, unseen))
    return [
        f"limits.stroke_m: no response at the shaker point {listed} measures the stroke; allowed: with a response there"
    ]


def _settle_problems(plan: SinePlan) -> list[str]:
    if plan.max_settle_s is None:
        return []
    problems: list[str] = []
    if plan.max_settle_s < plan.settle_s:
        problems.append(f"max_settle_s is {plan.max_settle_s:g}; allowed: at least settle_s = {plan.settle_s:g}")
    if not plan.modes:
        problems.append("max_settle_s needs modes, whose decays show when a block has settled")
    return problems


def _force_problems(plan: SinePlan, limits: Limits) -> list[str]:
    if plan.force is None:
        return []
    problems: list[str] = []
    if set(plan.force.levels_n) != set(plan.levels_v):
        problems.append(
            f"force.levels_n: {', '.join(plan.force.levels_n)}; allowed: the levels of levels_v, whose drive each "
            "begins"
            f" with: {', '.join(plan.levels_v)}"
        )
    most = HEADROOM * limits.force_n
    problems += [
        f"force.levels_n: {level} is {force:g} N; allowed: up to {HEADROOM:g} of the rig's limit, {most:g} N"
        for level, force in plan.force.levels_n.items()
        if force > most
    ]
    return problems


def _too_high(name: str, value_hz: float, rate_hz: float) -> str:
    return f"{name}: {value_hz:g} Hz; allowed: up to {USABLE_BAND} of the rate, {USABLE_BAND * rate_hz:g} Hz"
