"""What responses hold of modes whose poles are known from other set-ups.

With given poles, covariances are linear in their residues: least squares finds them however weak a mode is, and what
the segments scatter by says how well each component is known.
"""

from collections.abc import Sequence

import numpy as np

from modallab.core.arrays import Complex128, Real
from modallab.identification.response_only.covariances import covariances_by_band, segment_covariances
from modallab.identification.response_only.looks import SSI_COV


def shapes_at(
    records: Sequence[Real], rate_hz: float, band_hz: tuple[float, float], frequency_hz: Real, damping_ratio: Real
) -> tuple[Complex128, Real]:
    """Shapes (modes, outputs) of any scale, and their sigmas.

    Args:
        records: each (outputs, samples), of one set-up.
        rate_hz: their rate.
        band_hz: where the modes were looked for.
        frequency_hz: (modes,) of all modes of the structure in the band.
        damping_ratio: (modes,)

    Raises:
        DataError: too short records.
    """
    still = [r - r.mean(axis=1, keepdims=True) for r in records]
    shapes = np.full((frequency_hz.size, len(still[0])), np.nan, np.complex128)
    sigma = np.full(shapes.shape, np.inf)
    omega = 2 * np.pi * frequency_hz
    poles = omega * (-damping_ratio + 1j * np.sqrt(1 - damping_ratio**2))
    for band in covariances_by_band(still, rate_hz, band_hz):
        own = np.flatnonzero((frequency_hz >= band.low_hz) & (frequency_hz <= band.high_hz))
        if own.size:
            lags = SSI_COV.lags(len(still[0]))[0]
            residues = _residues_of_decays(segment_covariances(band, lags), poles / band.rate_hz)
            for r in own:
                shapes[r], sigma[r] = _mean_shape(residues[:, r])
    return shapes, sigma


def _residues_of_decays(covariances: Real, exponents: Complex128) -> Complex128:
    """(segments, modes, outputs, outputs) of decays exp(exponent lag) in (segments, lags, outputs, outputs)."""
    segments, lags, outputs, _ = covariances.shape
    decays = np.exp(exponents * np.arange(lags)[:, None])
    basis = np.concatenate([decays.real, -decays.imag], axis=1)
    parts = np.linalg.pinv(basis) @ covariances.transpose(1, 0, 2, 3).reshape(lags, -1)
    both = parts.reshape(2, exponents.size, segments, outputs, outputs)
    return (both[0] + 1j * both[1]).transpose(1, 0, 2, 3)


def _mean_shape(residues: Complex128) -> tuple[Complex128, Real]:
    """(outputs,) by which the mean of (segments, outputs, outputs) is best repeated, and its sigma."""
    count = len(residues)
    _, s, vh = np.linalg.svd(residues.mean(axis=0))
    each = residues @ vh[0].conj() / s[0]
    shape = each.mean(axis=0)
    # How loud a segment was says nothing of the shape.
    left = each - np.outer(each @ shape.conj() / np.vdot(shape, shape).real, shape)
    return shape, np.sqrt(np.sum(np.abs(left) ** 2, axis=0) / (count * (count - 1)))
