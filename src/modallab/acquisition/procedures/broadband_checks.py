"""What rig and bench do not allow of a broadband test: each of its waves is looked at before anything moves."""

from collections.abc import Sequence
from math import inf

from modallab.acquisition.procedures.broadband_wave import (
    blocks_a_wave,
    blocks_of_wave,
    is_periodic,
    layout_of,
    peak_v,
    slew_v_per_s,
    waves_of,
)
from modallab.bench.capabilities import DrivesSeveralShakers, PlaysWaves
from modallab.bench.protocol import Waveform
from modallab.core.errors import UnsupportedError
from modallab.core.plan import BroadbandPlan
from modallab.core.rig import Limits, Rig


def driven_points(plan: BroadbandPlan, rig: Rig) -> tuple[int, ...]:
    """Where the shakers stand that a plan drives, in the order of `Rig.forces`."""
    return rig.shaker_points if plan.shakers == "all" else rig.shaker_points[:1]


def longest_wave_s(plan: BroadbandPlan, rig: Rig) -> float:
    """How long the longest wave of a plan lasts, from 0 V to 0 V."""
    fitting = blocks_a_wave(plan, inf if rig.limits is None else rig.limits.max_burst_s)
    return layout_of(plan, _blocks_of_each_wave(plan, fitting, len(driven_points(plan, rig)))[0], plan.block_s).end_s


def wave_problems(plan: BroadbandPlan, limits: Limits, shakers: int) -> list[str]:
    """What does not go together in a plan for so many shakers, and what the rig's limits do not allow of its waves."""
    fitting = blocks_a_wave(plan, limits.max_burst_s)
    least = 2 if shakers > 1 and is_periodic(plan) else 1
    problems = _too_few(plan, shakers)
    if not problems and fitting < least:
        lasts_s = layout_of(plan, least, plan.block_s).end_s
        problems = [
            f"a wave of {_blocks_in_words(least)} lasts {lasts_s:.4g} s; allowed by the rig: {limits.max_burst_s:g} s"
        ]
    if problems:
        return problems
    sizes = _blocks_of_each_wave(plan, fitting, shakers)
    layouts = [layout_of(plan, size, plan.block_s) for size in sizes]
    for level in plan.levels_v:
        played = [waves_of(plan, level, number, layout, shakers) for number, layout in enumerate(layouts)]
        # One shaker's are named by their level alone, as there is no other.
        for shaker, waves in enumerate(zip(*played, strict=True)):
            which = f", shaker {shaker + 1}" if shakers > 1 else ""
            problems += over_limits(f"levels_v: {level}{which}", waves, limits)
    return problems


def _blocks_of_each_wave(plan: BroadbandPlan, most: int, shakers: int) -> list[int]:
    """Blocks of each wave of a level."""
    sizes: list[int] = []
    while most and sum(sizes) < plan.blocks:
        sizes.append(blocks_of_wave(plan, len(sizes), plan.blocks - sum(sizes), most, shakers))
    return sizes or [0]


def _blocks_in_words(count: int) -> str:
    return "one block" if count == 1 else f"{count} blocks"


def over_limits(what: str, waves: Sequence[Waveform], limits: Limits) -> list[str]:
    """What the rig's limits do not allow of some waves, with the number."""
    peak, slew = max(map(peak_v, waves)), max(map(slew_v_per_s, waves))
    found = [
        (f"{what} has a peak of {peak:.4g} V; allowed by the rig: {limits.drive_v:g} V", peak > limits.drive_v),
        (f"{what} slews {slew:.4g} V/s; allowed by the rig: {limits.slew_v_per_s:g} V/s", slew > limits.slew_v_per_s),
    ]
    return [text for text, over in found if over]


def _too_few(plan: BroadbandPlan, shakers: int) -> list[str]:
    """What keeps the forces of several shakers from being distinguished."""
    if shakers < 2:
        return []
    problems: list[str] = []
    if plan.detection_lines:
        problems.append(
            "detection_lines: a line that is left out shows nothing with several shakers; allowed: with one shaker"
        )
    # A periodic wave shows by its second block that it is one, and what is noise.
    least = 2 * shakers if is_periodic(plan) else shakers + 1
    if plan.blocks < least:
        each = f", two in each of {shakers} waves" if is_periodic(plan) else ""
        problems.append(
            f"blocks: {plan.blocks} cannot separate {shakers} shakers and the noise; allowed: {least} or more{each}"
        )
    if is_periodic(plan) and plan.blocks_per_wave == 1:
        problems.append("blocks_per_wave: 1 of a periodic drive shows no noise; allowed: 2 or more for several shakers")
    return problems


def require_waves(plan: BroadbandPlan, bench: object, rig: Rig) -> None:
    """Reject a bench that cannot play the waves of a plan, before anything moves.

    Raises:
        UnsupportedError: it cannot.
    """
    generator = rig.excitation is not None and rig.excitation.kind == "generator"
    if generator or not isinstance(bench, PlaysWaves):
        raise UnsupportedError(
            f"{'a sine generator' if generator else 'this bench'} plays no {plan.signal} drive",
            where="broadband plan",
            remedy="drive by an analog output of the device, or run a sine test",
        )
    shakers = len(driven_points(plan, rig))
    if shakers > 1 and not isinstance(bench, DrivesSeveralShakers):
        raise UnsupportedError(
            f"this bench drives one shaker, and the plan drives {shakers} at once",
            where="broadband plan",
            remedy="leave out shakers: all, or use a device with an output for each",
        )
