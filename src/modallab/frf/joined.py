"""FRFs of random drive from blocks that follow each other without a gap, joined to records as long as they go.

A block shorter than the ring-down cannot show a damping, whatever its window. Blocks of random drive are contiguous, so
they are joined, and the local polynomial method takes off what rings on beyond the ends of the joined record.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import DataError
from modallab.core.frf import Frf
from modallab.core.rig import Rig
from modallab.frf.estimate import lines, output_quantity
from modallab.frf.noisy_force import one_force_frf
from modallab.frf.sums import Estimator
from modallab.signals.block_sets import check_outputs, check_test
from modallab.signals.signals import Signals

Real = NDArray[np.float64]

MOST_LINES = 9000
"""Of a record: each line is a small least-squares problem of its own."""

MOST_RECORDS = 4

CLEAR = 9.0
"""Times its variance that an FRF's square is where it stands out: noise alone is so at one line in twenty."""
LEAST_CLEAR = 0.2
"""Share of the lines where one of the responses must."""


def joined_frf(signals: Sequence[Signals], rig: Rig, band_hz: tuple[float, float], estimator: Estimator = "H1") -> Frf:
    """FRF of one level's blocks of random or burst-random drive, as fine as the joined record is long.

    Args:
        signals: blocks, equal in rate and length.
        rig: names, points and quantities.
        band_hz: lines to give.
        estimator: H1, H2 or Hv; the lines about each are averaged over, so that one record will do.

    Raises:
        DataError: no blocks, blocks that differ, or a band without lines.
    """
    check_test(signals)
    first = signals[0]
    check_outputs(first, rig)
    rate = first.rate_hz
    longest = max(contiguous(signals), key=len)
    force = np.concatenate([s.force for s in longest])
    responses = np.concatenate([s.responses for s in longest], axis=1)
    n = min(force.size, max(first.force.size, int(MOST_LINES * rate / (band_hz[1] - band_hz[0]))))
    count = min(MOST_RECORDS, force.size // n)
    chosen = lines(n, rate, band_hz)
    spectrum_f = _spectrum(force[None], n, count)[..., chosen]
    values, variance = one_force_frf(spectrum_f, _spectrum(responses, n, count)[..., chosen], estimator)
    power = np.sum(np.abs(spectrum_f[:, 0]) ** 2, axis=0)
    if not power.all():
        raise DataError("the force has no content at some lines of the band", remedy="narrow the band")
    return Frf(
        frequency_hz=chosen * rate / n,
        values=values,
        quantity=output_quantity(rig),
        outputs=first.outputs,
        output_points=tuple(c.point for c in rig.responses),
        input_points=(first.block.drive_point,),
        variance=(variance / power)[:, None],
        averages=(count,),
    )


def check_followed(frf: Frf) -> None:
    """Reject an FRF that does not stand out of its own noise: the drive was off, or it is not what was recorded.

    Raises:
        DataError: the responses follow the force at few of the lines.
    """
    if frf.variance is None:
        return
    clear = np.abs(frf.values) ** 2 > CLEAR * frf.variance
    share = float(np.mean(clear.any(axis=(0, 1))))
    if share < LEAST_CLEAR:
        raise DataError(
            f"the responses do not follow the force: at {100 * share:.0f} % of the lines only the FRF stands out of "
            "its noise",
            remedy="check that the drive was on and the force channel is the force; without a force, identify the "
            "responses alone (--response-only)",
        )


def contiguous(signals: Sequence[Signals]) -> list[list[Signals]]:
    """The blocks in order, those together that follow each other without a gap."""
    runs: list[list[Signals]] = []
    for item in sorted(signals, key=lambda s: s.block.order):
        last = runs[-1][-1] if runs else None
        if last is not None and item.block.first_sample == last.block.first_sample + last.block.n_samples:
            runs[-1].append(item)
        else:
            runs.append([item])
    return runs


def _spectrum(values: Real, n: int, count: int) -> NDArray[np.complex128]:
    """(records, rows, lines) of (rows, samples)."""
    cut = values[:, : n * count].reshape(len(values), count, n).transpose(1, 0, 2)
    return np.fft.rfft(cut - values.mean(axis=1)[None, :, None])
