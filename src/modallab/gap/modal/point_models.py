"""A model of each point of measured FRFs, with poles of its own: a sensor that roves moves the resonances a little."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.core.errors import IdentificationError
from modallab.core.frf import Frf
from modallab.core.model import ModalModel
from modallab.identification.likelihood.basis import RESIDUAL_POWERS, STAND_INS
from modallab.identification.model.modal_model import readings_of_fit
from modallab.identification.setups.roving import poles_at_points, roved_axis

SPREAD = (1e-3, 0.5)
"""Relative deviation of a point's own frequencies and damping ratios from those of all points."""


@dataclass(frozen=True, eq=False, slots=True)
class PointModels:
    """Poles and residues of every FRF.

    Attributes:
        omega: (modes, outputs, inputs) rad/s.
        zeta: (modes, outputs, inputs).
        constants: (modes, outputs, inputs) modal constants.
        terms: (powers, outputs, inputs) residual terms.
        powers: of s in these.
    """

    omega: Real
    zeta: Real
    constants: Complex
    terms: Real
    powers: tuple[int, ...]

    @classmethod
    def of(cls, frf: Frf, model: ModalModel) -> "PointModels":
        """Fitted point by point, about the poles of the model of all; as that model where no fit is found.

        Args:
            frf: lines in the model's band.
            model: identified from them.
        """
        try:
            return cls._fitted(frf, model)
        except IdentificationError:
            shape = (model.n_modes, *frf.values.shape[:2])
            each = (2 * np.pi * model.frequency_hz, model.damping_ratio)
            omega, zeta = (np.broadcast_to(of[:, None, None], shape) for of in each)
            return cls(omega, zeta, model.modal_constants, model.residuals, model.residual_powers)

    @classmethod
    def _fitted(cls, frf: Frf, model: ModalModel) -> "PointModels":
        centre = np.stack([2 * np.pi * model.frequency_hz, model.damping_ratio], axis=1)
        fits, axis = poles_at_points(frf, centre, centre * np.array(SPREAD), STAND_INS).fits, roved_axis(frf)
        seen = [readings_of_fit(fit) for fit in fits]
        constants = np.concatenate([one.constants for one in seen], axis=1 + axis)
        at = np.array([(fit.point.parameters.omega, fit.point.parameters.zeta) for fit in fits])
        poles = np.moveaxis(at, 0, -1)[..., None, :] if axis else np.moveaxis(at, 0, -1)[..., None]
        omega, zeta = np.broadcast_to(poles, (2, *constants.shape))
        return cls(omega, zeta, constants, np.concatenate([one.terms for one in seen], axis=1 + axis), RESIDUAL_POWERS)

    def chosen(self, rows: Sequence[int], columns: Sequence[int], turned: Real) -> "PointModels":
        """Of some outputs and inputs, each turned by its sign (outputs, inputs)."""
        omega, zeta = self.omega[:, rows][:, :, columns], self.zeta[:, rows][:, :, columns]
        constants, terms = self.constants[:, rows][:, :, columns], self.terms[:, rows][:, :, columns]
        return PointModels(omega, zeta, constants * turned, terms * turned, self.powers)

    @property
    def modes(self) -> Iterator["PointModels"]:
        """Each alone."""
        for omega, zeta, constants in zip(self.omega, self.zeta, self.constants, strict=True):
            yield PointModels(omega[None], zeta[None], constants[None], self.terms[:0], ())

    def receptances(self, s: Complex) -> Complex:
        """(lines, outputs, inputs) at complex frequencies (lines,), m/N."""
        at = s[:, None, None]
        found = np.einsum("lp,poi->loi", s[:, None] ** np.array(self.powers, float), self.terms)
        for omega, zeta, constants in zip(self.omega, self.zeta, self.constants, strict=True):
            found += constants / (at**2 + 2 * zeta * omega * at + omega**2)
        return np.asarray(found, np.complex128)
