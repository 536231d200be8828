"""Poles of a structure with attachments.

They are the roots of det D(s) det(Y(s) + B^T H(s) B), with D of the structure's own modes. Starting values are those of
the modes with what lies outside the band as a spring at each link (MacNeal, Computers & Structures 1 (1971), 581): a
heavy mass on it is a mode more. Where it is no spring, it is added in steps. All roots are found at once by Aberth's
iteration (Math. Comp. 27 (1973), 339), in which each root keeps away from the others.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import linalg

from modallab.core.arrays import Complex, Real
from modallab.core.errors import DataError
from modallab.modification.attachments import AttachedPart, RigidLink, merge_attachments, require_enough_left
from modallab.modification.coupled import CouplingToStructure
from modallab.modification.structure import Receptances, Structure

STEPS = (0.25, 0.5, 0.75, 1.0)
"""Shares of what lies outside the band."""
ITERATIONS = 40
SETTLED = 1e-11
"""Of a root: what the last step may be."""
LONGEST_STEP = 0.1
"""Of a root."""
DIFFERENCE = 1e-6
"""Of a frequency: over it slopes are taken."""
NO_SPRING = 1e-6
"""Of what the modes give way: a smaller compliance moves no root within the band, and rounding would be all of it."""


@dataclass(frozen=True, eq=False, slots=True)
class StructureWithAttachments(Receptances):
    """A structure with attachments.

    Attributes:
        structure: before.
        attachments: what is hung on it.
        b: (freedoms, links) along which they hold it.
    """

    structure: Structure
    attachments: tuple[AttachedPart, ...]
    b: Real

    @classmethod
    def of(cls, structure: Structure, attachments: Sequence[AttachedPart]) -> "StructureWithAttachments":
        """With the links looked up.

        Raises:
            DataError: the model does not know a point, rigid links hold one motion twice, or more is taken away than
                there is.
        """
        kept = merge_attachments(attachments)
        require_enough_left(structure, kept)
        _require_single([a.links(structure) for a in kept if isinstance(a, RigidLink)])
        b = [a.links(structure) for a in kept] or [np.zeros((len(structure.freedoms), 0))]
        return cls(structure, kept, np.concatenate(b, axis=1))

    def compliance(self, s: Complex) -> Complex:
        """(..., links, links) of all attachments."""
        parts = [a.compliance(s) for a in self.attachments]
        leading = np.broadcast_shapes(s.shape, *(part.shape[:-2] for part in parts))
        whole = np.zeros((*leading, self.b.shape[1], self.b.shape[1]), np.complex128)
        at = 0
        for part in parts:
            size = part.shape[-1]
            whole[..., at : at + size, at : at + size] = part
            at += size
        return whole

    def flexibility(self, s: Complex) -> Complex:
        """(..., lines, links, links) of structure and attachments together along the links, m/N."""
        return self.compliance(s) + self.structure.receptance(s, self.b, self.b)

    def receptance(self, s: Complex, left: Real | None = None, right: Real | None = None) -> Complex:
        """(..., lines, left, right) with the attachments, m/N.

        H - H B (Y + B^T H B)^-1 B^T H: coupling by Lagrange multipliers (de Klerk, Rixen, Voormeeren, AIAA Journal 46
        (2008), 1169).
        """
        to, of = self.structure.receptance(s, left, self.b), self.structure.receptance(s, self.b, right)
        return self.structure.receptance(s, left, right) - to @ np.linalg.solve(self.flexibility(s), of)

    def with_structure(self, structure: Structure) -> "StructureWithAttachments":
        """The same attachments on another structure."""
        return replace(self, structure=structure)

    def with_samples(self, samples: Structure) -> "StructureWithAttachments":
        """Samples (samples, ...) of the structure, and of those that are coupled to it."""
        count = len(samples.poles)
        varied = tuple(a.with_samples(count) if isinstance(a, CouplingToStructure) else a for a in self.attachments)
        return replace(self, structure=samples, attachments=varied)


def _require_single(rigid: Sequence[Real]) -> None:
    if rigid and np.linalg.matrix_rank(np.concatenate(rigid, axis=1)) < len(rigid):
        raise DataError(
            f"{len(rigid)} rigid links hold one motion twice",
            remedy="leave out a link that others make already, or that joins a point to itself",
        )


def poles_of(attached: StructureWithAttachments) -> Complex:
    """(poles,) rad/s with a positive imaginary part, by rising frequency."""
    if not attached.attachments:
        return attached.structure.poles[np.argsort(attached.structure.poles.imag)]
    whole, springs = attached.structure, _out_of_band_springs(attached)
    found = _poles_of_modes(attached, springs)
    for share in STEPS if whole.powers and springs is None else (1.0,):
        part = attached.with_structure(replace(whole, residual=share * whole.residual))
        found = refine_poles(part, found)
    return found[np.argsort(found.imag)]


def _out_of_band_springs(attached: StructureWithAttachments) -> Real | None:
    """(links, links) N/m of what lies outside the band, at the middle of the band; None where it is no spring."""
    whole = attached.structure
    s = 1j * np.pi * whole.band_hz[1]
    terms = np.real(s ** np.array(whole.powers, np.float64))
    soft = attached.b.T @ np.tensordot(terms, whole.residual, 1) @ attached.b
    modes = 2 * np.sum(np.abs(whole.psi @ attached.b) ** 2 / np.abs(whole.poles)[:, None], axis=0)
    given = np.linalg.eigvalsh(soft)[0] > NO_SPRING * np.max(modes)
    return np.asarray(np.linalg.inv(soft), np.float64) if given else None


def _poles_of_modes(attached: StructureWithAttachments, springs: Real | None) -> Complex:
    """Poles of the modes with their attachments, a quadratic eigenproblem with constraints."""
    size = _sizes_of_problem(attached, springs)
    held, own = _constrained_motions(attached, springs, size), _matrices_of_structure(attached, springs, size)
    constraints, link, at = [np.zeros((0, size))], 0, size - _own_motions(attached)
    for attachment in attached.attachments:
        matrices = attachment.matrices
        links = attachment.links(attached.structure).shape[1]
        more = len(matrices.mass) - links
        motions = np.concatenate([held[link : link + links], np.eye(more, size, at)])
        for whole, part in zip(own, matrices[:3], strict=True):
            whole += motions.T @ part @ motions
        constraints.append(np.asarray(matrices.constraint @ motions, np.float64))
        link, at = link + links, at + more
    free = _null_space(np.concatenate(constraints))
    return _quadratic_roots(*(free.T @ whole @ free for whole in own))


def _own_motions(attached: StructureWithAttachments) -> int:
    """Number of what the attachments have besides their links."""
    return sum(len(a.matrices.mass) for a in attached.attachments) - attached.b.shape[1]


def _sizes_of_problem(attached: StructureWithAttachments, springs: Real | None) -> int:
    """Number of modes, of links behind springs, and of what the attachments have besides."""
    return len(attached.structure.poles) + (0 if springs is None else len(springs)) + _own_motions(attached)


def _shapes_at_links(attached: StructureWithAttachments, size: int) -> Real:
    """(links, size) shapes at unit modal mass, without their phases."""
    structure, found = attached.structure, np.zeros((attached.b.shape[1], size))
    real = np.real(structure.psi * np.sqrt(2j * structure.poles.imag)[:, None])
    found[:, : len(structure.poles)] = (real @ attached.b).T
    return found


def _constrained_motions(attached: StructureWithAttachments, springs: Real | None, size: int) -> Real:
    """(links, size) what moves as the attachments do at their links."""
    modes = len(attached.structure.poles)
    return _shapes_at_links(attached, size) if springs is None else np.eye(len(springs), size, modes)


def _matrices_of_structure(attached: StructureWithAttachments, springs: Real | None, size: int) -> list[Real]:
    """Mass, damping and stiffness of the structure's modes and its springs, with room for the attachments."""
    poles = attached.structure.poles
    modal = np.ones(len(poles)), -2 * poles.real, np.abs(poles) ** 2
    room = np.zeros(size - len(poles))
    own = [np.asarray(np.diag(np.concatenate([one, room])), np.float64) for one in modal]
    if springs is not None:
        apart = _shapes_at_links(attached, size) - _constrained_motions(attached, springs, size)
        own[2] += apart.T @ springs @ apart
    return own


def _null_space(constraints: Real) -> Real:
    rows = constraints[np.abs(constraints).max(axis=1, initial=0.0) > 0]
    return np.asarray(linalg.null_space(rows), np.float64) if len(rows) else np.eye(constraints.shape[1])


def _quadratic_roots(mass: Real, damping: Real, stiffness: Real) -> Complex:
    """Roots of mass s^2 + damping s + stiffness with a positive imaginary part."""
    n = len(mass)
    scale = np.sqrt(np.abs(np.trace(stiffness)) / max(np.abs(np.trace(mass)), np.finfo(float).tiny)) or 1.0
    a = np.block([[np.zeros((n, n)), np.eye(n)], [-stiffness, -damping * scale]])
    e = np.block([[np.eye(n), np.zeros((n, n))], [np.zeros((n, n)), mass * scale**2]])
    roots = np.asarray(linalg.eigvals(a, e), np.complex128)
    roots = scale * roots[np.isfinite(roots) & (np.abs(roots) < 1e6)]
    return roots[roots.imag > 1e-6 * np.abs(roots)]


def refine_poles(attached: StructureWithAttachments, starts: Complex) -> Complex:
    """(..., poles) the roots nearest to starts (..., poles); leading axes as of the structure."""
    if not attached.attachments:
        poles = attached.structure.poles
        nearest = np.argmin(np.abs(poles[..., None, :] - starts[..., :, None]), axis=-1)
        return np.take_along_axis(poles, nearest, axis=-1)
    own = _poles_taken_out(attached)
    s = starts + 0j
    for _ in range(ITERATIONS):
        step = _newton_step(s, attached.flexibility, own)
        longest = LONGEST_STEP * np.abs(s)
        s = s - longest / np.maximum(np.abs(step), longest) * step
        if np.all(np.abs(step) < SETTLED * np.abs(s)):
            break
    return s


def _poles_taken_out(attached: StructureWithAttachments) -> Complex:
    """(..., poles) of the structure and of the attachments."""
    poles = attached.structure.poles
    more = [np.broadcast_to(a.poles, (*poles.shape[:-1], a.poles.shape[-1])) for a in attached.attachments]
    both = np.concatenate([poles, *more], axis=-1)
    return np.concatenate([both, both.conj()], axis=-1)


def _newton_step(s: Complex, flexibility: Callable[[Complex], Complex], own: Complex) -> Complex:
    """(..., roots) Newton's step, with the other roots and all conjugates divided out."""
    h = DIFFERENCE * np.abs(s)
    slope = (flexibility(s + h) - flexibility(s - h)) / (2 * h)[..., None, None]
    rate = _log_determinant_slope(flexibility(s), slope)
    rate = rate + np.sum(_inverse_distance(s[..., :, None] - own[..., None, :]), axis=-1)
    apart = s[..., :, None] - s[..., None, :]
    rate = rate - np.sum(np.where(np.eye(s.shape[-1], dtype=bool), 0.0, _inverse_distance(apart)), axis=-1)
    rate = rate - np.sum(_inverse_distance(s[..., :, None] - s.conj()[..., None, :]), axis=-1)
    step = 1 / np.where(rate == 0, np.inf, rate)
    return np.where(np.isfinite(step), step, 0.0)


def _log_determinant_slope(matrix: Complex, slope: Complex) -> Complex:
    """(...,) derivative of the logarithm of the determinants of (..., n, n); 0 where a root has gone astray."""
    sound = (np.isfinite(matrix) & np.isfinite(slope)).all(axis=(-2, -1), keepdims=True)
    kept = np.where(sound, matrix, np.eye(matrix.shape[-1]))
    # At a root the matrix is singular, now and then to the last digit: such a root is found, and stays.
    found = np.isneginf(np.linalg.slogdet(kept).logabsdet)
    solvable = np.where(found[..., None, None], np.eye(matrix.shape[-1]), kept)
    rates = np.trace(np.linalg.solve(solvable, np.where(sound, slope, 0.0)), axis1=-2, axis2=-1)
    return np.where(found, np.inf, rates)


def _inverse_distance(distance: Complex) -> Complex:
    return np.where(distance == 0, 0.0, 1 / np.where(distance == 0, 1.0, distance))
