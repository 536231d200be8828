"""How a diagnosis begins: what may be fitted with which weights, and the gap before anything is explained."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace

from modallab.core.block import Block, Campaign
from modallab.core.hold_out import HoldOut
from modallab.gap.conditioning.overtones import harmonics_of_sines
from modallab.gap.conditioning.prepare import PreparedCampaign, prepare_campaign
from modallab.gap.conditioning.records import records_as_recorded, split_held_out
from modallab.gap.conditioning.reduce import reduce_blocks, select_lines, sine_clock
from modallab.gap.conditioning.rows import Reduced, Weights
from modallab.gap.inference.baseline import baseline
from modallab.gap.inference.identified import identify_hit_modes
from modallab.gap.inference.settings import DEFAULT
from modallab.gap.model.nuisances import Nuisances, nuisances
from modallab.gap.model.tolerances import with_tolerances
from modallab.gap.model.twin_of_fit import twin_of
from modallab.gap.report.effect_inspection import inspect_effects, is_in_revisions
from modallab.gap.report.measure import SquaredResiduals, squared_residuals
from modallab.gap.search.fitting import FLOOR_MARGIN, Bench
from modallab.twin.bench import Twin

TOP_HZ = 650.0
"""Each mode up to this frequency has its own damping ratio."""

NOT_BETTER = 1.3
"""Rms residual that counts as the floor where the base shakes or the beam still rings."""


def gap_without_effects(campaign: Campaign) -> float:
    """The gap of a campaign in noise units before anything is explained; 1 is the floor.

    Raises:
        DataError: there is nothing to compare.
        RigError: the rig has no beam.
    """
    prepared, twin, _ = _fit_baseline(campaign)
    return squares_as_recorded(prepared, twin).gap


def gap_outside_revisions(campaign: Campaign) -> float:
    """The same of a rig with revisions: what no force predicts, and they know of it, is no gap.

    Raises:
        DataError, RigError: as `gap_without_effects`.
    """
    prepared, twin, data = _fit_baseline(campaign)
    if any(is_in_revisions(found, prepared.campaign.rig) for found in inspect_effects(prepared, twin)):
        return squared_residuals(twin, data).gap
    return squares_as_recorded(prepared, twin).gap


def gap_on_held_out(campaign: Campaign, hold_out: HoldOut) -> float:
    """The same of the records that a rule keeps from the fit, weighed by the noise they have.

    A strained assembly follows the records that it is fitted to, not these. Noise above that of the rig file is no gap
    that an effect of the twin could close.

    Raises:
        DataError, RigError: as `gap_without_effects`.
        PlanError: the rule leaves nothing to fit.
    """
    prepared = prepare_campaign(replace(campaign, rig=with_tolerances(campaign.rig)))
    fitted, held = split_held_out(prepared.blocks, hold_out)
    base = baseline(problem_of_records(prepared, fitted, nuisances_of_campaign(prepared.campaign), lambda _: False))
    unseen = reduce_blocks(prepared.campaign, held or fitted, weights_of(prepared))
    return squared_residuals(twin_of(base, unseen), unseen).gap


def _fit_baseline(campaign: Campaign) -> tuple[PreparedCampaign, Twin, Reduced]:
    prepared = prepare_campaign(replace(campaign, rig=with_tolerances(campaign.rig)))
    bench = problem_of_records(prepared, prepared.blocks, nuisances_of_campaign(prepared.campaign), lambda _: False)
    base = baseline(bench)
    return prepared, base.problem.twin(base.u), bench.data


def nuisances_of_campaign(campaign: Campaign) -> Nuisances:
    """What is free in every fit of a campaign, whichever of its records are held out."""
    rig = campaign.rig
    counts = Counter(b.drive_point for b in campaign.blocks if b.test == "impact")
    hits = [(rig.x_of(point), count) for point, count in sorted(counts.items()) if point is not None]
    return nuisances(rig, TOP_HZ, hits)


def problem_of_records(
    prepared: PreparedCampaign,
    fitted: Sequence[Block],
    free: Nuisances,
    allowed: Callable[[str], bool],
) -> Bench:
    """What a search works on: the records that may be fitted, and what is free."""
    data = reduce_blocks(prepared.campaign, fitted, weights_of(prepared))
    flat = _has_flat_tops(prepared)
    found = tuple(harmonics_of_sines(fitted, prepared.campaign.rig, sine_clock(data)))
    thin = select_lines(data, prepared.poles)
    points = identify_hit_modes(data, fitted, reliable_accelerometers(prepared), DEFAULT.top_hz, prepared.driven.poles)
    return Bench(data, thin, free, prepared.poles, allowed, flat, found, points=points)


def reliable_accelerometers(prepared: PreparedCampaign) -> list[int]:
    """Indices of the accelerometers whose records are neither cut nor noisy: what poles may be taken from."""
    off = {row for _, row in prepared.masked} | set(prepared.noisy)
    return [i for i, c in enumerate(prepared.campaign.rig.responses) if c.index not in off]


def squares_as_recorded(prepared: PreparedCampaign, twin: Twin) -> SquaredResiduals:
    """The records as they came, weighed by the noise the rig file promises."""
    campaign = prepared.campaign
    blocks = records_as_recorded(campaign, prepared.blocks)
    full_scales = frozenset(m for m in prepared.masked if m[1] not in {c.row for c in prepared.clipped})
    return squared_residuals(
        twin, reduce_blocks(campaign, blocks, Weights(prepared.believed_v, full_scales, doubt=prepared.driven.doubt))
    )


def weights_of(prepared: PreparedCampaign) -> Weights:
    """How much each row of the records counts."""
    hz, hum = prepared.hum_below_removal or (0.0, None)
    noise, masked, doubt = prepared.noise_v, prepared.masked, prepared.driven.doubt
    alone = Weights(noise, masked, rising_v2=prepared.rising_v2, hum_v=hum, hum_hz=hz, doubt=doubt)
    floor = prepared.floor
    return alone if floor is None else replace(alone, floor=floor.spectrum, floor_s=floor.block_s)


def _has_flat_tops(prepared: PreparedCampaign) -> float:
    # The spectrum of a shaking floor is known to some 10 %, and what rang before a hit is taken off no better.
    return NOT_BETTER if prepared.floor is not None or prepared.ringing is not None else FLOOR_MARGIN
