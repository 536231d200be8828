"""Stiffness and mass of a structure: a sum of terms, each a number times a matrix that the number leaves as it is.

What two structures differ in is what these numbers differ in, which is cheap to say of many at once.
"""

from collections.abc import Iterable

import numpy as np

from modallab.core.arrays import Real
from modallab.twin.elements import ELEMENTS, beam_matrices, shape_rows, slope_rows, weakened_stiffness
from modallab.twin.structure import TwinStructure

OWN = 2 * ELEMENTS + 2
"""Degrees of freedom of the beam's elements; those of what hangs on it follow."""
RIGID = 1e-9
"""Root compliance, in beam compliances, that counts as rigid."""
FIELD, SLOPES, DEFLECTIONS, FREEDOM, LOSS = "field", "slopes", "deflections", "freedom", "loss"
"""Kinds of terms: a cosine of the beam's own, squares of all slopes, of all deflections, of one freedom, a loss,"""
DEFLECTION, SLOPE = "deflection", "slope"
"""the square of the deflection or of the slope at a place."""

Term = tuple[str, *tuple[float, ...]]
"""A kind, and the numbers that say which of its kind."""
Terms = dict[Term, float]


def stiffness_terms(s: TwinStructure) -> Terms:
    """How much of each stiffness a structure has; what hangs on it is left out."""
    ei, length = s.bending_stiffness, s.length_m
    found: Terms = {(FIELD, 0): ei}
    found |= {(FIELD, j): ei * a for j, a in enumerate(s.ei_field.tolist(), 1) if a}
    if s.root_translation > RIGID:
        found[FREEDOM, 0] = ei / length**3 / s.root_translation
    if s.root_rotation > RIGID:
        found[FREEDOM, 1] = ei / length / s.root_rotation
    for x, share, width in s.losses:
        _add_term(found, (LOSS, x, share, width), ei)
    for x, k in s.springs:
        _add_term(found, (DEFLECTION, x), k)
    for x, k in s.rotation_springs:
        _add_term(found, (SLOPE, x), k)
    # The work of an axial force goes with the square of the slope, as the rotary inertia of unit rhoI does.
    return found | {(SLOPES,): s.tension_n, (DEFLECTIONS,): s.bedding}


def mass_terms(s: TwinStructure) -> Terms:
    """How much of each inertia a structure has; what hangs on it is left out."""
    rho_a = s.mass_per_length
    found: Terms = {(FIELD, 0): rho_a, (SLOPES,): rho_a * s.thickness_m**2 / 12}
    found |= {(FIELD, j): rho_a * a for j, a in enumerate(s.mass_field.tolist(), 1) if a}
    for x, kg in s.masses:
        _add_term(found, (DEFLECTION, x), kg)
    return found


def _add_term(terms: Terms, term: Term, value: float) -> None:
    terms[term] = terms.get(term, 0.0) + value


def term_rows(terms: Iterable[Term], length_m: float) -> Real:
    """(terms, n) rows of terms that act on a deflection or a slope at a place: each term is row^T row."""
    rows = {DEFLECTION: shape_rows, SLOPE: slope_rows}
    return np.array([rows[kind](x, length_m)[0] for kind, x in terms]).reshape(-1, OWN)


def term_matrix(term: Term, fields: Real, length_m: float) -> Real:
    """(n, n) one of the other terms; `fields` are the beam's own patterns of stiffness or of mass."""
    kind, *numbers = term
    pattern = beam_matrices(length_m)
    if kind == FIELD:
        return fields[int(numbers[0])]
    if kind == LOSS:
        x, share, width = numbers
        return weakened_stiffness(x, width, length_m, share)
    if kind == FREEDOM:
        own = np.zeros((OWN, OWN))
        own[int(numbers[0]), int(numbers[0])] = 1.0
        return own
    return pattern.rotary if kind == SLOPES else pattern.mass[0]


def terms_at_places(terms: Iterable[Term]) -> list[Term]:
    """Those that act on a deflection or a slope at a place."""
    return [t for t in terms if t[0] in (DEFLECTION, SLOPE)]


def _assemble_matrix(terms: Terms, fields: Real, length_m: float) -> Real:
    placed = terms_at_places(terms)
    rows = term_rows(placed, length_m)
    total: Real = rows.T @ (np.array([terms[t] for t in placed])[:, None] * rows)
    for term, value in terms.items():
        if value and term[0] not in (DEFLECTION, SLOPE):
            total += value * term_matrix(term, fields, length_m)
    return total


def stiffness_and_mass(structure: TwinStructure) -> tuple[Real, Real]:
    """Stiffness and mass over all degrees of freedom; those a rigid root takes are still in."""
    pattern, length = beam_matrices(structure.length_m), structure.length_m
    stiffness = _assemble_matrix(stiffness_terms(structure), pattern.stiffness, length)
    mass = _assemble_matrix(mass_terms(structure), pattern.mass, length)
    return (stiffness, mass) if not structure.hung else _with_hung(structure, stiffness, mass)


def _with_hung(structure: TwinStructure, stiffness: Real, mass: Real) -> tuple[Real, Real]:
    """The same with a freedom more for each mass that hangs on a spring."""
    size = OWN + len(structure.hung)
    whole, heavy = np.zeros((size, size)), np.zeros((size, size))
    whole[:OWN, :OWN], heavy[:OWN, :OWN] = stiffness, mass
    for at, (x, kg, spring) in enumerate(structure.hung, OWN):
        stretch = np.zeros(size)
        stretch[:OWN], stretch[at] = shape_rows(x, structure.length_m)[0], -1.0
        whole += spring * np.outer(stretch, stretch)
        heavy[at, at] = kg
    return whole, heavy
