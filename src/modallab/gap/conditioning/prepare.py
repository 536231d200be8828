"""From a campaign to what the fits see: noise, overloads, hum, ringing, floor, poles."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.core.block import Block, Campaign
from modallab.core.rig import Rig
from modallab.gap.conditioning.ambient import (
    BaseMotion,
    RingingOfHits,
    find_base_motion,
    find_ringing,
    is_moving_before_hits,
    without_ringing,
)
from modallab.gap.conditioning.driven_records import SettledRecords, join_drive_records
from modallab.gap.conditioning.hum import NO_DECAYS, Hum, find_hum, remaining_hum, without_hum
from modallab.gap.conditioning.noise import (
    lines_of_noise_estimate,
    low_frequency_noise_power,
    measured_noise,
    measured_row_noise,
    noise_for_weights,
    noise_of_rig_file,
)
from modallab.gap.conditioning.records import ClippedChannel, find_clipped, records_in_volts, usable_records
from modallab.gap.conditioning.reduce import sine_clock_of
from modallab.gap.conditioning.ring_down_poles import ring_down_poles
from modallab.signals.conversion import Conversion
from modallab.signals.faults.whole_channels import overloaded_channels

REPEATS = 0.025
"""Share of samples equal to the one before that no lively signal has."""
ZEROS = 0.01
"""Share of samples at exactly 0 beside one far from it that no signal has that passes through 0."""
LIVELY = 8.0
"""Times the noise that a signal moves from sample to sample where it is lively."""
COUNTS = 12.0
"""Counts of the converter that are far, however little noise there is: a slow signal repeats its counts."""
RECORDS = 3
"""Lively records that must show it."""


def channels_losing_samples(blocks: Sequence[Block], noise_v: Real, force: int) -> tuple[int, ...]:
    """Rows that lose samples, as most of their lively records show.

    Args:
        blocks: the records.
        noise_v: (rows,) V rms.
        force: row of the force, which is 0 most of the time.
    """
    found = [_shares_repeated_and_zero(b, noise_v) for b in blocks]
    repeats, zeros = (np.ma.masked_invalid(np.array(shares)) for shares in zip(*found, strict=True))
    lost = (_typical_share(repeats) > REPEATS) | (_typical_share(zeros) > ZEROS)
    return tuple(int(i) for i in np.flatnonzero(lost & (repeats.count(axis=0) >= RECORDS)) if i != force)


def _shares_repeated_and_zero(block: Block, noise_v: Real) -> tuple[Real, Real]:
    """(rows,) shares of one record's samples that repeat, and that are 0 beside others; NaN where little moves."""
    volts = block.samples * block.scale[:, None]
    far = np.maximum(LIVELY * noise_v, COUNTS * np.abs(block.scale))
    lively = np.median(np.abs(np.diff(volts, axis=1)), axis=1) > far
    repeats = np.mean(np.diff(block.samples, axis=1) == 0, axis=1)
    beside = np.minimum(np.abs(volts[:, :-2]), np.abs(volts[:, 2:])) > far[:, None]
    zeros = np.mean(beside & (block.samples[:, 1:-1] == 0), axis=1)
    return np.where(lively, repeats, np.nan), np.where(lively, zeros, np.nan)


def _typical_share(shares: "np.ma.MaskedArray[tuple[int, ...], np.dtype[np.float64]]") -> Real:
    return np.ma.median(shares, axis=0).filled(0.0)


ONE_LEVEL = "Only one level: the linearity of the bench cannot be tested."
NOISY = 1.3
"""A row this far above the others is noisy."""
NOISY_AS_BUILT = 2.5
"""The same where the rig file states how well the bench is put together: its rows differ by up to 1.6 / 0.7."""
ORDINARY_HUM = 1.5
"""Amplitude of hum, over the noise's rms, up to which it is ordinary on such a bench: taken out, but no gap."""
CHANCE = 4.0
"""The same over what one line scatters, where there are few lines: beyond chance in eleven rows."""


@dataclass(frozen=True, eq=False, slots=True)
class PreparedCampaign:
    """A campaign made ready.

    Attributes:
        campaign: with its records as they came, in V.
        blocks: records cleaned of hum and ringing.
        believed_v: (rows,) noise by the rig file.
        noise_v: (rows,) noise in use.
        measured_v: (rows,) noise the records show.
        masked: (record, row) not to be used.
        hum: mains hum, None if there is none.
        hum_below_removal: frequency and (rows,) V of hum too weak to be taken out.
        rising_v2: power at 1 Hz, V^2 per sample, of noise that rises as 1 / f; 0 if it is white.
        clipped: channels with flat tops.
        ringing: decays before the hits.
        floor: motion of the base.
        noisy: rows whose noise stands out.
        repeated: rows that lose samples, in whose place others are repeated or nothing is read.
        poles: of the ring-down, or of the drive where nothing was struck.
        driven: what the records of broadband drives are settled by.
        sine_ratio: frequency of the sines in the records over what the generator was set to.
        notes: plain sentences on what was left out or could not be examined.
    """

    campaign: Campaign
    blocks: tuple[Block, ...]
    believed_v: Real
    noise_v: Real
    measured_v: Real
    masked: frozenset[tuple[str, int]]
    hum: Hum | None
    hum_below_removal: tuple[float, Real] | None
    rising_v2: float
    clipped: tuple[ClippedChannel, ...]
    ringing: RingingOfHits | None
    floor: BaseMotion | None
    noisy: tuple[int, ...]
    repeated: tuple[int, ...]
    poles: Complex
    driven: SettledRecords
    sine_ratio: float
    notes: tuple[str, ...]


def prepare_campaign(campaign: Campaign) -> PreparedCampaign:
    """Look at a campaign before any fit.

    Raises:
        DataError: there are no records, or none that says what drove it.
    """
    campaign = records_in_volts(campaign)
    force, as_built = campaign.rig.force_channel.index, campaign.rig.tolerance.of_assembly
    blocks, (believed, measured, noise), hum = _with_hum(campaign)
    at_full_scale = _overloaded_blocks(blocks, campaign.rig)
    clipped = tuple(find_clipped(blocks, noise, _full_scale_v(blocks, campaign.rig), force))
    masked = at_full_scale | {(name, c.row) for c in clipped for name in c.records}
    noisy = _standing_out(measured, lines_of_noise_estimate(blocks), NOISY_AS_BUILT if as_built else NOISY)
    # Samples that are lost are noise to a spectrum, and would hide themselves.
    repeated = channels_losing_samples(blocks, np.fmin(noise, measured), force)
    cleaned, poles = _cleaned_of_hum(campaign, blocks, hum, noise, masked, noisy)
    driven = join_drive_records(cleaned, campaign.rig)
    cleaned, poles = driven.blocks, poles if len(poles) else driven.poles
    ratio = sine_clock_of(cleaned, campaign.rig, noise)
    floor = find_base_motion(cleaned, campaign.rig, noise, poles, ratio)
    ringing = None if floor is not None else find_ringing(cleaned, campaign.rig, noise, poles)
    if ringing is not None:
        cleaned = tuple(without_ringing(b, campaign.rig, ringing) for b in cleaned)
    return PreparedCampaign(
        campaign,
        cleaned,
        believed,
        noise,
        measured,
        frozenset(masked),
        hum,
        remaining_hum(blocks, noise, force) if as_built and hum is None else None,
        low_frequency_noise_power(blocks, noise, () if floor is None else (force,)) if as_built else 0.0,
        clipped,
        ringing,
        floor,
        () if floor is not None else tuple(row for row in noisy if row not in repeated),
        repeated,
        poles,
        driven,
        ratio,
        _notes_on_campaign(campaign, blocks, at_full_scale),
    )


def _with_hum(campaign: Campaign) -> tuple[tuple[Block, ...], "RowNoises", Hum | None]:
    """The records that can be used, their noise, and the hum in them: once it is known, more of them can be."""
    blocks = usable_records(campaign)
    noises = RowNoises.of_records(blocks, campaign.rig)
    hum = find_hum(blocks, noises.in_use, campaign.rig.force_channel.index)
    if hum is None or len(blocks) == len(campaign.blocks):
        return blocks, noises, hum
    blocks = usable_records(campaign, hum)
    return blocks, RowNoises.of_records(blocks, campaign.rig), hum


def _cleaned_of_hum(
    campaign: Campaign,
    blocks: tuple[Block, ...],
    hum: Hum | None,
    noise: Real,
    masked: set[tuple[str, int]],
    noisy: Sequence[int],
) -> tuple[tuple[Block, ...], Complex]:
    """The records without hum, and their poles: where the structure moves before a hit, its decays are no hum."""
    if hum is None:
        return blocks, _poles_of_campaign(campaign, blocks, masked, noisy)
    cleaned = tuple(without_hum(b, hum) for b in blocks)
    poles = _poles_of_campaign(campaign, cleaned, masked, noisy)
    decays = poles if is_moving_before_hits(cleaned, campaign.rig, noise) else NO_DECAYS
    cleaned = tuple(without_hum(b, hum, decays) for b in blocks)
    return cleaned, _poles_of_campaign(campaign, cleaned, masked, noisy)


class RowNoises(NamedTuple):
    """(rows,) V rms of each row: by the rig file, as the records show it, and what is used."""

    believed: Real
    measured: Real
    in_use: Real

    @classmethod
    def of_records(cls, blocks: Sequence[Block], rig: Rig) -> Self:
        """Of some records of a rig."""
        believed, measured = noise_of_rig_file(rig, blocks), measured_noise(blocks, rig)
        if rig.tolerance.of_assembly:
            return cls(believed, measured, measured_row_noise(blocks, believed, rig.force_channel.index))
        return cls(believed, measured, noise_for_weights(measured, believed))


def _overloaded_blocks(blocks: Sequence[Block], rig: Rig) -> set[tuple[str, int]]:
    rows = {c.name: c.index for c in rig.channels}
    return {(b.name, rows[name]) for b in blocks for name in overloaded_channels(b, rig)}


def _full_scale_v(blocks: Sequence[Block], rig: Rig) -> Real:
    first = blocks[0]
    return Conversion.of_block(first, rig).full_scale * np.abs(first.scale)


def _standing_out(measured: Real, lines: int, least: float) -> tuple[int, ...]:
    """Rows whose noise stands above the others by more than chance, where so many lines show it."""
    middle = float(np.nanmedian(measured)) if np.any(np.isfinite(measured)) else np.inf
    limit = max(least, 1 + CHANCE / np.sqrt(max(lines, 1)))
    raised = np.flatnonzero(np.nan_to_num(measured) > limit * middle)
    return tuple(int(i) for i in raised) if len(raised) <= max(2, len(measured) // 4) else ()


def _poles_of_campaign(
    campaign: Campaign, blocks: Sequence[Block], masked: set[tuple[str, int]], noisy: Sequence[int]
) -> Complex:
    rig = campaign.rig
    hits = [b for b in blocks if b.test == "impact"]
    points = sorted({b.drive_point for b in hits if b.drive_point is not None})
    chosen = [next(b for b in hits if b.drive_point == p) for p in points]
    bad = {row for _, row in masked} | set(noisy)
    keep = [i for i, c in enumerate(rig.responses) if c.index not in bad]
    if not chosen or len(keep) < 2:
        return np.zeros(0, dtype=np.complex128)
    poles = ring_down_poles(chosen, rig, keep)
    # A line that does not decay is no mode.
    return poles[-poles.real / np.abs(poles) > 2e-4]


def _notes_on_campaign(
    campaign: Campaign, blocks: Sequence[Block], at_full_scale: set[tuple[str, int]]
) -> tuple[str, ...]:
    notes: list[str] = []
    if len(blocks) < len(campaign.blocks):
        left_out = len(campaign.blocks) - len(blocks)
        notes.append(f"{left_out} records were excluded: they have no force, hit, drive point or frequency.")
    if at_full_scale:
        notes.append(f"{len(at_full_scale)} channels of records reached the converter's full scale and were left out.")
    tests = {b.test for b in blocks}
    if tests == {"impact"}:
        notes.append("Only an impact test: effects of the shaker, of level and of the clock cannot be tested.")
    if tests == {"sine"}:
        notes.append("Only a sine test: places of hits, and ringing before hits, cannot be tested.")
    levels = {b.level for b in blocks if b.test == "sine"}
    if "sine" in tests and len(levels) < 2:
        notes.append(ONE_LEVEL)
    return tuple(notes)
