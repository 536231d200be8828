"""Identifies averaged FRFs: of a shaker's broadband drive, or of hits as H2 and Hv have them.

An FRF on Re s = sigma is that of the structure as well: what the block's end cuts off has died out there.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modallab.core.frf import Frf
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.frf.broadband import PERIODIC, blocks_of_one_level, driven_lines
from modallab.frf.distortions import Distortions, estimate_distortions
from modallab.frf.estimate import lines_of_band
from modallab.frf.joined import check_responses_follow, fewest_blocks, joined_spectra, split_blocks
from modallab.frf.periodic_drive import (
    RANDOM,
    frf_of_main_level,
    resample_to_drive_clock,
    with_equal_line_weights,
    without_decays,
)
from modallab.frf.sums import Estimator
from modallab.frf.undriven_lines import UndrivenDistortions, distortions_at_undriven_lines, has_undriven_lines
from modallab.identification.frf_model import NOT_FROM_RECORDS, frf_in_band, identify_frf
from modallab.identification.impact import default_band, start_frf
from modallab.identification.likelihood.basis import poles_of
from modallab.identification.likelihood.fit import LikelihoodFit
from modallab.identification.model.modal_model import with_hit_shares
from modallab.identification.options import IdentificationOptions
from modallab.identification.parts import PARTS, with_repeatability_sigmas
from modallab.signals.signals import Signals

STILL, MOST_LOOKS = 0.1, 20
"""Share of their deviations by which poles move from look to look once they stand still, and looks at most: each takes
the decays off a periodic drive's blocks by the poles of the last, which what it left of them had moved."""

LEAST_PARTS = 3
TOO_FEW = (
    "There are too few blocks to estimate their scatter: the uncertainties are those of the noise alone, and "
    "may be many times too small. Record four blocks or more."
)
UNKNOWN = 0.5
"""Share of a damping ratio beyond which its sigma says that it is that of noise, or an artefact of the FRF's errors."""


def frf_of_drive(
    signals: Sequence[Signals], rig: Rig, band_hz: tuple[float, float], estimator: Estimator = "H1"
) -> Frf:
    """The FRF of the level that has most blocks.

    Raises:
        DataError: the responses do not follow the force, a band without lines, or one block of a periodic drive for H2
            or Hv.
    """
    measured = frf_of_main_level(signals, rig, band_hz, estimator)
    check_responses_follow(measured)
    return with_equal_line_weights(measured)


def identify_drive(
    signals: Sequence[Signals], frf: Frf, rig: Rig, options: IdentificationOptions
) -> tuple[ModalModel, LikelihoodFit, Frf]:
    """The modal model, its fit, and the FRF it was made from.

    Args:
        signals: all blocks of one kind of drive.
        frf: of them.
        rig: channels and points.
        options: of the identification.

    Raises:
        IdentificationError: no mode.
    """
    band = (float(frf.frequency_hz[0]), float(frf.frequency_hz[-1]))
    used = blocks_of_one_level(signals)
    records = joined_spectra(used, band) if options.refined and _is_one_random_force(used) else None
    found, fit = identify_frf(frf, rig, options, records)
    for _ in range(MOST_LOOKS if used[0].block.test in PERIODIC else 0):
        poles, before = poles_of(2 * np.pi * found.frequency_hz, found.damping_ratio), found
        used = without_decays(blocks_of_one_level(signals), poles, band)
        frf = with_equal_line_weights(frf_of_main_level(used, rig, band, options.frf))
        found, fit = identify_frf(frf, rig, options)
        if _stands_still(before, found):
            break
    parts = _frfs_of_parts(used, rig, found.band_hz, options.frf) if options.refined and records is None else []
    few = (TOO_FEW,) if options.refined and records is None and not parts else ()
    found = found.model_copy(update={"notes": (*found.notes, *few)})
    model = with_repeatability_sigmas(found, parts)
    unknown = tuple(float(f) for f in model.frequency_hz[model.damping_sigma > UNKNOWN * model.damping_ratio])
    if not unknown or len(unknown) == model.n_modes or options.pick_hz or options.drop_hz:
        return model, fit, frf
    again, fit = identify_frf(frf, rig, replace(options, drop_hz=unknown), records)
    found = again.model_copy(update={"notes": (*again.notes, *few)})
    listed = ", ".join(f"{f:.4g}" for f in unknown)
    note = f"Left out: {listed} Hz, of a damping that stretches of the test do not agree on."
    kept = with_repeatability_sigmas(found, parts)
    return kept.model_copy(update={"notes": (*kept.notes, note)}), fit, frf


def _stands_still(before: ModalModel, after: ModalModel) -> bool:
    """Whether no pole has moved by more than a share of its deviation; one without a deviation is not searched for."""
    if before.n_modes != after.n_modes:
        return False
    moved = np.hypot(
        (after.frequency_hz - before.frequency_hz) / after.frequency_sigma_hz,
        (after.damping_ratio - before.damping_ratio) / after.damping_sigma,
    )
    return not np.any(moved > STILL)


def _is_one_random_force(signals: Sequence[Signals]) -> bool:
    """What its records scatter by is in their likelihood: other drives are held against parts of themselves."""
    return signals[0].block.test in RANDOM and len(signals[0].forces) == 1


def _frfs_of_parts(
    signals: Sequence[Signals], rig: Rig, band_hz: tuple[float, float], estimator: Estimator
) -> list[Frf]:
    """FRFs of stretches of a test; none where it is too short to be divided."""
    each = max(fewest_blocks(signals, estimator), len(signals) // PARTS)
    count = min(PARTS, len(signals) // each)
    if count < LEAST_PARTS:
        return []
    return [
        frf_in_band(with_equal_line_weights(frf_of_main_level(part, rig, band_hz, estimator)), band_hz)
        for part in split_blocks(signals, count)
    ]


def identify_averaged_hits(
    groups: Sequence[Sequence[Signals]], rig: Rig, options: IdentificationOptions
) -> tuple[ModalModel, LikelihoodFit, Frf]:
    """The modal model, its fit, and the FRF it was made from.

    Args:
        groups: hits by point, several at each.
        rig: channels and points.
        options: of the identification; its `frf` is H2 or Hv.

    Raises:
        DataError: a point with one hit, a block without one, or a band without lines.
        IdentificationError: no mode.
    """
    frf = start_frf(groups, rig, options.band_hz or default_band(groups), options.frf)
    found, fit = identify_frf(frf, rig, options)
    note = f"Identified from {options.frf} of the hits at each point, and not from their records."
    notes = tuple(note for note in found.notes if note != NOT_FROM_RECORDS)
    model = found.model_copy(update={"test": "impact", "notes": (note, *notes)})
    return with_hit_shares(model, groups), fit, frf


def distortions_of(signals: Sequence[Signals], model: ModalModel) -> Distortions | UndrivenDistortions:
    """Distortions of a drive: even and odd ones apart where it leaves lines out, else from what waves do not agree on.

    Args:
        signals: blocks of one level.
        model: identified from them: its modes still ring down where the blocks begin.

    Raises:
        DataError: a drive without a period, or too few waves, periods or lines.
    """
    if signals[0].block.test not in PERIODIC:
        return estimate_distortions(signals, model.band_hz)
    settled = _settled_periods(signals, model)
    return (distortions_at_undriven_lines if has_undriven_lines(settled, model.band_hz) else estimate_distortions)(
        settled, model.band_hz
    )


def _settled_periods(signals: Sequence[Signals], model: ModalModel) -> list[Signals]:
    """Whole periods of the drive's own clock, without the free decays of the modes."""
    first = signals[0]
    driven = driven_lines(lines_of_band(first.force.size, first.rate_hz, model.band_hz), signals)
    poles = poles_of(2 * np.pi * model.frequency_hz, model.damping_ratio)
    return without_decays(resample_to_drive_clock(signals, driven), poles, model.band_hz)
