"""A diagnosis at work: what the accelerometers of another campaign on the same rig would read."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from modallab.core.arrays import Real
from modallab.core.block import Block, Campaign
from modallab.core.diagnosis import Diagnosis
from modallab.core.effect import Effect, OneChannel
from modallab.core.effects import row_of
from modallab.core.errors import DataError
from modallab.core.rig import Rig
from modallab.gap.conditioning.records import records_in_volts, usable_records
from modallab.gap.conditioning.reduce import sine_clock_of
from modallab.gap.model.forward import predict_record
from modallab.gap.report.calibrated import diagnosed_twin, effects_for_twin
from modallab.signals.alignment import lags_s
from modallab.signals.conversion import unit_per_si, volts_per_si
from modallab.twin.learned.row_curve import MODEL, apply_curve

CURVE = MODEL.kind.name
Records = Mapping[str, Real]
"""Record -> (channels, n) of the response channels, each in its own unit and direction."""


def predict_records(diagnosis: Diagnosis, other: Campaign) -> dict[str, Real]:
    """Record -> (channels, n): what each response channel of another campaign would read, each record begun from rest.

    Every row is in its channel's own unit, in the direction of its positive readings, and as late and as AC-coupled as
    the rig file says the channel is.

    Args:
        diagnosis: of a campaign on the same rig.
        other: the campaign to predict; only its forces are read.

    Raises:
        DataError: the rig has no beam, the diagnosis is another version's, or no record says what drove it.
    """
    rig, other = other.rig, records_in_volts(other)
    twin = diagnosed_twin(diagnosis, rig)
    twin = replace(twin, chain=twin.chain.as_delivered(rig, lags_s(rig)))
    blocks = usable_records(other)
    ratio = clock_of(other, blocks)
    last = float(max(1, *(b.order for b in other.blocks)))
    rows = [c.index for c in rig.responses]
    levels = [f.place for f in diagnosis.effects if isinstance(f.place, OneChannel)]
    cut = {place.channel: place.level_v for place in levels if place.level_v is not None}
    curves = _static_curves([*rig.known_effects, *effects_for_twin(diagnosis)])
    found: dict[str, Real] = {}
    for b in blocks:
        si = predict_record(twin, rig, b, last, ratio)
        limit = np.array([cut.get(row, np.inf) for row in rows]) / np.abs(volts_per_si(rig, b.test)[rows])
        for row, law in curves:
            at, volts = rows.index(row), float(volts_per_si(rig, b.test)[row])
            si[at] = apply_curve(si[at] * volts, law) / volts
        found[b.name] = np.clip(si, -limit[:, None], limit[:, None]) * unit_per_si(rig)[rows, None]
    return found


def _static_curves(effects: Iterable[Effect]) -> list[tuple[int, Mapping[str, float]]]:
    """(row, law) of the static curves among them."""
    return [(row_of(e), e.parameters) for e in effects if e.effect == CURVE]


def clock_of(campaign: Campaign, blocks: Sequence[Block]) -> float:
    """Seen frequency of the sines over what was set, where they differ beyond doubt; else 1."""
    rig = campaign.rig
    noise = np.full(len(rig.channels), rig.converter.noise_rms_v if rig.converter is not None else 3e-4)
    return sine_clock_of(blocks, rig, noise)


def predicted_campaign(diagnosis: Diagnosis, other: Campaign) -> Campaign:
    """The same as a campaign: the forces as measured, beside them what the accelerometers would read.

    Raises:
        DataError: as `predict_records`.
    """
    return replace_responses(other, predict_records(diagnosis, other))


def replace_responses(other: Campaign, records: Records) -> Campaign:
    """A campaign with the forces as measured, beside them what was predicted; without the records that were not.

    Raises:
        DataError: records of another shape than the campaign's.
    """
    rig = other.rig
    rows = [c.index for c in rig.responses]
    blocks = tuple(_with_rows(b, rig, rows, records[b.name]) for b in other.blocks if b.name in records)
    return replace(other, blocks=blocks, source=f"predicted from {other.source}")


def _with_rows(block: Block, rig: Rig, rows: Sequence[int], values: Real) -> Block:
    samples = (block.samples * block.scale[:, None]).astype(np.float64)
    if values.shape != (len(rows), samples.shape[1]):
        raise DataError(
            f"{block.name} was predicted with shape {values.shape}, but has {(len(rows), samples.shape[1])}",
            remedy="give one row for each response channel and as many samples as the record has",
        )
    samples[rows] = values
    units = list(block.units)
    for row in rows:
        units[row] = rig.channels[row].unit
    return replace(block, samples=samples, scale=np.ones(len(samples)), units=tuple(units))
