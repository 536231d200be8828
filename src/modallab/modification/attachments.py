"""What can be hung on a structure: masses, springs, dampers, absorbers, rigid links.

Each is known by its compliance Y(s) at the places where it holds the structure, 0 where it is rigid; and, to begin a
search of poles, by mass, damping and stiffness matrices with constraints.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Complex, Real
from modallab.core.errors import DataError
from modallab.modification.structure import At, Structure


class AttachmentMatrices(NamedTuple):
    """Of motions (links + own) along the links and of what the attachment has besides.

    Attributes:
        mass: (motions, motions).
        damping: (motions, motions).
        stiffness: (motions, motions).
        constraint: (constraints, motions), zero times the motions.
    """

    mass: NDArray[np.floating[Any]]
    damping: NDArray[np.floating[Any]]
    stiffness: NDArray[np.floating[Any]]
    constraint: NDArray[np.floating[Any]]


class AttachedPart(Protocol):
    """What is hung on a structure."""

    def links(self, structure: Structure) -> Real:
        """(freedoms, links) along what it holds the structure."""
        ...

    def compliance(self, s: Complex) -> Complex:
        """(..., links, links) m/N at complex frequencies."""
        ...

    @property
    def poles(self) -> Complex:
        """Its own poles of the compliance, rad/s, those with a positive imaginary part."""
        ...

    @property
    def matrices(self) -> AttachmentMatrices:
        """To begin a search of poles."""
        ...

    @property
    def description(self) -> str:
        """What it is, in a few words."""
        ...


NO_POLES: Complex = np.zeros(0, np.complex128)
NO_CONSTRAINT: Real = np.zeros((0, 1))


def _motion_between(structure: Structure, at: At, to: At | None) -> Real:
    """(freedoms, 1) motion at a place, over that at another one if there is one."""
    one = structure.unit_vectors([at])
    return one if to is None else one - structure.unit_vectors([to])


def _finite_number(value: float, name: str, unit: str) -> None:
    if not isfinite(value) or value == 0:
        raise DataError(f"{name}={value!r} {unit} is no change", remedy=f"give a number other than 0 in {unit}")


@dataclass(frozen=True, slots=True)
class Element:
    """A mass, spring or damper, or all three side by side, at a point to ground, or between two points.

    Attributes:
        at: where.
        to: the other end of spring and damper; None for ground.
        mass: kg; below 0 for one that is taken away.
        spring: N/m.
        damper: N s/m.
    """

    at: At
    to: At | None = None
    mass: float = 0.0
    spring: float = 0.0
    damper: float = 0.0

    def __post_init__(self) -> None:
        """Reject what changes nothing.

        Raises:
            DataError: says which number.
        """
        given = {"mass": (self.mass, "kg"), "spring": (self.spring, "N/m"), "damper": (self.damper, "N s/m")}
        for name, (value, unit) in given.items():
            if not isfinite(value) or (value == 0 and not any(v for v, _ in given.values())):
                _finite_number(value, name, unit)
        if self.mass and self.to is not None:
            raise DataError("a mass hangs at one point", remedy="leave the second point out")

    def links(self, structure: Structure) -> Real:
        """As of `AttachedPart`."""
        return _motion_between(structure, self.at, self.to)

    def compliance(self, s: Complex) -> Complex:
        """As of `AttachedPart`."""
        return (1 / (self.mass * s**2 + self.damper * s + self.spring))[..., None, None]

    @property
    def poles(self) -> Complex:
        """Where mass and spring alone resonate against ground."""
        roots = np.roots([self.mass, self.damper, self.spring]) if self.mass and self.spring else NO_POLES
        return np.asarray(roots[np.imag(roots) > 0], np.complex128)

    @property
    def matrices(self) -> AttachmentMatrices:
        """As of `AttachedPart`."""
        mass, damping, stiffness = (np.array([[v]]) for v in (self.mass, self.damper, self.spring))
        return AttachmentMatrices(mass, damping, stiffness, NO_CONSTRAINT)

    @property
    def description(self) -> str:
        """As of `AttachedPart`."""
        parts = [
            f"{word} {value:.4g} {unit}"
            for word, value, unit in (
                ("mass", self.mass, "kg"),
                ("spring", self.spring, "N/m"),
                ("damper", self.damper, "N s/m"),
            )
            if value
        ]
        return f"{', '.join(parts)} at {self.at}" + (f" to {self.to}" if self.to is not None else "")


@dataclass(frozen=True, slots=True)
class TunedAbsorber:
    """A mass on a spring and a damper (Den Hartog, Mechanical Vibrations, 4th ed. 1956, section 3.3).

    Attributes:
        at: where.
        mass: kg.
        frequency_hz: natural frequency of the absorber alone.
        damping_ratio: of the absorber alone.
    """

    at: At
    mass: float
    frequency_hz: float
    damping_ratio: float = 0.0

    def __post_init__(self) -> None:
        """Reject numbers that are none.

        Raises:
            DataError: says which.
        """
        for name, value, unit in (("mass", self.mass, "kg"), ("frequency_hz", self.frequency_hz, "Hz")):
            if not (isfinite(value) and value > 0):
                raise DataError(f"{name}={value!r} of an absorber", remedy=f"give a number above 0 in {unit}")
        if not (isfinite(self.damping_ratio) and self.damping_ratio >= 0):
            raise DataError(f"damping_ratio={self.damping_ratio!r}", remedy="give a number from 0 on, 0.1 for 10 %")

    @property
    def spring(self) -> float:
        """N/m."""
        return self.mass * (2 * np.pi * self.frequency_hz) ** 2

    @property
    def damper(self) -> float:
        """N s/m."""
        return 2 * self.damping_ratio * self.mass * 2 * np.pi * self.frequency_hz

    def links(self, structure: Structure) -> Real:
        """As of `AttachedPart`."""
        return structure.unit_vectors([self.at])

    def compliance(self, s: Complex) -> Complex:
        """A mass in series with spring and damper."""
        return (1 / (self.mass * s**2) + 1 / (self.damper * s + self.spring))[..., None, None]

    @property
    def poles(self) -> Complex:
        """None: a free mass on a spring moves as one at no frequency above 0."""
        return NO_POLES

    @property
    def matrices(self) -> AttachmentMatrices:
        """As of `AttachedPart`."""
        both = np.array([[1.0, -1.0], [-1.0, 1.0]])
        return AttachmentMatrices(np.diag([0.0, self.mass]), self.damper * both, self.spring * both, np.zeros((0, 2)))

    @property
    def description(self) -> str:
        """As of `AttachedPart`."""
        own = f"absorber {self.mass:.4g} kg, {self.frequency_hz:.5g} Hz, {100 * self.damping_ratio:.3g} %"
        return f"{own} at {self.at}"


@dataclass(frozen=True, slots=True)
class RigidLink:
    """Two points that move as one, or a point that no longer moves.

    Attributes:
        at: where.
        to: the other point; None for ground.
    """

    at: At
    to: At | None = None

    def links(self, structure: Structure) -> Real:
        """As of `AttachedPart`."""
        return _motion_between(structure, self.at, self.to)

    def compliance(self, s: Complex) -> Complex:
        """None."""
        return np.zeros((*s.shape, 1, 1), np.complex128)

    @property
    def poles(self) -> Complex:
        """None."""
        return NO_POLES

    @property
    def matrices(self) -> AttachmentMatrices:
        """As of `AttachedPart`."""
        none = np.zeros((1, 1))
        return AttachmentMatrices(none, none, none, np.ones((1, 1)))

    @property
    def description(self) -> str:
        """As of `AttachedPart`."""
        return f"ground at {self.at}" if self.to is None else f"rigid link {self.at} to {self.to}"


def merge_attachments(attachments: Sequence[AttachedPart]) -> tuple[AttachedPart, ...]:
    """The same with masses, springs and dampers of the same ends added up; what adds up to nothing is left out."""
    sums: dict[tuple[At, At | None], tuple[float, float, float]] = {}
    for a in attachments:
        if isinstance(a, Element):
            before = sums.get((a.at, a.to), (0.0, 0.0, 0.0))
            sums[a.at, a.to] = before[0] + a.mass, before[1] + a.spring, before[2] + a.damper
    elements = [Element(at, to, *values) for (at, to), values in sums.items() if any(values)]
    return (*elements, *(a for a in attachments if not isinstance(a, Element)))


def require_enough_left(structure: Structure, attachments: Sequence[AttachedPart]) -> None:
    """Reject masses and springs that cannot have been part of the structure.

    Whatever is taken away of a passive structure, its mass and stiffness stay positive definite, in its modes too.

    Raises:
        DataError: more is taken away than there is.
    """
    elements = [a for a in attachments if isinstance(a, Element)]
    # What else hangs there brings mass and stiffness of its own.
    if not elements or len(elements) < len(attachments):
        return
    phi = np.real(structure.psi * np.sqrt(2j * structure.poles.imag)[:, None])
    at = np.concatenate([phi @ a.links(structure) for a in elements], axis=1)
    for name, felt in (("mass", at), ("spring", at / np.abs(structure.poles)[:, None])):
        sizes = np.array([getattr(a, name) for a in elements])
        if np.linalg.eigvalsh(np.eye(len(felt)) + (felt * sizes) @ felt.T)[0] <= 0:
            places = ", ".join(str(a.at) for a, size in zip(elements, sizes, strict=True) if size < 0)
            raise DataError(
                f"{sizes[sizes < 0].sum():.4g} at {places} is more than the structure has there",
                where=name,
                remedy="take away what was on it when it was measured, and no more",
            )
