"""A structure known by its modal model: receptances at every pair of its freedoms, measured or not.

H(s) = sum over modes of psi psi^T / (s - lambda) and its conjugate, plus residual terms R_p s^p. At pairs that were
never measured, modes are known by reciprocity and a driving point's scale (Ewins, Modal Testing, 2nd ed. 2000,
section 2.8).
All arrays may have leading axes: samples of a model that is known with uncertainty.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Complex, Real
from modallab.core.digits import number_ranges
from modallab.core.errors import DataError
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.modification.freedoms import Freedom, factor_constants, freedoms_of
from modallab.modification.outside_band import complete_residual_terms, residual_terms_of_structure

At = int | Freedom
"""A point, or a point and an axis where several sensors stand there."""

NEAREST = 1e-9
"""Of a pole: nearer to it no receptance is computed, as rounding would be all that is left of it."""


class Receptances(Protocol):
    """A structure, with or without attachments."""

    def receptance(self, s: Complex, left: Real | None = None, right: Real | None = None) -> Complex:
        """(..., lines, left, right) m/N."""
        ...

    def motion(self, s: Complex, forces: Complex, left: Real, right: Real) -> Complex:
        """(left, lines) m, of forces (right, lines) N."""
        return np.einsum("loi,il->ol", self.receptance(s, left, right), forces, optimize=True)


@dataclass(frozen=True, eq=False, slots=True)
class Structure(Receptances):
    """Poles and shapes at all freedoms.

    Attributes:
        freedoms: (freedoms,) point and axis.
        poles: (..., modes) rad/s, those with a positive imaginary part.
        psi: (..., modes, freedoms) such that psi psi^T is the residue; m^(1/2) N^(-1/2) s^(-1/2).
        powers: (terms,) of s in the residual terms.
        residual: (..., terms, freedoms, freedoms) symmetric, real.
        alone: (terms, freedoms) what of the residual terms of a point's own pair is expected, not measured.
        known: (freedoms, freedoms) whether a pair, or the one exchanged, was measured.
        band_hz: of the model.
        drive_axis: along which forces acted.
        driven: points where forces acted.
        scaled: whether a sensor stands at one of them; without it measured pairs alone are known.
    """

    freedoms: tuple[Freedom, ...]
    poles: Complex
    psi: Complex
    powers: tuple[int, ...]
    residual: Real
    alone: Real
    known: NDArray[np.bool_]
    band_hz: tuple[float, float]
    drive_axis: str
    driven: tuple[int, ...]
    scaled: bool

    @property
    def with_scale(self) -> "Structure":
        """Itself.

        Raises:
            DataError: no sensor stands at a driven point.
        """
        if not self.scaled:
            raise DataError(
                (
                    f"no sensor stands at a driven point (driven: {number_ranges(self.driven)}), so the shapes "
                    "have no scale"
                ),
                remedy="hit once at a point that has a sensor looking along the hit, and identify all together",
            )
        return self

    def index(self, at: At) -> int:
        """Place of a freedom; of a point alone the one along the drive, or the only one.

        Raises:
            DataError: no sensor stood there and no force acted there.
        """
        if at in self.freedoms:
            return self.freedoms.index(at)
        here = [n for n, f in enumerate(self.freedoms) if f[0] == at]
        along = [n for n in here if self.freedoms[n][1] == self.drive_axis]
        for found in (along, here):
            if len(found) == 1:
                return found[0]
        points = ", ".join(dict.fromkeys(str(f[0]) for f in self.freedoms))
        raise DataError(
            f"the model knows nothing of {at!r}" if not here else f"point {at} moves along several axes in the model",
            remedy=f"name one of the points {points}" + (", with its axis, such as (3, 'z')" if here else ""),
        )

    def between(self, outputs: Sequence[At], inputs: Sequence[At]) -> "Structure":
        """Itself, for use at pairs of points.

        Raises:
            DataError: one of them was not measured, and no driving point says what it is.
        """
        rows, columns = ([self.index(a) for a in places] for places in (outputs, inputs))
        return self if self.known[np.ix_(rows, columns)].all() else self.with_scale

    def unit_vectors(self, at: Sequence[At]) -> Real:
        """(freedoms, places) unit vectors at places."""
        return np.asarray(np.eye(len(self.freedoms))[:, [self.index(a) for a in at]], np.float64)

    def first_samples(self, count: int) -> "Structure":
        """Of samples of a structure the first ones."""
        return replace(self, poles=self.poles[:count], psi=self.psi[:count], residual=self.residual[:count])

    def one_sample(self, k: int) -> "Structure":
        """Of samples of a structure a single one."""
        return replace(self, poles=self.poles[k], psi=self.psi[k], residual=self.residual[k])

    def receptance(self, s: Complex, left: Real | None = None, right: Real | None = None) -> Complex:
        """(..., lines, left, right) m/N at complex frequencies (..., lines).

        Args:
            s: leading axes as those of the structure, or none.
            left: (freedoms, left) columns; all freedoms if None.
            right: (freedoms, right) columns; all freedoms if None.
        """
        whole = np.eye(len(self.freedoms))
        left, right = whole if left is None else left, whole if right is None else right
        to, of = self.psi @ left, self.psi @ right
        up, down = self._kernels(s)
        shapes = to[..., :, None] * of[..., None, :]
        powers: Complex = s[..., None] ** np.array(self.powers, np.float64)
        terms: Complex = (left.T @ self.residual @ right).astype(np.complex128)
        return _weighted_sum(up, shapes) + _weighted_sum(down, shapes.conj()) + _weighted_sum(powers, terms)

    def _kernels(self, s: Complex) -> tuple[Complex, Complex]:
        p, q = self.poles, self.poles.conj()
        return 1 / _distance_from_poles(s[..., :, None] - p[..., None, :], p), 1 / _distance_from_poles(
            s[..., :, None] - q[..., None, :], q
        )


def _weighted_sum(weights: Complex, matrices: Complex) -> Complex:
    """(..., lines, left, right) sums of matrices (..., terms, left, right) with weights (..., lines, terms)."""
    *leading, left, right = matrices.shape
    flat = weights @ matrices.reshape(*leading, left * right)
    return flat.reshape(*flat.shape[:-1], left, right)


def _distance_from_poles(distance: Complex, poles: Complex) -> Complex:
    least = NEAREST * np.abs(poles)[..., None, :]
    return np.where(np.abs(distance) < least, least, distance)


def structure_of(model: ModalModel, rig: Rig | None = None) -> Structure:
    """The structure that a model describes.

    Args:
        model: with a driving point, or nothing gives its shapes a scale.
        rig: with the axes of its channels; without one all are taken along the drive.

    Raises:
        DataError: an output or an input has no point.
    """
    outputs, inputs = _freedoms_of_model(model, rig)
    listed = tuple(dict.fromkeys([*outputs, *inputs]))
    rows, columns = [listed.index(f) for f in outputs], [listed.index(f) for f in inputs]
    known = np.zeros((len(listed), len(listed)), bool)
    known[np.ix_(rows, columns)] = known[np.ix_(columns, rows)] = True
    poles, psi = modes_of(model.frequency_hz, model.damping_ratio, model.modal_constants, rows, columns, len(listed))
    band, powers, moved = model.band_hz, model.residual_powers, squared_shape_sum(poles, psi)
    terms = residual_terms_of_structure(residual_terms(model), powers, rows, columns, moved / max(model.n_modes, 1))
    outside = complete_residual_terms(terms, powers, rows, columns, moved, band[1])
    axis, driven, scaled = inputs[0][1], tuple(f[0] for f in inputs), bool(set(rows) & set(columns))
    return Structure(listed, poles, psi, powers, *outside, known, band, axis, driven, scaled)


def squared_shape_sum(poles: Complex, psi: Complex) -> Real:
    """(freedoms,) sum over modes of the squared shapes at unit modal mass."""
    return np.asarray(np.sum(2 * poles.imag[:, None] * np.abs(psi) ** 2, axis=0), np.float64)


def residual_terms(model: ModalModel) -> Real:
    """(terms, outputs, inputs) residual terms; none in a document have no shape."""
    return np.reshape(model.residuals, (len(model.residual_powers), *model.modal_constants.shape[1:]))


def _freedoms_of_model(model: ModalModel, rig: Rig | None) -> tuple[tuple[Freedom, ...], tuple[Freedom, ...]]:
    if rig is not None:
        return freedoms_of(model, rig)
    missing = [name for name, p in zip(model.outputs, model.output_points, strict=True) if p is None]
    if missing or None in model.input_points:
        raise DataError(
            f"no point is known of {', '.join(missing) or 'an input'}",
            remedy="give outputs and inputs the numbers of their points",
        )
    return tuple((int(p or 0), "") for p in model.output_points), tuple((int(p or 0), "") for p in model.input_points)


def modes_of(
    frequency_hz: Real, damping_ratio: Real, constants: Complex, rows: Sequence[int], columns: Sequence[int], n: int
) -> tuple[Complex, Complex]:
    """Poles (modes,) and shapes psi (modes, n) of modal constants (modes, outputs, inputs)."""
    omega = 2 * np.pi * frequency_hz
    poles = omega * (-damping_ratio + 1j * np.sqrt(1 - damping_ratio**2))
    factors = factor_constants(constants, rows, columns, n)
    seen, driven = factors.seen, factors.driven
    # What a sensor shows and what a force does differ by errors alone: a passive structure is reciprocal.
    phi = (seen + driven) / 2
    return poles, phi / np.sqrt(2j * poles.imag)[:, None]
