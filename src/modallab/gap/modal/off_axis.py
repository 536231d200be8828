"""Measured FRFs off the frequency axis, whatever their model misses.

An FRF H is analytic where Re s > 0, so that its lines give it there. At s0 = sigma + j omega0 it is the mean of its
lines with weights sigma / pi / (sigma^2 + d^2), d = omega - omega0 (Poisson's integral of a half plane). So is H g for
any other analytic g. With g = (1 + (s - s0) / c)^-2 far lines count little: the band has to hold the near ones only.
A mean over lines misses a resonance narrower than their distance. So the mean is that of what a model leaves of the
lines, and the model's own FRF at s0 is added: where the lines are dense, the model cancels. Where a sensor that roves
moves the resonances by more than their width, that has to be a model of each point's own.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from modallab.core.arrays import Complex, Real
from modallab.core.frf import DERIVATIVES, Frf
from modallab.core.model import ModalModel
from modallab.frf.estimate import variance_of
from modallab.gap.modal.point_models import PointModels
from modallab.identification.frf_model import frf_in_band

REACH = 4.0
"""c over sigma."""
INSIDE = 5.0
"""A line stays so many sigma from the ends of the band: what lies beyond counts for 1 %."""
FAR = 1e-6
"""Weights below that share of the largest do not count."""
CELLS = 1.5
"""Least sigma, in distances between the lines that were measured."""


@dataclass(frozen=True, eq=False, slots=True)
class MeasuredFrfs:
    """FRFs of one side of a comparison, in the quantity that was measured.

    Attributes:
        s: (lines,) where they were measured: damping shift + j omega.
        power: times the displacement is differentiated.
        values: (lines, outputs, inputs).
        variance: (lines, outputs, inputs) of the complex numbers.
        models: of each point, identified from these.
    """

    s: Complex
    power: int
    values: Complex
    variance: Real
    models: PointModels

    @classmethod
    def of(cls, frf: Frf | None, model: ModalModel) -> "MeasuredFrfs | None":
        """In the band of the model that was identified from them; None where they are not its own, or not there."""
        if frf is None or frf.outputs != model.outputs or frf.values.shape[:2] != model.modal_constants.shape[1:]:
            return None
        lines = frf_in_band(frf, model.band_hz)
        s = frf.damping_shift + 2j * np.pi * lines.frequency_hz
        values, variance = np.moveaxis(lines.values, -1, 0), np.moveaxis(variance_of(lines), -1, 0)
        return cls(np.asarray(s), DERIVATIVES[frf.quantity], values, variance, PointModels.of(lines, model))

    def sigma_at(self, omega: Real, wanted: Real) -> Real:
        """(lines,) Re s at which they are known at omega (lines,), as near to what is wanted as can be; 0 for none."""
        ends = np.minimum(omega - self.s[0].imag, self.s[-1].imag - omega)
        cell = np.interp(omega, self.s.imag, np.gradient(self.s.imag))
        found = np.minimum(wanted, ends / INSIDE) + self.s[0].real
        return np.where(ends >= INSIDE * CELLS * cell, np.maximum(found, CELLS * cell + self.s[0].real), 0.0)

    @property
    def receptances(self) -> Complex:
        """(lines, outputs, inputs) m/N."""
        return np.asarray(self.values / self.s[:, None, None] ** self.power)

    def chosen(self, rows: list[int], columns: list[int], turned: Real) -> "MeasuredFrfs":
        """Some outputs and inputs, each turned by its sign (outputs, inputs)."""
        values, models = self.values[:, rows][:, :, columns] * turned, self.models.chosen(rows, columns, turned)
        return MeasuredFrfs(self.s, self.power, values, self.variance[:, rows][:, :, columns], models)

    def means_at(self, s: Complex) -> "Means":
        """What gives FRFs at complex frequencies (lines,)."""
        return Means(self, s, self.weights(s), self.models.receptances(self.s), self.models.receptances(s))

    def weights(self, s: Complex) -> sparse.csr_array:
        """(lines, lines that were measured) of the mean at each s."""
        omega = self.s.imag
        edges = np.concatenate([omega[:1], (omega[1:] + omega[:-1]) / 2, omega[-1:]])
        sigma = (s.real - self.s[0].real)[:, None]
        poisson = np.diff(np.arctan((edges - s.imag[:, None]) / sigma), axis=1) / np.pi
        whole = poisson / (1 + (self.s - s[:, None]) / (REACH * sigma)) ** 2
        whole[np.abs(whole) < FAR * np.abs(whole).max(axis=1, keepdims=True)] = 0.0
        return sparse.csr_array(whole)


@dataclass(frozen=True, eq=False, slots=True)
class Means:
    """FRFs off the axis as means of measured lines.

    Attributes:
        of: what was measured.
        s: (lines,) complex frequencies.
        weights: (lines, lines that were measured).
        on_lines: (lines that were measured, outputs, inputs) the models' receptances.
        off_axis: (lines, outputs, inputs) the same at s.
    """

    of: MeasuredFrfs
    s: Complex
    weights: sparse.csr_array
    on_lines: Complex
    off_axis: Complex

    def at(self, s: Complex) -> "Means":
        """Elsewhere."""
        return replace(self, s=s, weights=self.of.weights(s), off_axis=self.of.models.receptances(s))

    def thinned(self, lines: slice) -> "Means":
        """At some of the lines."""
        return replace(self, s=self.s[lines], weights=self.weights[lines], off_axis=self.off_axis[lines])

    def changed(self, by: Callable[[Complex, Complex], Complex]) -> Complex:
        """(lines, outputs, inputs) receptances changed by what is made of receptances at complex frequencies."""
        left = by(self.of.receptances, self.of.s) - by(self.on_lines, self.of.s)
        return self._mean(left) + by(self.off_axis, self.s)

    @property
    def receptances(self) -> Complex:
        """(lines, outputs, inputs) m/N."""
        return self.changed(lambda of, _: of)

    def _mean(self, receptances: Complex) -> Complex:
        flat = (receptances * self.of.s[:, None, None] ** self.of.power).reshape(self.of.s.size, -1)
        found = np.asarray(self.weights @ flat).reshape(self.s.size, *receptances.shape[1:])
        return found / self.s[:, None, None] ** self.of.power

    def noise(self) -> Complex:
        """(lines, lines, outputs, inputs) covariance of the noise of receptances."""
        weights = sparse.csr_array(sparse.diags_array(1 / self.s**self.of.power) @ self.weights)
        variance = self.of.variance.reshape(self.of.s.size, -1)
        pairs = [weights.multiply(np.conj(weights[[m]].toarray())) @ variance for m in range(self.s.size)]
        found = np.stack(pairs, axis=1).reshape(self.s.size, self.s.size, *self.of.variance.shape[1:])
        return found + self._unseen()

    def _unseen(self) -> Complex:
        """(lines, lines, outputs, inputs) covariance of what the models leave, for lying between the lines.

        It may be of any of their modes, as large as it is where that mode is over all FRFs, and is then missed as that
        mode is: at this FRF, or at others.
        """
        found = np.zeros((self.s.size, *self.off_axis.shape), np.complex128)
        left = np.abs(self.of.receptances - self.on_lines) ** 2
        for mode in self.of.models.modes:
            on_lines, size = mode.receptances(self.of.s), np.sum(np.abs(mode.constants) ** 2, axis=0)
            power, missed = np.abs(on_lines) ** 2, mode.receptances(self.s) - self._mean(on_lines)
            share = np.sum(power * left) / np.sum(power**2)
            own = np.einsum("loi,moi->lmoi", missed, np.conj(missed))
            found += share * (own + own.sum(axis=(2, 3))[:, :, None, None] * size / np.sum(size))
        return found
