"""How nonlinear a structure is, from a shaker's drive at one level."""

from collections.abc import Sequence

import numpy as np

from modallab.core.model import ModalModel
from modallab.frf.broadband import PERIODIC, driven_lines
from modallab.frf.distortions import Distortions, estimate_distortions
from modallab.frf.drive_clock import resample_to_drive_clock
from modallab.frf.estimate import lines_of_band
from modallab.frf.left_out import UndrivenDistortions, distortions_at_undriven_lines, leaves_lines_out
from modallab.frf.settled_periods import without_decays
from modallab.identification.likelihood.poles import poles_of
from modallab.signals.signals import Signals


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
