"""Recordings that came as a file, kept as runs: each test, and whatever is of one rate and length, is a run."""

from collections.abc import Mapping, Sequence
from itertools import groupby
from typing import Any

from pydantic import TypeAdapter, ValidationError

from modallab.bench.protocol import BenchInfo, DeliveredSampling
from modallab.core.block import Block, Campaign, note_other_shakers
from modallab.core.plan import BroadbandPlan, ImpactPlan, Plan, SinePlan, test_of_plan
from modallab.core.units import Test
from modallab.storage.records import BlockNote
from modallab.storage.store import Store

PLAN: TypeAdapter[Plan] = TypeAdapter(Plan)
UNKNOWN_V = 1.0
"""Stands for the drive's voltage where the file does not say it."""


def keep_campaign(store: Store, campaign: Campaign, address: str) -> tuple[str, ...]:
    """Keep the blocks of a campaign as runs that are done; returns their names, in the order of time.

    Args:
        store: where.
        campaign: its blocks count; its FRFs are not kept.
        address: stands in the place of a bench's, and says where they came from.

    Raises:
        StorageError, DiskFullError: they could not be kept.
    """
    bench = BenchInfo(address, (), can_drive=False, real_time=False, facts=dict(campaign.provenance))
    alike = sorted(campaign.blocks, key=_likeness_of_block)
    groups = [tuple(blocks) for _, blocks in groupby(alike, key=_likeness_of_block)]
    groups.sort(key=lambda blocks: blocks[0].order)
    return tuple(_keep_blocks(store, campaign, bench, blocks) for blocks in groups)


def _likeness_of_block(block: Block) -> tuple[object, ...]:
    form = block.test, block.rate_hz, block.samples.dtype.str, block.n_samples
    return (
        *form,
        block.units,
        tuple(map(float, block.scale)),
        block.also_driven,
        block.requested_rate_hz or 0.0,
        block.actual_rate_hz or 0.0,
    )


def _keep_blocks(store: Store, campaign: Campaign, bench: BenchInfo, blocks: Sequence[Block]) -> str:
    first = blocks[0]
    delivery = DeliveredSampling(
        requested_rate_hz=first.requested_rate_hz or first.rate_hz,
        actual_rate_hz=first.actual_rate_hz or first.rate_hz,
        rate_hz=first.rate_hz,
        dtype=first.samples.dtype,
        scale=first.scale,
        units=first.units,
    )
    with store.begin(plan_of(blocks, campaign.provenance), campaign.rig, bench) as recorder:
        recorder.open(delivery, first.n_samples)
        for block in blocks:
            recorder.record_block(block.samples, _note_of_block(block))
        recorder.close_file()
        recorder.enter_state("done", f"imported from {campaign.source}")
        return recorder.run


def _note_of_block(block: Block) -> BlockNote:
    over = block.overload or ()
    began = (
        {} if block.history_s is None else {"burst_first_sample": block.first_sample - block.history_s * block.rate_hz}
    )
    return BlockNote(
        name=block.name,
        test=block.test,
        first_sample=block.first_sample,
        drive_point=block.drive_point,
        level=block.level,
        frequency_hz=block.frequency_hz,
        overload=tuple(name for name, flag in zip(block.channels, over, strict=False) if flag),
        facts={"imported": "yes", **began, **note_other_shakers(block.also_driven)},
    )


def plan_of(blocks: Sequence[Block], provenance: Mapping[str, str]) -> Plan:
    """The plan that blocks of one test were recorded by, if the file holds it; else one that would give such blocks."""
    first = blocks[0]
    stored = [plan for plan in _stored_record(provenance, first.test) if plan.rate_hz == first.requested_rate_hz]
    if len(stored) == 1:
        return stored[0]
    rates: dict[str, Any] = {"rate_hz": first.requested_rate_hz or first.rate_hz, "block_s": first.duration_s}
    levels = {block.level or "low": UNKNOWN_V for block in blocks}
    if first.test == "impact":
        points = [block.drive_point or 1 for block in blocks]
        hits = max(points.count(point) for point in points)
        return ImpactPlan(points=tuple(dict.fromkeys(points)), hits=hits, **rates)
    if first.test == "sine":
        driven = tuple(dict.fromkeys(block.frequency_hz for block in blocks if block.frequency_hz))
        ramp: dict[str, Any] = {} if first.ramp_s is None else {"ramp_s": first.ramp_s}
        return SinePlan(frequencies_hz=driven or (1 / first.duration_s,), levels_v=levels, **rates, **ramp)
    shakers = "all" if first.also_driven else "first"
    return BroadbandPlan(signal=first.test, levels_v=levels, blocks=len(blocks), shakers=shakers, **rates)


def _stored_record(provenance: Mapping[str, str], test: Test) -> list[Plan]:
    found: list[Plan] = []
    for key, text in provenance.items():
        if key.rpartition(".")[2] != "plan":
            continue
        try:
            plan = PLAN.validate_json(text)
        except ValidationError:
            # Of a version that is not known here: the blocks themselves are what counts.
            continue
        if test_of_plan(plan) == test and plan not in found:
            found.append(plan)
    return found
