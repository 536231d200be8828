"""pLSCF on half spectra of responses alone.

Covariances at positive lags are free decays, R_k = sum over poles of phi g^T lambda^k. Their DFT over N lags is, at its
own lines, where z^N = 1, the sum of phi g^T (1 - lambda^N) / (1 - lambda / z): a rational function of z with the
structure's poles, whatever N cuts off. So no window is needed, and the estimator of FRFs finds the poles. What the
covariances of one segment move is read off by leaving each segment out in turn (jackknife).
Sources: Cauberghe, "Applied frequency-domain system identification in the field of experimental and operational modal
analysis", Vrije Universiteit Brussel (2004), ch. 4; Peeters et al., Shock and Vibration 11 (2004); Efron and Stein,
"The jackknife estimate of variance", Annals of Statistics 9 (1981).
"""

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Complex128, Real
from modallab.core.frf import Frf
from modallab.identification.estimators.plscf import plscf
from modallab.identification.response_only.subspace import OrderPolesWithSlopes, unit_at_largest

LAGS = 96
"""The lines are half as many."""
REFERENCES = 3
"""Reference signals: principal combinations of all responses. Up to so many modes can share one pole."""


class HalfSpectra:
    """Poles of covariances by pLSCF, up to a highest number of poles.

    Args:
        covariances: (segments, lags, outputs, outputs).
        rate_hz: of the lags.
        highest: number of poles, about.
    """

    def __init__(self, covariances: Real, rate_hz: float, highest: int) -> None:
        self._rate_hz = rate_hz
        mean = covariances.mean(axis=0)
        stacked = mean.reshape(-1, mean.shape[-1])
        self._references = min(REFERENCES, mean.shape[-1])
        chosen = np.linalg.svd(stacked, full_matrices=False)[2][: self._references].T
        self._mean = mean @ chosen
        # Without one of n segments the mean is off by that segment's deviation over n - 1, with the other sign.
        self._without = self._mean - (covariances @ chosen - self._mean) / (len(covariances) - 1)
        self._order = min(2 * highest // self._references, covariances.shape[1] // 4 - 1)

    @property
    def orders(self) -> tuple[int, ...]:
        """Orders of the polynomial, named by how many poles there are."""
        return tuple(range(self._references, (self._order + 1) * self._references, self._references))

    def at(self, order: int) -> OrderPolesWithSlopes:
        """Poles of one order with what moves them."""
        poles, shapes = self._solve_order(self._mean, order // self._references)
        count = len(self._without)
        moved = np.empty((count, poles.size), np.complex128)
        shapes_moved = np.empty((count, *shapes.shape), np.complex128)
        largest = np.argmax(np.abs(shapes), axis=1)
        for k, covariances in enumerate(self._without):
            own, own_shapes = self._solve_order(covariances, order // self._references, largest, poles)
            moved[k], shapes_moved[k] = (count - 1) * (poles - own), (count - 1) * (shapes - own_shapes)
        return OrderPolesWithSlopes(poles, shapes, moved, shapes_moved)

    def _solve_order(
        self, covariances: Real, order: int, largest: NDArray[np.int64] | None = None, like: Complex128 | None = None
    ) -> tuple[Complex128, Complex128]:
        """Poles in rad/s and shapes, those nearest to `like` in its order."""
        (found,) = plscf(self._spectra(covariances), order, order)
        poles = found.poles
        if like is not None:
            nearest = np.argmin(np.abs(poles[:, None] - like), axis=0) if poles.size else None
            poles = np.full_like(like, np.nan) if nearest is None else poles[nearest]
        decaying = np.unique(found.poles[found.poles.real < 0])
        shapes = self._shapes(covariances, decaying)
        rows = np.array([np.argmin(np.abs(decaying - p)) if decaying.size else 0 for p in poles], dtype=np.int64)
        chosen = shapes[rows] if decaying.size else np.ones((poles.size, covariances.shape[1]), np.complex128)
        return poles, unit_at_largest(chosen, largest)

    def _shapes(self, covariances: Real, poles: Complex128) -> Complex128:
        """(poles, outputs) by least squares on the decays."""
        lags, outputs, references = covariances.shape
        decays = np.exp(poles / self._rate_hz * np.arange(lags)[:, None])
        basis = np.concatenate([decays.real, -decays.imag], axis=1)
        parts = np.linalg.lstsq(basis, covariances.reshape(lags, -1), rcond=None)[0]
        residues = (parts[: poles.size] + 1j * parts[poles.size :]).reshape(poles.size, outputs, references)
        u = np.linalg.svd(residues, full_matrices=False)[0] if poles.size else residues
        return np.asarray(u[:, :, 0], np.complex128)

    def _spectra(self, covariances: Real) -> Frf:
        lags, outputs, references = covariances.shape
        spectra = np.fft.rfft(covariances, axis=0).transpose(1, 2, 0)
        return Frf(
            frequency_hz=np.arange(spectra.shape[-1]) * self._rate_hz / lags,
            values=np.ascontiguousarray(spectra),
            quantity="inertance",
            outputs=tuple(f"y{k}" for k in range(outputs)),
            output_points=(None,) * outputs,
            input_points=(None,) * references,
        )
