"""Blocks of a periodic drive as the drive's own clock would have cut them, once the structure has settled.

Generator and converter each have a clock. Where one runs some millionths faster, a block is a little less or more than
a period: every line leaks into its neighbours, and lines that the drive leaves out seem to be answered.

A periodic drive begins from rest, so that its first periods hold the free decays of the modes besides. A lightly
damped low mode may need longer to settle than a whole test takes. Blocks that follow each other are whole periods: they
differ by those decays alone, whose poles are known roughly from a first look. How large each decay is follows by least
squares from how the blocks differ; then it is taken off.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline

from modallab.core.arrays import Complex128, Real
from modallab.core.frf import Frf
from modallab.core.rig import Rig
from modallab.frf.broadband import PERIODIC, blocks_of_one_level, broadband_frf, driven_lines
from modallab.frf.distortions import ALIKE
from modallab.frf.estimate import lines_of_band
from modallab.frf.joined import contiguous_blocks, joined_frf
from modallab.frf.sums import Estimator
from modallab.signals.signals import Signals

DEGREE = 7
"""Of the splines between samples: below 2e-5 off up to a fifth of the rate."""

LEAST = 1e-8
"""Share by which two clocks may differ without a trace."""


def clock_of_drive(signals: Sequence[Signals], lines: NDArray[np.int64]) -> float:
    """How fast the drive's clock runs against the converter's, less one; 0 where no two blocks follow each other.

    A drive that runs fast by c is c periods ahead from block to block, so that line k turns by 2 pi k c.

    Args:
        signals: blocks of a periodic drive, each about a period.
        lines: of the DFT, that are driven.
    """
    turned = weight = 0.0
    for run in contiguous_blocks(signals):
        # (blocks, inputs, lines)
        force = np.stack([np.fft.rfft(s.forces)[:, lines] for s in run])
        unit = force / np.linalg.norm(force, axis=(1, 2), keepdims=True)
        # One wave may follow another without a gap.
        same = np.abs(np.sum(unit[1:] * unit[:-1].conj(), axis=(1, 2))) > ALIKE
        cross = (force[1:] * force[:-1].conj())[same]
        turned += float(np.sum(np.abs(cross) * lines * np.angle(cross)))
        weight += 2 * np.pi * float(np.sum(np.abs(cross) * lines**2))
    return turned / weight if weight else 0.0


def resample_to_drive_clock(signals: Sequence[Signals], lines: NDArray[np.int64]) -> list[Signals]:
    """The blocks resampled so that each is one period of the drive; their rate says so, in the converter's seconds.

    Args:
        signals: blocks of a periodic drive, each about a period.
        lines: of the DFT, that are driven.
    """
    clock = clock_of_drive(signals, lines)
    if abs(clock) < LEAST:
        return list(signals)
    return [one for run in contiguous_blocks(signals) for one in _resample_to_clock(run, clock)]


def _resample_to_clock(run: Sequence[Signals], clock: float) -> list[Signals]:
    n, inputs = run[0].n_samples, len(run[0].forces)
    rows = np.concatenate([np.vstack([s.forces, s.responses]) for s in run], axis=1)
    at = np.arange(rows.shape[1], dtype=np.float64)
    # About the middle, so that at either end as little as can be lies beyond the record.
    middle = at[-1] / 2
    made: Real = make_interp_spline(at, rows, k=DEGREE, axis=1)(middle + (at - middle) / (1 + clock))
    cut = made.reshape(len(rows), len(run), n)
    rate_hz = run[0].rate_hz * (1 + clock)
    return [replace(s, forces=cut[:inputs, b], responses=cut[inputs:, b], rate_hz=rate_hz) for b, s in enumerate(run)]


RANDOM = ("random", "burst-random")


def resample_blocks_to_drive_clock(signals: Sequence[Signals], band_hz: tuple[float, float]) -> list[Signals]:
    """The blocks, of a periodic drive as its own clock would have cut them: else its lines leak into one another."""
    first = signals[0]
    if first.block.test not in PERIODIC:
        return list(signals)
    return resample_to_drive_clock(
        signals, driven_lines(lines_of_band(first.n_samples, first.rate_hz, band_hz), signals)
    )


def frf_of_main_level(
    signals: Sequence[Signals], rig: Rig, band_hz: tuple[float, float], estimator: Estimator = "H1"
) -> Frf:
    """The FRF of the level that has most blocks.

    Raises:
        DataError: a band without lines, or one block of a periodic drive for H2 or Hv.
    """
    used = blocks_of_one_level(signals)
    # A block of random drive is cut out of what never ends: only the blocks together are long enough.
    made = joined_frf if used[0].block.test in RANDOM else broadband_frf
    return made(used, rig, band_hz, estimator=estimator)


def with_equal_line_weights(frf: Frf) -> Frf:
    """With lines that count alike: what varies from line to line is the drive's own level, which another look lacks."""
    return replace(frf, coherence=None, variance=None)


def without_decays(signals: Sequence[Signals], poles: Complex128, band_hz: tuple[float, float]) -> list[Signals]:
    """The blocks without the free decays of these poles, as far as the blocks of each wave differ by them.

    Args:
        signals: of one periodic drive, equal in rate and length.
        poles: (modes,) rad/s, with positive imaginary part.
        band_hz: lines by which the decays' sizes are found.
    """
    found: list[Signals] = []
    for run in contiguous_blocks(signals):
        found += _settle_run(run, poles, band_hz) if len(run) > 1 else list(run)
    return found


def _settle_run(run: Sequence[Signals], poles: Complex128, band_hz: tuple[float, float]) -> list[Signals]:
    n, rate, inputs = run[0].n_samples, run[0].rate_hz, len(run[0].forces)
    rows = np.stack([np.vstack([s.forces, s.responses]) for s in run])
    decays = _decays_of_poles(poles, len(run), n, rate)
    first, last = (round(edge * n / rate) for edge in band_hz)
    chosen = np.arange(max(1, first), min(n // 2, last) + 1)
    spectra = np.fft.rfft(rows)[..., chosen]
    # (blocks, 2 modes, lines): of the real and the imaginary part of each state.
    basis = np.fft.rfft(decays)[..., chosen]
    size = _sizes_of_decays(spectra - spectra.mean(axis=0), basis - basis.mean(axis=0))
    left = rows - np.einsum("bmn,mo->bon", decays, size)
    return [replace(s, forces=r[:inputs], responses=r[inputs:]) for s, r in zip(run, left, strict=True)]


def _decays_of_poles(poles: Complex128, blocks: int, n: int, rate_hz: float) -> Real:
    """(blocks, 2 modes, samples) real decays: of a state's real part, then of its imaginary part."""
    time = np.arange(blocks * n) / rate_hz
    decay: Complex128 = np.exp(np.outer(poles, time)).reshape(poles.size, blocks, n).transpose(1, 0, 2)
    return np.concatenate([decay.real, -decay.imag], axis=1)


def _sizes_of_decays(differences: Complex128, basis: Complex128) -> Real:
    """(2 modes, rows) by least squares over all blocks and lines."""

    def flat(values: Complex128) -> Real:
        turned = values.transpose(0, 2, 1).reshape(-1, values.shape[1])
        return np.concatenate([turned.real, turned.imag])

    return np.asarray(np.linalg.lstsq(flat(basis), flat(differences), rcond=None)[0], np.float64)
