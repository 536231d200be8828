"""FRFs of random drive from blocks that follow each other without a gap, joined to records as long as they go.

A block shorter than the ring-down cannot show a damping, whatever its window. Blocks of random drive are contiguous, so
they are joined, and the local polynomial method takes off what rings on beyond the ends of the joined record.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from modallab.core.arrays import Complex128, Real
from modallab.core.errors import DataError
from modallab.core.frf import Frf
from modallab.core.rig import Rig
from modallab.frf.broadband import PERIODIC
from modallab.frf.estimate import lines_of_band, output_quantity
from modallab.frf.local_polynomial import frf_of_one_force
from modallab.frf.sums import Estimator
from modallab.signals.block_sets import check_outputs, check_test
from modallab.signals.signals import Signals

MOST_LINES = 9000
"""Of a record: each line is a small least-squares problem of its own."""

MOST_RECORDS = 4
"""That an FRF is made of."""
LINES_A_FORCE = 4
"""To either side of a line, over which the powers of several forces are averaged."""

CLEAR = 9.0
"""Times its variance that an FRF's square is where it stands out: noise alone is so at one line in twenty."""
LEAST_CLEAR = 0.2
"""Share of the lines where one of the responses must."""


def joined_frf(signals: Sequence[Signals], rig: Rig, band_hz: tuple[float, float], estimator: Estimator = "H1") -> Frf:
    """FRF of one level's blocks of random or burst-random drive by every force, as fine as the joined record is long.

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
    spectra = joined_spectra(signals, band_hz)
    force, response = spectra.force[:MOST_RECORDS], spectra.response[:MOST_RECORDS]
    values, variance = frf_of_one_force(force, response, estimator)
    per_noise = _per_noise(force)
    return Frf(
        frequency_hz=spectra.frequency_hz,
        values=values,
        quantity=output_quantity(rig),
        outputs=first.outputs,
        output_points=tuple(c.point for c in rig.responses),
        input_points=first.block.driven_points,
        variance=variance[:, None] * per_noise,
        averages=(len(force),) * force.shape[1],
    )


@dataclass(frozen=True, eq=False, slots=True)
class RecordSpectra:
    """DFT of records of one length, at the lines of a band, without any window in time.

    Attributes:
        frequency_hz: (lines,)
        samples: of each record.
        rate_hz: sampling rate.
        force: (records, inputs, lines).
        response: (records, outputs, lines).
    """

    frequency_hz: Real
    samples: int
    rate_hz: float
    force: Complex128
    response: Complex128


def joined_spectra(signals: Sequence[Signals], band_hz: tuple[float, float]) -> RecordSpectra:
    """Spectra of blocks joined where they follow each other without a gap, in records as long as may be.

    Raises:
        DataError: a band without lines.
    """
    first, runs = signals[0], contiguous_blocks(signals)
    rate, long = first.rate_hz, max(sum(s.n_samples for s in run) for run in runs)
    n = min(long, max(first.n_samples, int(MOST_LINES * rate / (band_hz[1] - band_hz[0]))))
    chosen = lines_of_band(n, rate, band_hz)
    force, response = (
        np.concatenate([_spectrum(np.concatenate(rows, axis=1), n)[..., chosen] for rows in of_runs])
        for of_runs in ([[s.forces for s in run] for run in runs], [[s.responses for s in run] for run in runs])
    )
    return RecordSpectra(chosen * rate / n, n, rate, force, response)


def _per_noise(force: NDArray[np.complex128]) -> Real:
    """(inputs, lines) variance of an FRF over that of a response's line: the diagonal of the forces' inverted powers.

    One line of one record does not tell several forces apart: their powers are means over the lines that the local
    polynomials reach over.

    Args:
        force: (records, inputs, lines)
    """
    inputs = force.shape[1]
    width = 1 if inputs == 1 else 2 * LINES_A_FORCE * inputs + 1
    powers = np.einsum("ril,rjl->ijl", force, force.conj())
    smooth = ndimage.uniform_filter1d(powers.real, width, axis=-1) + 1j * ndimage.uniform_filter1d(
        powers.imag, width, axis=-1
    )
    if not np.einsum("iil->il", smooth).real.all():
        raise DataError("the force has no content at some lines of the band", remedy="narrow the band")
    return np.einsum("lii->il", np.linalg.inv(smooth.transpose(2, 0, 1))).real


def check_responses_follow(frf: Frf) -> None:
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
            f"the responses do not follow the force: at {100 * share:.0f} % of the lines the FRF alone exceeds its "
            "noise",
            remedy="check that the drive was on and the force channel is the force; without a force, identify the "
            "responses alone (--response-only)",
        )


def contiguous_blocks(signals: Sequence[Signals]) -> list[list[Signals]]:
    """The blocks in order, those together that follow each other without a gap."""
    runs: list[list[Signals]] = []
    for item in sorted(signals, key=lambda s: s.block.order):
        last = runs[-1][-1] if runs else None
        if last is not None and item.block.first_sample == last.block.first_sample + last.block.n_samples:
            runs[-1].append(item)
        else:
            runs.append([item])
    return runs


def _spectrum(values: Real, n: int) -> Complex128:
    """(records, rows, frequencies) of (rows, samples)."""
    count = values.shape[1] // n
    cut = values[:, : n * count].reshape(len(values), count, n).transpose(1, 0, 2)
    return np.fft.rfft(cut - values.mean(axis=1)[None, :, None])


def fewest_blocks(signals: Sequence[Signals], estimator: Estimator) -> int:
    """How many blocks of a test have an FRF of their own.

    A block of one periodic force holds a whole period: one by itself will do, but for H2 and Hv, which need an average.
    Several take two blocks of each of as many waves.
    """
    first = signals[0]
    if first.block.test not in PERIODIC:
        return 2
    one = 1 if estimator == "H1" else 2
    return one if len(first.forces) == 1 else 2 * len(first.forces)


def split_blocks(signals: Sequence[Signals], count: int) -> list[list[Signals]]:
    """The blocks in so many parts of one size, in the order of time; what is left over at the end is in none.

    Several periodic forces are distinguished by their waves: there a part has its share of each, of about one size.
    """
    ordered = sorted(signals, key=lambda s: s.block.order)
    if len(ordered[0].forces) == 1 or ordered[0].block.test not in PERIODIC:
        each = len(ordered) // count
        return [ordered[k * each : (k + 1) * each] for k in range(count)]
    found: list[list[Signals]] = [[] for _ in range(count)]
    for run in contiguous_blocks(ordered):
        for place, one in enumerate(run):
            found[place * count // len(run)].append(one)
    return found
