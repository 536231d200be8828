"""Identifies hits from their averaged FRFs, as H2 and Hv have them.

An FRF on Re s = sigma is that of the structure as well: what the block's end cuts off has died out there.
"""

from collections.abc import Sequence

from modallab.core.frf import Frf
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.identification.frf_model import NOT_FROM_RECORDS, identify_frf
from modallab.identification.impact import default_band, start_frf
from modallab.identification.likelihood.fit import LikelihoodFit
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
    return found.model_copy(update={"test": "impact", "notes": (note, *notes)}), fit, frf
