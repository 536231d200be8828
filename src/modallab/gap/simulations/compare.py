"""Where another simulation of the bench differs from it, which effect explains that, and how far it shrinks.

The bench and the simulation are diagnosed alike, each from its records of the same forces: what the one has and the
other has not is the difference. Corrected, the simulation's records are those of the twin of the bench, and beside
them what the simulation has that no twin of it has.
"""

from dataclasses import replace
from typing import Literal

import numpy as np

from modallab.core.arrays import Real
from modallab.core.block import Block, Campaign
from modallab.core.diagnosis import Diagnosis, FoundEffect
from modallab.core.digits import relative_change
from modallab.core.effect import channels_of_place, x_m_of
from modallab.core.errors import DataError
from modallab.core.frozen import Frozen
from modallab.core.hold_out import MIXED, HoldOut
from modallab.core.progress import part_of_progress
from modallab.gap.conditioning.noise import noise_of_rig_file
from modallab.gap.conditioning.records import records_in_volts, usable_records
from modallab.gap.design.prediction import Records, predict_records, replace_responses
from modallab.gap.diagnosis import diagnose
from modallab.gap.report.measure import BARE, share_of_gap_closed
from modallab.gap.simulations.simulated_records import simulation_residual

SEED = 20240502
APART = 0.05
"""Relative difference of a parameter that two intervals may leave open."""
SHUT = 1.15
"""Gap in noise units up to which a simulation behaves as the bench."""


class DifferingEffect(Frozen):
    """An effect that bench and simulation both have, in another size or at another place."""

    bench: FoundEffect
    simulation: FoundEffect


class SimulationComparison(Frozen):
    """A simulation compared with the bench.

    Attributes:
        rig: its name.
        verdict: whether they differ, and whether that is explained; `unknown` where the bench or the simulation shows
            what no effect of the catalogue explains.
        before: gap of the simulation in noise units, on the records that count for it; nothing is fitted.
        after: the same once it is corrected.
        closed: share of the reducible gap that this closes; None where there was next to none.
        records: on which this was measured.
        by_channel: channel -> gap before.
        after_by_channel: the same after.
        lacks: effects of the bench that the simulation has not.
        has: effects of the simulation that the bench has not.
        differs: effects that both have, otherwise.
        bench: the diagnosis of the bench.
        simulation: the diagnosis of the simulation, as if its records were a bench's.
        notes: plain sentences.
    """

    rig: str
    verdict: Literal["no_gap", "known", "unknown"]
    before: float
    after: float
    closed: float | None
    records: list[str]
    by_channel: dict[str, float]
    after_by_channel: dict[str, float]
    lacks: list[FoundEffect]
    has: list[FoundEffect]
    differs: list[DifferingEffect]
    bench: Diagnosis
    simulation: Diagnosis
    notes: list[str]


def compare_simulation(
    campaign: Campaign, records: Records, bench: Diagnosis | None = None, hold_out: HoldOut = MIXED
) -> SimulationComparison:
    """Hold a simulation against the bench.

    Args:
        campaign: the bench's records.
        records: what the simulation predicts for the same forces: record -> (channels, n), each row in its channel's
            own unit and direction.
        bench: the diagnosis of the campaign where it is known.
        hold_out: which records no fit may see.

    Raises:
        DataError: a record that could be compared was not predicted, or has another shape.
        RigError, PlanError: as `diagnose`.
    """
    _require_all(campaign, records)
    with part_of_progress(0.0, 0.45, "bench"):
        known = bench if bench is not None else diagnose(campaign, hold_out)
    with part_of_progress(0.45, 0.9, "simulation"):
        simulation = diagnose(simulation_as_measured(campaign, records), hold_out)
    names = _names_held(campaign, known)
    raw = simulation_residual(campaign, records, names)
    corrected = simulation_residual(campaign, _correct_simulation(campaign, records, known, simulation), names)
    lacks, has, differs = differing_effects(known, simulation)
    channels = [campaign.rig.channels[c].name for c in raw.channels]
    return SimulationComparison(
        rig=campaign.rig.name,
        verdict=_comparison_verdict(raw.gap, known, simulation, bool(lacks or has or differs)),
        before=raw.gap,
        after=corrected.gap,
        closed=share_of_gap_closed(raw.gap, corrected.gap) if raw.gap**2 - 1 > BARE else None,
        records=sorted(names),
        by_channel=raw.by(channels),
        after_by_channel=corrected.by(channels),
        lacks=lacks,
        has=has,
        differs=differs,
        bench=known,
        simulation=simulation,
        notes=_comparison_notes(known, simulation),
    )


def simulation_as_measured(campaign: Campaign, records: Records) -> Campaign:
    """What a simulation predicts, as if it had been measured: with the noise of the rig's converter."""
    volts = records_in_volts(replace_responses(campaign, records))
    rng = np.random.default_rng(SEED)
    noise = noise_of_rig_file(campaign.rig, campaign.blocks)
    force = campaign.rig.force_channel.index

    def noisy(block: Block) -> Block:
        more = rng.standard_normal(block.samples.shape) * noise[:, None]
        # The force is the bench's own, with the noise it has.
        more[force] = 0.0
        samples = block.samples * block.scale[:, None] + more
        return replace(block, samples=samples, scale=np.ones(len(samples)))

    return replace(volts, blocks=tuple(noisy(b) for b in volts.blocks), source="simulation")


def _require_all(campaign: Campaign, records: Records) -> None:
    wanted = [b.name for b in usable_records(records_in_volts(campaign))]
    missing = [name for name in wanted if name not in records]
    if missing:
        more = f" and {len(missing) - 3} more" if len(missing) > 3 else ""
        raise DataError(
            f"the simulation predicts only {len(wanted) - len(missing)} of {len(wanted)} records, not "
            f"{', '.join(missing[:3])}{more}",
            where=campaign.source,
            remedy="predict every record that has a force, with the record's name in the campaign",
        )


def _names_held(campaign: Campaign, bench: Diagnosis) -> set[str]:
    """The records that the bench's diagnosis held out; all where it held out none."""
    there = {b.name for b in usable_records(records_in_volts(campaign))}
    return there & set(bench.shrink.held_out) or there


def _correct_simulation(
    campaign: Campaign, records: Records, bench: Diagnosis, simulation: Diagnosis
) -> dict[str, Real]:
    of_bench, of_simulation = predict_records(bench, campaign), predict_records(simulation, campaign)
    return {name: records[name] + of_bench[name] - of_simulation[name] for name in of_bench}


def differing_effects(
    bench: Diagnosis, simulation: Diagnosis
) -> tuple[list[FoundEffect], list[FoundEffect], list[DifferingEffect]]:
    """What the bench alone has, what the simulation alone has, and what both have otherwise."""
    both = [(b, s) for b in bench.effects for s in simulation.effects if _is_same_effect(b, s)]
    lacks = [b for b in bench.effects if not any(b is pair[0] for pair in both)]
    has = [s for s in simulation.effects if not any(s is pair[1] for pair in both)]
    return lacks, has, [DifferingEffect(bench=b, simulation=s) for b, s in both if not _agree_within_intervals(b, s)]


def _is_same_effect(one: FoundEffect, other: FoundEffect) -> bool:
    return one.effect == other.effect and channels_of_place(one.place) == channels_of_place(other.place)


def _agree_within_intervals(one: FoundEffect, other: FoundEffect) -> bool:
    """Whether two findings of one effect are the same but for what their intervals leave open."""
    if abs((x_m_of(one.place) or 0.0) - (x_m_of(other.place) or 0.0)) > APART:
        return False
    for name, value in one.parameters.items():
        second = other.parameters[name]
        mine, others = one.interval.get(name, (value, value)), other.interval.get(name, (second, second))
        if mine is None or others is None:
            # What the records leave open differs from nothing.
            continue
        (low, high), (below, above) = mine, others
        if (low > above or below > high) and abs(value - second) > APART * abs(value):
            return False
    return True


def _comparison_verdict(
    before: float, bench: Diagnosis, simulation: Diagnosis, different: bool
) -> Literal["no_gap", "known", "unknown"]:
    if before <= SHUT:
        return "no_gap"
    if "unknown" in (bench.verdict, simulation.verdict):
        return "unknown"
    # Where no effect parts them, only numbers within their tolerances do.
    return "known" if different else "no_gap"


def _comparison_notes(bench: Diagnosis, simulation: Diagnosis) -> list[str]:
    found = [
        f"{said} has an unexplained difference in the {of.where.stage}."
        for said, of in (("The bench", bench), ("The simulation", simulation))
        if of.verdict == "unknown"
    ]
    one, other = bench.twin, simulation.twin
    off = (other.youngs_modulus_pa * other.thickness_m**2 / other.density_kg_m3) / (
        one.youngs_modulus_pa * one.thickness_m**2 / one.density_kg_m3
    )
    found.append(
        f"Within the tolerances, its beam's frequencies are {relative_change(np.sqrt(off) - 1)} off the bench's."
    )
    return found
