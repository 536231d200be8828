"""Wide ranges with many modes, cut into bands at the valleys of the CMIF.

Sources: Williams, Crowley, Vold, "The multivariate mode indicator function in
modal analysis", IMAC 3 (1985); Shih, Tsuei, Allemang, Brown, "Complex mode indication function and its applications to
spatial domain parameter estimation", MSSP 2 (1988).

One polynomial over a wide range must be of an order so high that its equations lose their digits. Cut into bands, with
some lines of the neighbours on either side, each needs a low one. What is found is joined, and refined over the whole
range at once.
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.core.frf import Frf
from modallab.frf.estimate import convert_frf
from modallab.signals.peaks import prominent_peaks


def mmif(frf: Frf) -> Real:
    """Multivariate MIF (inputs, lines), lowest first: as many curves dip at a line as modes are there.

    Eigenvalues of Hr^T Hr f = mu (Hr^T Hr + Hi^T Hi) f, the in-phase share that the best mix of forces leaves.

    Raises:
        DataError: no FRF, or a line at 0 Hz of other than receptance.
    """
    values = np.moveaxis(convert_frf(frf, "receptance").values, -1, 0)
    in_phase = values.real.transpose(0, 2, 1) @ values.real
    quadrature = values.imag.transpose(0, 2, 1) @ values.imag
    total = in_phase + quadrature
    size = np.trace(total, axis1=1, axis2=2)[:, None, None] * np.eye(total.shape[1])
    factor = np.linalg.cholesky(total + 1e-13 * size + np.finfo(float).tiny * np.eye(total.shape[1]))
    half = np.linalg.solve(factor, in_phase)
    whole = np.linalg.solve(factor, half.transpose(0, 2, 1))
    left = np.linalg.eigvalsh((whole + whole.transpose(0, 2, 1)) / 2)
    return np.asarray(np.clip(left, 0, 1).T, np.float64)


def cmif(frf: Frf) -> Real:
    """CMIF (min(outputs, inputs), lines): singular values of the FRF matrix squared, largest first.

    Raises:
        DataError: as for `mmif`.
    """
    values = np.moveaxis(convert_frf(frf, frf.quantity).values, -1, 0)
    return np.asarray(np.linalg.svd(values, compute_uv=False).T ** 2, np.float64)


MOST_PEAKS = 15
"""Peaks of the CMIF in one band."""
PROMINENCE_DB = 6.0
OVERLAP = 0.15
"""Lines of the neighbours on either side, as a share of the band's own: a mode at a cut is whole in one of the two."""
LEAST_LINES = 64


@dataclass(frozen=True, slots=True)
class SearchBand:
    """The modes from `low_hz` to `high_hz` are its own; its lines, `first` to `stop`, reach into the neighbours."""

    low_hz: float
    high_hz: float
    first: int
    stop: int

    def cut(self, frf: Frf) -> Frf:
        """The FRF at the band's lines."""
        here = slice(self.first, self.stop)
        return replace(
            frf, frequency_hz=frf.frequency_hz[here], values=frf.values[..., here], coherence=None, variance=None
        )

    def own(self, poles: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """The poles that belong to this band and to no other."""
        frequency = np.abs(poles) / (2 * np.pi)
        return poles[(frequency >= self.low_hz) & (frequency < self.high_hz)]


def split_bands(frf: Frf, most: int = MOST_PEAKS) -> list[SearchBand]:
    """Bands of at most so many peaks of the CMIF each, cut at its valleys; one band where there are no more peaks.

    Args:
        frf: any quantity.
        most: peaks in a band.

    Raises:
        DataError: the FRF is not finite, or has no phase.
    """
    level = 10 * np.log10(np.maximum(cmif(convert_frf(frf, "mobility"))[0], np.finfo(float).tiny))
    peaks = prominent_peaks(level, PROMINENCE_DB)
    cuts = _band_edges(level, peaks, most)
    edges = [0, *cuts, level.size]
    f = frf.frequency_hz
    found: list[SearchBand] = []
    for low, high in pairwise(edges):
        margin = int(OVERLAP * (high - low)) + 1
        first, stop = max(0, low - margin), min(level.size, high + margin)
        bottom = 0.0 if low == 0 else float(f[low])
        found.append(SearchBand(bottom, np.inf if high == level.size else float(f[high]), first, stop))
    return found


def _band_edges(level: NDArray[np.float64], peaks: NDArray[np.int64], most: int) -> list[int]:
    """Places of the deepest valleys near where even shares of the peaks would end."""
    n_bands = -(-peaks.size // most)
    cuts: list[int] = []
    for k in range(1, n_bands):
        at = round(k * peaks.size / n_bands)
        near = range(max(1, at - most // 5), min(peaks.size, at + most // 5 + 1))
        valleys = [int(peaks[i - 1]) + int(np.argmin(level[peaks[i - 1] : peaks[i] + 1])) for i in near]
        best = min(valleys, key=lambda place: level[place])
        last = cuts[-1] if cuts else 0
        if best - last >= LEAST_LINES and level.size - best >= LEAST_LINES:
            cuts.append(best)
    return cuts
