"""FRFs of a model at pairs of points, measured ones or not, with their uncertainty."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.core.errors import DataError
from modallab.core.frf import DERIVATIVES, Frf, FrfQuantity
from modallab.core.model import ModalModel
from modallab.modification.samples import freedom_indices
from modallab.modification.structure import At, Receptances, Structure, residual_terms


@dataclass(frozen=True, eq=False, slots=True)
class MeasuredPairs:
    """A model's own constants at measured pairs, and the products of its shapes at the others.

    Attributes:
        poles: (modes,) rad/s.
        residue: (modes, freedoms, freedoms) at the poles.
        powers: (terms,) of s in the residual terms.
        terms: (terms, freedoms, freedoms) residual terms.
    """

    poles: Complex
    residue: Complex
    powers: tuple[int, ...]
    terms: Real

    @classmethod
    def of(cls, model: ModalModel, structure: Structure) -> "MeasuredPairs":
        """With the model's constants at a pair, and where only the exchanged one was measured, with those of that."""
        rows, columns = (np.array(places) for places in freedom_indices(model, structure))
        residue, terms = np.einsum("ro,ri->roi", structure.psi, structure.psi), structure.residual.copy()
        own = model.modal_constants / (2j * structure.poles.imag)[:, None, None]
        own_terms = residual_terms(model)
        # The exchanged pairs first, so that a pair of its own measurement keeps it.
        residue[:, columns[:, None], rows] = own.transpose(0, 2, 1)
        residue[:, rows[:, None], columns] = own
        terms[:, columns[:, None], rows] = own_terms.transpose(0, 2, 1)
        terms[:, rows[:, None], columns] = own_terms
        return cls(structure.poles, residue, structure.powers, terms)

    def receptance(self, s: Complex, left: Real | None = None, right: Real | None = None) -> Complex:
        """(lines, left, right) m/N; left and right are unit vectors, all if None."""
        whole = np.eye(self.residue.shape[1])
        right = whole if right is None else right
        ones = np.ones((1, s.size), np.complex128)
        return np.stack(
            [self.motion(s, ones, whole if left is None else left, right[:, [i]]).T for i in range(right.shape[1])],
            axis=2,
        )

    def motion(self, s: Complex, forces: Complex, left: Real, right: Real) -> Complex:
        """(left, lines) m, of forces (right, lines) N."""
        residue, terms = left.T @ self.residue @ right, left.T @ self.terms @ right
        moved = np.zeros((left.shape[1], s.size), np.complex128)
        up, down = 1 / (s - self.poles[:, None]), 1 / (s - self.poles.conj()[:, None])
        powers = np.array([s**p for p in self.powers]).reshape(-1, s.size)
        for i, force in enumerate(forces):
            moved += residue[:, :, i].T @ (up * force) + residue[:, :, i].conj().T @ (down * force)
            moved += terms[:, :, i].T @ (powers * force)
        return moved


def receptance_of_modes(model: ModalModel, s: Complex) -> Complex:
    """(lines, modes) receptance of each mode of unit constant at complex frequencies."""
    omega, zeta = 2 * np.pi * model.frequency_hz, model.damping_ratio
    return np.asarray(1 / (s[:, None] ** 2 + 2 * zeta * omega * s[:, None] + omega**2))


def receptances_of_model(model: ModalModel, s: Complex) -> Complex:
    """(lines, outputs, inputs) receptances of a model at complex frequencies (lines,)."""
    return np.einsum("lr,roi->loi", receptance_of_modes(model, s), model.modal_constants) + outside_band_receptances(
        model, s
    )


def outside_band_receptances(model: ModalModel, s: Complex) -> Complex:
    """(lines, outputs, inputs) what lies outside the band."""
    powers = s[:, None] ** np.array(model.residual_powers, dtype=float)
    return np.einsum("lp,poi->loi", powers, model.residuals.astype(np.complex128))


def frfs_without_shapes(model: ModalModel, s: Complex, out: Complex, into: Complex) -> Complex:
    """(lines, outputs, inputs) FRFs without the products of shapes out (outputs, modes) and into (inputs, modes)."""
    return receptances_of_model(model, s) - np.einsum("lr,or,ir->loi", receptance_of_modes(model, s), out, into)


CHUNK = 64
"""Lines of all samples that are computed at once."""


LOWEST = 1e-3
"""Of the upper edge of a band that begins at 0 Hz: the first line of FRFs."""
HALF_WIDTHS = np.array([-16, -8, -4, -2, -1, -0.5, 0, 0.5, 1, 2, 4, 8, 16])
"""From a pole, in half its bandwidth: over them a peak falls to a sixteenth."""


def frf_between(
    structure: Structure,
    now: Receptances,
    samples: Receptances | None,
    f: object,
    outputs: Sequence[At],
    inputs: Sequence[At],
    quantity: FrfQuantity,
) -> Frf:
    """FRFs between points.

    Args:
        structure: names the points.
        now: what they are of: the structure itself, or with attachments.
        samples: of the same, for the variance; None for none.
        f: (lines,) Hz, ascending, above 0.
        outputs: points.
        inputs: points.
        quantity: receptance, mobility or inertance.

    Raises:
        DataError: frequencies that do not ascend from above 0, or a point that the model does not know.
    """
    hz = frequencies_of(f)
    if quantity not in DERIVATIVES:
        raise DataError(f"no FRF is called {quantity!r}", remedy=f"use one of {', '.join(DERIVATIVES)}")
    left, right, s = structure.unit_vectors(outputs), structure.unit_vectors(inputs), np.asarray(2j * np.pi * hz)
    factor = (s ** DERIVATIVES[quantity])[:, None, None]
    values = np.moveaxis(now.receptance(s, left, right) * factor, 0, -1)
    variance = None
    if samples is not None:
        parts = np.array_split(s, max(1, -(-hz.size // CHUNK)))
        spread = np.concatenate([np.var(samples.receptance(part, left, right), axis=0) for part in parts])
        variance = np.moveaxis(spread * np.abs(factor) ** 2, 0, -1)
    points = [[structure.freedoms[structure.index(a)] for a in places] for places in (outputs, inputs)]
    names = tuple(f"{p}{axis}" for p, axis in points[0])
    return Frf(
        hz,
        np.ascontiguousarray(values),
        quantity,
        names,
        tuple(p for p, _ in points[0]),
        tuple(p for p, _ in points[1]),
        variance=variance,
    )


def frequencies_of(f: object) -> Real:
    """(lines,) Hz.

    Raises:
        DataError: they are no numbers above 0 that ascend.
    """
    hz = np.atleast_1d(np.asarray(f, np.float64))
    if hz.ndim != 1 or not hz.size or not np.isfinite(hz).all() or hz[0] <= 0 or np.any(np.diff(hz) <= 0):
        raise DataError("the frequencies do not ascend from above 0 Hz", where="f", remedy="sort them, and leave 0 out")
    return hz


def lines_with_peaks(band_hz: tuple[float, float], even: int, *poles: Complex) -> Real:
    """(lines,) Hz evenly over a band, and more about each pole in it: a narrow peak lies between even lines.

    Args:
        band_hz: lower and upper edge; a band from 0 Hz on begins at a thousandth of its upper edge.
        even: how many evenly.
        poles: (poles,) rad/s, of one structure or several.
    """
    low, high = band_hz
    first = max(low, LOWEST * high)
    every = np.concatenate([np.zeros(0, np.complex128), *poles])[:, None]
    near = (every.imag + np.abs(every.real) * HALF_WIDTHS).ravel() / (2 * np.pi)
    within = near[(near > first) & (near < high)]
    return np.unique(np.concatenate([np.linspace(first, high, even), within])).astype(np.float64)
