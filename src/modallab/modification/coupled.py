"""Another structure held to one at pairs of points, or taken away from a measurement of both."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.core.errors import DataError
from modallab.modification.attachments import AttachmentMatrices
from modallab.modification.structure import At, Structure


@dataclass(frozen=True, slots=True, eq=False)
class CouplingToStructure:
    """Another structure, held at pairs of points, rigidly or by a joint.

    Attributes:
        other: the structure.
        pairs: (point of this one, point of the other).
        joint_spring: N/m of the joint at each pair; None for rigid ones.
        sign: -1 where the other is taken away from a measurement of both.
        samples: (samples, ...) of the other structure, for the uncertainty; None where it is taken as exact.
    """

    other: Structure
    pairs: Sequence[tuple[At, At]]
    joint_spring: float | None = None
    sign: int = 1
    samples: Structure | None = None
    own: Real = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Look up the points of the other structure.

        Raises:
            DataError: no pair, or a point that the other structure does not have.
        """
        if not self.pairs:
            raise DataError("no pair of points is given", remedy="give pairs=[(point of one, point of the other)]")
        object.__setattr__(self, "own", self.other.unit_vectors([of for _, of in self.pairs]))

    def links(self, structure: Structure) -> Real:
        """As of `AttachedPart`."""
        return structure.unit_vectors([at for at, _ in self.pairs])

    def compliance(self, s: Complex) -> Complex:
        """Of the other structure at its points, with the joints'."""
        joint = 0.0 if self.joint_spring is None else np.eye(len(self.pairs)) / self.joint_spring
        return self.sign * self.other.receptance(s, self.own, self.own) + joint

    def with_samples(self, count: int) -> "CouplingToStructure":
        """The same with samples of the other structure."""
        return self if self.samples is None else replace(self, other=self.samples.first_samples(count))

    @property
    def measured_part(self) -> bool:
        """Whether it is taken away at one rigid joint, and known as uncertain as it was measured."""
        return self.sign < 0 and len(self.pairs) == 1 and self.joint_spring is None and self.samples is not None

    @property
    def poles(self) -> Complex:
        """Those of the other structure."""
        return self.other.poles

    @property
    def matrices(self) -> AttachmentMatrices:
        """Modes of the other structure, with their motions held to this one's."""
        pairs, modes = len(self.pairs), len(self.other.poles)
        phi = np.real(self.other.psi * np.sqrt(2j * self.other.poles.imag)[:, None]) @ self.own
        omega = np.abs(self.other.poles)
        own = [np.ones(modes), -2 * self.other.poles.real, omega**2]
        mass, damping, stiffness = (np.diag(np.concatenate([np.zeros(pairs), self.sign * v])) for v in own)
        apart = np.concatenate([np.eye(pairs), -phi.T], axis=1)
        if self.joint_spring is None:
            return AttachmentMatrices(mass, damping, stiffness, apart)
        return AttachmentMatrices(mass, damping, stiffness + self.joint_spring * apart.T @ apart, apart[:0])

    @property
    def description(self) -> str:
        """As of `AttachedPart`."""
        how = "taken away" if self.sign < 0 else "coupled"
        return f"structure {how} at " + ", ".join(f"{a}={b}" for a, b in self.pairs)


LINES = 200
"""Across the band: enough for a median beside resonances."""


def conditioning_of(structure: Structure, part: CouplingToStructure) -> float:
    """By which factor relative errors of receptances at a joint grow in its forces, the median over the band.

    Forces solve F g = u with F = H + Y, of both structures. They are off by the spectral radius of |F^-1| (|H| + |Y|),
    in the scaling of pairs in which that is least (Bauer, Numerische Mathematik 5 (1963), 73). Where one structure
    nearly alone says how the joint moves, and is taken away, H and Y cancel.

    Args:
        structure: without the part, or with it where it is taken away.
        part: what is held to it or taken away.

    Returns:
        From 1 on.
    """
    b = part.links(structure)
    s = 2j * np.pi * np.linspace(*structure.band_hz, LINES + 1)[1:]
    own, other = structure.receptance(s, b, b), part.compliance(s)
    return float(np.median([_error_growth(h, y) for h, y in zip(own, other, strict=True)]))


def _error_growth(own: Complex, other: Complex) -> float:
    if np.linalg.matrix_rank(own + other) < len(own):
        return np.inf
    return float(np.max(np.abs(np.linalg.eigvals(np.abs(np.linalg.inv(own + other)) @ (np.abs(own) + np.abs(other))))))
