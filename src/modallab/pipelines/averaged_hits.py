"""Identifies hits from their averaged FRFs, as H2 and Hv have them.

An FRF on Re s = sigma is that of the structure as well: what the block's end cuts off has died out there.
"""

from collections.abc import Sequence

import numpy as np

from modallab.core.frf import Frf
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.frf.broadband import PERIODIC, driven_lines
from modallab.frf.distortions import Distortions, estimate_distortions
from modallab.frf.estimate import lines_of_band
from modallab.frf.left_out import UndrivenDistortions, distortions_at_undriven_lines, leaves_lines_out
from modallab.frf.periodic_drive import resample_to_drive_clock, without_decays
from modallab.identification.frf_model import NOT_FROM_RECORDS, identify_frf
from modallab.identification.impact import default_band, start_frf
from modallab.identification.likelihood.derivatives import poles_of
from modallab.identification.likelihood.fit import LikelihoodFit
from modallab.identification.model.hit_shares import with_hit_shares
from modallab.identification.options import IdentificationOptions
from modallab.signals.signals import Signals


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
    return (distortions_at_undriven_lines if leaves_lines_out(settled, model.band_hz) else estimate_distortions)(
        settled, model.band_hz
    )


def _settled_periods(signals: Sequence[Signals], model: ModalModel) -> list[Signals]:
    """Whole periods of the drive's own clock, without the free decays of the modes."""
    first = signals[0]
    driven = driven_lines(lines_of_band(first.force.size, first.rate_hz, model.band_hz), signals)
    poles = poles_of(2 * np.pi * model.frequency_hz, model.damping_ratio)
    return without_decays(resample_to_drive_clock(signals, driven), poles, model.band_hz)
