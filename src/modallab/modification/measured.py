"""FRFs of a model as they were measured where they were, and by the products of its shapes elsewhere."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.core.model import ModalModel
from modallab.modification.samples import places_of
from modallab.modification.structure import Structure, terms_of


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
        rows, columns = (np.array(places) for places in places_of(model, structure))
        residue, terms = np.einsum("ro,ri->roi", structure.psi, structure.psi), structure.residual.copy()
        own = model.modal_constants / (2j * structure.poles.imag)[:, None, None]
        own_terms = terms_of(model)
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
