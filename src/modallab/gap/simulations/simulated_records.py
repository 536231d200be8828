"""Records of a campaign as any simulation plays them from the same forces: a function of force and time step.

A simulation that steps in time sees the force between samples as it will; the force is therefore given many times finer
than it was sampled, by band-limited interpolation (Shannon, Proc. IRE 37, 1949, 10), and the answer is thinned.
"""

from collections.abc import Callable, Collection
from dataclasses import replace

import numpy as np
from scipy.signal import resample

from modallab.core.arrays import Real
from modallab.core.block import Block, Campaign
from modallab.core.errors import DataError
from modallab.core.rig import Rig
from modallab.gap.conditioning.prepare import prepare_campaign
from modallab.gap.conditioning.records import records_in_volts, usable_records
from modallab.gap.conditioning.reduce import (
    force_amplitude,
    frequency_on_line,
    hit_with_filter_ringing,
    reduce_blocks,
    start_up_of_sines,
)
from modallab.gap.design.prediction import Records, clock_of, replace_responses
from modallab.gap.model.fit import all_rows
from modallab.gap.model.tolerances import with_tolerances
from modallab.gap.report.initial_gap import weights_of
from modallab.gap.report.measure import SquaredResiduals, squares_of
from modallab.signals.alignment import lags_s
from modallab.signals.conversion import unit_per_si
from modallab.signals.hit import windowed_force
from modallab.signals.signals import Signals, to_signals

Simulate = Callable[[Real, float], Real]
"""From (points, n) force in N at the rig's points, along the drive, and the time step in s to (channels, n) what the
response channels sense, along the drive: m/s^2, m/s or m. It begins from rest."""

FINER = 16
"""Steps of the simulation per sample of a hit: a straight line between them is off by 5e-4 at a fifth of the rate."""
FINER_SINE = 8
"""The same of a sine, whose frequency is lower."""


def simulated_records(
    simulate: Simulate, campaign: Campaign, records: Collection[str] | None = None, finer: int | None = None
) -> dict[str, Real]:
    """Record -> (channels, n): what a simulation says each response channel reads, in the channel's own unit.

    Args:
        simulate: the simulation.
        campaign: only its forces are read.
        records: names of those to be simulated; None for all that say what drove them.
        finer: steps per sample; None for the usual.

    Raises:
        DataError: no record says what drove it; channels lag one another or are AC-coupled, which a simulation of
            motion does not know; or the simulation gives another shape, or no numbers.
    """
    rig, campaign = campaign.rig, records_in_volts(campaign)
    if np.any(lags_s(rig)) or len({c.ac_corner_hz for c in rig.channels}) > 1:
        raise DataError(
            "channels of the rig have different delays, or only some are AC-coupled",
            where=rig.name,
            remedy="predict the records including the measurement chain, and give the file",
        )
    blocks = [b for b in usable_records(campaign) if records is None or b.name in records]
    ratio = clock_of(campaign, blocks)
    units = unit_per_si(rig)[[c.index for c in rig.responses], None]
    return {b.name: units * _simulate_record(simulate, rig, b, ratio, finer) for b in blocks}


def _simulate_record(simulate: Simulate, rig: Rig, block: Block, ratio: float, finer: int | None) -> Real:
    signals = to_signals(block, rig)
    hit = block.test == "impact"
    times = finer or (FINER if hit else FINER_SINE)
    one = _hit_force(signals, times) if hit else _sine_force(signals, block, ratio, times)
    force = np.zeros((len(rig.points), len(one)))
    force[[p.id for p in rig.points].index(block.drive_point or 0)] = one
    answer = np.asarray(simulate(force, 1 / block.rate_hz / times), dtype=np.float64)
    wanted = (len(rig.responses), len(one))
    if answer.shape != wanted or not np.all(np.isfinite(answer)):
        found = f"gives {answer.shape}" if answer.shape != wanted else "gives NaN or infinite values"
        raise DataError(
            f"the simulation {found} where (channels, n) = {wanted} is needed",
            where=block.name,
            remedy="give one row for each response channel of the rig, one column for each step",
        )
    return answer[:, ::times][:, -block.n_samples :]


def _hit_force(signals: Signals, times: int) -> Real:
    force = windowed_force(signals.force, hit_with_filter_ringing(signals))
    return np.asarray(resample(force, len(force) * times), dtype=np.float64)


def _sine_force(signals: Signals, block: Block, ratio: float, times: int) -> Real:
    """The sine from where it began to rise to the end of the block."""
    dt = 1 / block.rate_hz
    f0 = frequency_on_line(block.frequency_hz or 0.0, block.n_samples, dt) * ratio
    rise = start_up_of_sines([block])
    before = round(float(rise.history_s[0]) / dt) * times
    t = (np.arange(before + block.n_samples * times) - before) * dt / times
    along = np.clip((t + rise.history_s[0]) / max(float(rise.ramp_s[0]), 1e-9), 0.0, 1.0)
    envelope = (1 - np.cos(np.pi * along)) / 2 if rise.cosine[0] else along
    return envelope * np.real(force_amplitude(signals, f0) * np.exp(2j * np.pi * f0 * t))


def simulation_residual(campaign: Campaign, records: Records, names: Collection[str] | None = None) -> SquaredResiduals:
    """Squares of measured less predicted in noise units; nothing is fitted.

    Args:
        campaign: the bench's records.
        records: record -> (channels, n) in each response channel's own unit and direction.
        names: records that count; None for all that were predicted.

    Raises:
        DataError: no record of the campaign was predicted.
    """
    prepared = prepare_campaign(replace(campaign, rig=with_tolerances(campaign.rig)))
    blocks = [b for b in prepared.blocks if b.name in records and (names is None or b.name in names)]
    if not blocks:
        raise DataError(
            f"none of the {len(records)} predicted records is one of the {len(prepared.blocks)} of the campaign",
            where=campaign.source,
            remedy="name the records as the campaign does",
        )
    weights = weights_of(prepared)
    measured = reduce_blocks(prepared.campaign, blocks, weights)
    simulated = replace_responses(replace(prepared.campaign, blocks=tuple(blocks)), records)
    same = reduce_blocks(replace(simulated, blocks=prepared.campaign.blocks), simulated.blocks, weights)
    return squares_of([rows.y for rows in all_rows(same)], measured)
