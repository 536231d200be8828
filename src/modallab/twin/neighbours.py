"""The modes of structures next to one, to first order in what differs, many at once.

Without dampers Fox and Kapoor, AIAA J. 6 (1968), 2426, eqs. 4 and 16, the modes beyond those kept by their static
compliance; what damping then couples by the same expansion over the complex modes (Adhikari, AIAA J. 37, 1999, 1452).
"""

from collections.abc import Callable, Sequence

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.twin.elements import beam_matrices, shape_rows
from modallab.twin.matrices import (
    OWN,
    Term,
    Terms,
    mass_terms,
    stiffness_terms,
    term_matrix,
    term_rows,
    terms_at_places,
)
from modallab.twin.modes import (
    TwinModes,
    damped_poles,
    damping_of,
    is_clamped_at_root,
    solve_modes,
    undamped_modes,
    with_side_modes,
)
from modallab.twin.structure import MODES, TwinStructure


class NeighbourStructures:
    """The modes of structures next to one."""

    def __init__(self, structure: TwinStructure) -> None:
        """Solve the structure in the middle."""
        self._middle = structure
        self._omega, self._phi, self._out_of_band = undamped_modes(structure)
        if structure.dampers:
            self._poles, self._mixing = damped_poles(structure, self._omega, self._phi)
        else:
            damped = self._omega * np.sqrt(np.maximum(1 - structure.zeta**2, 1e-6))
            self._poles = -structure.zeta * self._omega + 1j * damped
            self._mixing = np.diag(1 / np.sqrt(2j * damped)).astype(np.complex128)
        self._damping = damping_of(structure, self._omega, self._phi)
        whole = np.concatenate([self._poles, self._poles.conj()])
        apart = self._poles - whole[:, None]
        self._near = np.where(apart == 0, 0.0, 1 / np.where(apart == 0, 1.0, apart))
        self._whole = np.concatenate([self._mixing, self._mixing.conj()], axis=1)

    def solve(self, structures: Sequence[TwinStructure]) -> list[TwinModes]:
        """The modes of each; exactly where no first order leads there."""
        followed = len(self._poles) == MODES and not np.any(self._poles.imag == 0)
        near = [k for k, s in enumerate(structures) if followed and self._same_freedoms(s)]
        found = dict(zip(near, self._first_order([structures[k] for k in near]), strict=True))
        return [with_side_modes(s, found[k]) if k in found else solve_modes(s) for k, s in enumerate(structures)]

    def _same_freedoms(self, s: TwinStructure) -> bool:
        here = self._middle
        return (s.length_m, s.hung, is_clamped_at_root(s)) == (here.length_m, here.hung, is_clamped_at_root(here))

    def _first_order(self, structures: list[TwinStructure]) -> list[TwinModes]:
        """The modes of bending of each."""
        if not structures:
            return []
        omega, phi = self._undamped(structures)
        poles, mixing = self._coupled(structures, omega, phi)
        columns, rest = phi[:, :OWN] @ mixing, self._out_of_band[:OWN, :OWN]
        return [TwinModes(p, c, self._middle.length_m, rest) for p, c in zip(poles, columns, strict=True)]

    def _undamped(self, structures: list[TwinStructure]) -> tuple[Real, Real]:
        """(structures, MODES) rad/s and (structures, n, MODES) shapes."""
        phi, squared = self._phi, self._omega**2
        pattern = beam_matrices(self._middle.length_m)
        heavier = self._changed(mass_terms, structures, pattern.mass)
        # Columns: what the change does on each mode.
        pushed = self._changed(stiffness_terms, structures, pattern.stiffness) - heavier * squared
        coupling = phi.T @ pushed
        apart = squared - squared[:, None]
        mixing = coupling / np.where(apart == 0, np.inf, apart)
        own = np.arange(MODES)
        mixing[:, own, own] -= 0.5 * np.sum(phi * heavier, axis=1)
        moved = phi + phi @ mixing - self._out_of_band @ pushed
        return np.sqrt(np.maximum(squared + coupling[:, own, own], 1e-12)), moved

    def _changed(
        self, terms_of: Callable[[TwinStructure], Terms], structures: list[TwinStructure], fields: Real
    ) -> Real:
        """(structures, n, MODES) what their change of stiffness or of inertia does on each mode."""
        change = _differences_of_terms(terms_of(self._middle), [terms_of(s) for s in structures])
        placed = terms_at_places(change)
        others = [t for t in change if t not in set(placed)]
        length, phi = self._middle.length_m, self._phi[:OWN]
        rows = term_rows(placed, length)
        products = np.zeros((len(change), *self._phi.shape))
        products[: len(placed), :OWN] = rows[:, :, None] * (rows @ phi)[:, None, :]
        for k, term in enumerate(others, len(placed)):
            products[k, :OWN] = term_matrix(term, fields, length) @ phi
        numbers = np.zeros((len(structures), len(change)))
        for k, term in enumerate((*placed, *others)):
            for i, more in change[term].items():
                numbers[i, k] = more
        return np.tensordot(numbers, products, 1)

    def _coupled(self, structures: list[TwinStructure], omega: Real, phi: Real) -> tuple[Complex, Complex]:
        """(structures, MODES) poles and (structures, MODES, MODES) weights of the undamped shapes in their shapes."""
        more = self._damped(structures, omega, phi) - self._damping
        on_mixing = more @ self._mixing
        pushed = (omega**2 - self._omega**2)[:, :, None] * self._mixing + on_mixing * self._poles
        coupling = -self._whole.T @ pushed
        own = np.arange(MODES)
        kept = self._mixing * (1 - 0.5 * np.sum(self._mixing * on_mixing, axis=1))[:, None, :]
        return self._poles + coupling[:, own, own], kept + self._whole @ (coupling * self._near)

    def _damped(self, structures: list[TwinStructure], omega: Real, phi: Real) -> Real:
        """(structures, MODES, MODES) damping over modes."""
        damping = np.zeros((len(structures), MODES, MODES))
        own = np.arange(MODES)
        damping[:, own, own] = 2 * np.array([s.zeta for s in structures]) * omega
        places = sorted({x for s in structures for x, _ in s.dampers})
        if places:
            at = {x: k for k, x in enumerate(places)}
            values = np.zeros((len(structures), len(places), 1))
            for i, s in enumerate(structures):
                for x, c in s.dampers:
                    values[i, at[x], 0] += c
            felt = shape_rows(np.array(places), self._middle.length_m) @ phi[:, :OWN]
            damping += felt.transpose(0, 2, 1) @ (values * felt)
        return damping


def _differences_of_terms(here: Terms, there: Sequence[Terms]) -> dict[Term, dict[int, float]]:
    """What others have more of each term than the one here, by term and by which of them; the alike are left out."""
    change: dict[Term, dict[int, float]] = {}
    for i, own in enumerate(there):
        for term in own.keys() | here.keys():
            more = own.get(term, 0.0) - here.get(term, 0.0)
            if more:
                change.setdefault(term, {})[i] = more
    return change
