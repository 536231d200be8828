"""FRFs of a broadband drive, by the way that its signal asks for."""

from collections.abc import Sequence
from dataclasses import replace

from modallab.core.frf import Frf
from modallab.core.rig import Rig
from modallab.frf.broadband import PERIODIC, blocks_of_one_level, broadband_frf, driven_lines
from modallab.frf.drive_clock import resample_to_drive_clock
from modallab.frf.estimate import lines_of_band
from modallab.frf.joined import joined_frf
from modallab.frf.sums import Estimator
from modallab.signals.signals import Signals

RANDOM = ("random", "burst-random")


def cut_to_own_clock(signals: Sequence[Signals], band_hz: tuple[float, float]) -> list[Signals]:
    """The blocks, of a periodic drive as its own clock would have cut them: else its lines leak into one another."""
    first = signals[0]
    if first.block.test not in PERIODIC:
        return list(signals)
    return resample_to_drive_clock(
        signals, driven_lines(lines_of_band(first.n_samples, first.rate_hz, band_hz), signals)
    )


def driven_frf(signals: Sequence[Signals], rig: Rig, band_hz: tuple[float, float], estimator: Estimator = "H1") -> Frf:
    """The FRF of the level that has most blocks.

    Raises:
        DataError: a band without lines, or one block of a periodic drive for H2 or Hv.
    """
    used = blocks_of_one_level(signals)
    # A block of random drive is cut out of what never ends: only the blocks together are long enough.
    made = joined_frf if used[0].block.test in RANDOM else broadband_frf
    return made(used, rig, band_hz, estimator=estimator)


def with_even_weights(frf: Frf) -> Frf:
    """With lines that count alike: what varies from line to line is the drive's own level, which another look lacks."""
    return replace(frf, coherence=None, variance=None)
