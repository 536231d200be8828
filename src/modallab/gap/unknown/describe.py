"""What a gap behaves like that no effect explains, and how far that closes it on records that no fit has seen."""

from collections.abc import Iterator, Sequence
from typing import cast

import numpy as np

from modallab.core.diagnosis import GapDescription, Shrinkage
from modallab.core.effect import AlternativeDescription, x_m_of
from modallab.core.effects import Stage
from modallab.core.progress import report_progress
from modallab.core.rig import Rig
from modallab.gap.conditioning.prepare import PreparedCampaign
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.model.twin_of_fit import twin_of
from modallab.gap.report.calibrated import calibrated_twin
from modallab.gap.report.locate import ResidualTestsResult
from modallab.gap.report.measure import shrinkage_with_interval, squared_residuals
from modallab.gap.search.channel_share import channel_share
from modallab.gap.search.choose import Selection
from modallab.gap.search.fitting import Bench, excess_over_floor, search_origin
from modallab.gap.unknown.description import Description, cost_per_number, description_of, rows_of, stage_of
from modallab.gap.unknown.fitted import best_fits
from modallab.gap.unknown.on_beam import operators_on_all_channels, trials_on_beam
from modallab.gap.unknown.on_row import fit_without_channel, linear_operators, sample_operators
from modallab.gap.words.learned import learned_in_words

SEED = 20240503
SOLVED = 0.01
"""Share of the excess at which nothing further is tried."""
PAYS = 0.2
"""Share of the gap on records held out that a description must close to be one."""
ALTERNATIVES = 3
"""Other descriptions that are named, if they leave no more than so many times as much:"""
ABOUT = 3.0
FEW = 2
"""Channels that are looked at one by one."""


def describe(
    bench: Bench,
    prepared: PreparedCampaign,
    choice: Selection,
    location: ResidualTestsResult | None,
    everything: Reduced,
    unseen: Reduced,
    held: Sequence[str],
    behaves: Sequence[Description] = (),
) -> GapDescription | None:
    """What the gap behaves like; None where it is explained, or where nothing closes it on records held out.

    Args:
        bench: what was searched.
        prepared: the campaign.
        choice: what the search says: that nothing explains it.
        location: of the residual, before any effect was fitted.
        everything: all records.
        unseen: those that no fit has seen.
        held: their names.
        behaves: what the search has found it to behave like, if it has; nothing else is looked for then.
    """
    if choice.explained or choice.flat or location is None:
        return None
    found = sorted(behaves or _candidates(bench, prepared, choice, location, unseen, held), key=cost_per_number)
    if not found:
        return None
    best = found[0]
    closes = _shrink(choice, best, held)
    if closes.closed is None or closes.interval is None or closes.closed < PAYS or closes.interval[0] <= 0:
        return None
    return _document_of(best, closes, found[1:], prepared.campaign.rig, everything)


def _candidates(
    bench: Bench,
    prepared: PreparedCampaign,
    choice: Selection,
    location: ResidualTestsResult,
    unseen: Reduced,
    held: Sequence[str],
) -> Iterator[Description]:
    """Descriptions fitted to the end: of the channels that stand out, then of the beam and of all channels."""
    base, least = search_origin(bench, choice.base), np.inf
    rows = location.channels if len(location.channels) <= FEW else ()
    rows = tuple(r for r in rows if r in bench.data.channels)
    seen = [b for b in prepared.blocks if b.name not in set(held)]
    for row in rows:
        report_progress(0.0, f"what {bench.data.rig.channels[row].name} behaves like")
        for fit in best_fits(bench, base, list(linear_operators(bench, row)), 1):
            least = min(least, excess_over_floor(fit))
            yield description_of(fit, unseen, (row,))
        if least < SOLVED * excess_over_floor(base):
            return
        for one in sample_operators(bench, prepared, fit_without_channel(bench, prepared, seen, row), held, row):
            least = min(least, excess_over_floor(one.fit))
            yield one
    if least < SOLVED * excess_over_floor(base):
        return
    report_progress(0.4, "the force that is missing")
    # Where no channel is known to be off alone, the one that is off most is looked at all the same.
    loudest = bench.data.channels[int(np.argmax(channel_share(base)))]
    alone = [] if rows else list(linear_operators(bench, loudest))
    for fit in best_fits(bench, base, [*trials_on_beam(bench, base), *operators_on_all_channels(bench), *alone]):
        yield description_of(fit, unseen, rows_of(fit))


def _shrink(choice: Selection, best: Description, held: Sequence[str]) -> Shrinkage:
    before = squared_residuals(twin_of(choice.base, best.raw), best.raw)
    after = squared_residuals(twin_of(best.fit, best.unseen), best.unseen)
    return shrinkage_with_interval(list(held), before, after, {}, np.random.default_rng(SEED))


def _document_of(
    best: Description, closes: Shrinkage, others: Sequence[Description], rig: Rig, everything: Reduced
) -> GapDescription:
    first = best.learned[0]
    x = x_m_of(first.place)
    share = first.interval.get("x")
    length = rig.beam.length_m if rig.beam is not None else 1.0
    near = [o for o in others if excess_over_floor(o.fit) < ABOUT * excess_over_floor(best.fit)]
    return GapDescription(
        says=learned_in_words(best.learned, rig),
        stage=cast("Stage", stage_of(best)),
        elements=list(best.learned),
        x_m=x,
        x_m_interval=(max(share[0], 0.0) * length, min(share[1], 1.0) * length) if x is not None and share else None,
        channels=[rig.channels[row].name for row in best.rows],
        shrink=closes,
        twin=calibrated_twin(best.fit, everything),
        alternatives=[
            AlternativeDescription(says=learned_in_words(o.learned, rig), gap=o.fit.gap) for o in near[:ALTERNATIVES]
        ],
    )
