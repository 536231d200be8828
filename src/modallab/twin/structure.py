"""The cantilever's numbers, and the modes that follow from them."""

import re
from collections import OrderedDict
from dataclasses import dataclass, field, replace
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from modallab.core.rig import Beam
from modallab.twin.elements import ELEMENTS, FIELD_TERMS, patterns, shape_rows, slope_rows, weakened
from modallab.twin.side_modes import SideModes, given_way, poles_and_columns

MODES = 15
"""Modes kept: well past the band."""
ROOT = 0.1
"""Relative deviation of a rotational spring at the root that a rig file states as "about" so much."""
OWN = 2 * ELEMENTS + 2
"""Degrees of freedom of the beam's elements; those of what hangs on it follow."""
RIGID = 1e-9
"""Root compliance, in beam compliances, that counts as rigid."""

Array = NDArray[np.float64]
Complex = NDArray[np.complexfloating[Any, Any]]
Attached = tuple[tuple[float, float], ...]


@dataclass(frozen=True, eq=False, slots=True)
class Structure:
    """A cantilever with what may be wrong with it. Places are in m from the clamp.

    Attributes:
        length_m: length.
        width_m: width.
        thickness_m: thickness h; EI = E b h^3 / 12, rhoA = rho b h, rhoI = rhoA h^2 / 12.
        youngs_modulus_pa: E.
        density_kg_m3: rho.
        zeta: (MODES,) damping ratio of each mode.
        ei_field: (terms,) share of EI in cos(j pi x / L), j = 1, 2, ...
        mass_field: (terms,) the same for rhoA.
        root_rotation: compliance of the root in L / EI; 0 is rigid.
        root_translation: the same across the beam, in L^3 / EI.
        masses: (x, kg).
        springs: (x, N/m) to ground.
        rotation_springs: (x, N m/rad) to ground.
        dampers: (x, N s/m) to ground.
        losses: (x, share of EI lost there, half width in m).
        hung: (x, kg, N/m) of masses that hang on a spring, each with a freedom of its own.
        tension_n: axial force, N; negative where it pushes.
        bedding: stiffness per length to ground, N/m^2.
        side: families of modes beside those of bending along the drive.
    """

    length_m: float
    width_m: float
    thickness_m: float
    youngs_modulus_pa: float
    density_kg_m3: float
    zeta: Array
    ei_field: Array = field(default_factory=lambda: np.zeros(FIELD_TERMS))
    mass_field: Array = field(default_factory=lambda: np.zeros(FIELD_TERMS))
    root_rotation: float = 0.0
    root_translation: float = 0.0
    masses: Attached = ()
    springs: Attached = ()
    rotation_springs: Attached = ()
    dampers: Attached = ()
    losses: tuple[tuple[float, float, float], ...] = ()
    hung: tuple[tuple[float, float, float], ...] = ()
    tension_n: float = 0.0
    bedding: float = 0.0
    side: tuple[SideModes, ...] = ()

    @classmethod
    def of(cls, beam: Beam, damping_ratio: float) -> "Structure":
        """The structure a rig file believes in."""
        return cls(
            beam.length_m,
            beam.width_m,
            beam.thickness_m,
            beam.youngs_modulus_pa,
            beam.density_kg_m3,
            np.full(MODES, damping_ratio),
            root_rotation=believed_root(beam),
        )

    @property
    def bending_stiffness(self) -> float:
        """EI in N m^2."""
        return self.youngs_modulus_pa * self.width_m * self.thickness_m**3 / 12

    @property
    def mass_per_length(self) -> float:
        """RhoA in kg/m."""
        return self.density_kg_m3 * self.width_m * self.thickness_m


@dataclass(frozen=True, eq=False, slots=True)
class Modes:
    """Poles and shapes: displacement at a by force at b is sum_p psi_ap psi_bp / (s - pole_p) and its conjugate.

    Attributes:
        poles: (p,) rad/s, imaginary part >= 0.
        columns: (n, p) complex shapes over the elements' degrees of freedom, scaled so that the formula holds.
        length_m: length of the beam.
        beyond: (n, n) static compliance in m/N that all other modes add, over the same degrees of freedom.
    """

    poles: Complex
    columns: Complex
    length_m: float
    out_of_band: Array

    def at(self, x_m: float | Array) -> Complex:
        """(points, p) shapes at places on the beam."""
        return shape_rows(x_m, self.length_m) @ self.columns

    def remainder(self, x_m: Array, drive_x_m: float) -> Array:
        """(points,) static displacement in m per N at `drive_x_m` that the modes left out add."""
        return shape_rows(x_m, self.length_m) @ (self.out_of_band @ shape_rows(drive_x_m, self.length_m)[0])

    @property
    def frequency_hz(self) -> Array:
        """(p,) undamped natural frequencies."""
        return np.abs(self.poles) / (2 * np.pi)


_SPRING = re.compile(r"(\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)\s*EI/L(?!\^)")


def believed_root(beam: Beam) -> float:
    """Rotational compliance of the root in L / EI by the words of the rig file: "... 13 EI/L ..."; else 0."""
    said = _SPRING.search(beam.clamp)
    return 1 / float(said.group(1)) if said is not None and float(said.group(1)) > 0 else 0.0


def solve(structure: Structure) -> Modes:
    """The modes of a structure; a damper couples them, otherwise each keeps its own damping ratio."""
    return _beside(structure, _damped(structure, *_undamped(structure)))


def _beside(structure: Structure, bending: Modes) -> Modes:
    """The modes of bending, and after them those of the families beside."""
    if not structure.side:
        return bending
    families = [poles_and_columns(one, structure.length_m) for one in structure.side]
    more = sum((given_way(one, structure.length_m) for one in structure.side), np.zeros_like(bending.out_of_band))
    return replace(
        bending,
        poles=np.concatenate([bending.poles, *(own for own, _ in families)]),
        columns=np.hstack([bending.columns, *(own for _, own in families)]),
        out_of_band=bending.out_of_band + more,
    )


def alike(structure: Structure, other: Structure) -> bool:
    """Whether two structures have the same modes."""
    if (structure.dampers, structure.side) != (other.dampers, other.side):
        return False
    if not np.array_equal(structure.zeta, other.zeta):
        return False
    return undamped_key(structure) == undamped_key(other)


def _damped(structure: Structure, omega: Array, phi: Array, out_of_band: Array) -> Modes:
    if structure.dampers:
        poles, mixing = _coupled(structure, omega, phi)
        return Modes(poles, phi[:OWN] @ mixing, structure.length_m, out_of_band[:OWN, :OWN])
    zeta = structure.zeta
    damped = omega * np.sqrt(np.maximum(1 - zeta**2, 1e-6))
    columns = (phi[:OWN] / np.sqrt(2j * damped)).astype(np.complex128)
    return Modes(-zeta * omega + 1j * damped, columns, structure.length_m, out_of_band[:OWN, :OWN])


_LATEST: OrderedDict[tuple[object, ...], tuple[Array, Array, Array]] = OrderedDict()
_KEPT = 48
_LOCK = Lock()


def _undamped(structure: Structure) -> tuple[Array, Array, Array]:
    """(MODES,) rad/s, (n, MODES) shapes and (n, n) compliance beyond them, n with what hangs on the beam.

    Remembered, as damping, chain and clock leave them as they are.
    """
    key = undamped_key(structure)
    with _LOCK:
        if key in _LATEST:
            _LATEST.move_to_end(key)
            return _LATEST[key]
    stiffness, mass = matrices(structure)
    free = _free(structure)
    held = np.ix_(free, free)
    # The low modes are the large eigenvalues of this pencil, exact to the last digits; of the other they are the small.
    values, vectors = eigh(mass[held], stiffness[held], check_finite=False, overwrite_a=True, overwrite_b=True)
    omega, phi = 1 / np.sqrt(values[: -MODES - 1 : -1]), np.zeros((len(stiffness), MODES))
    phi[free] = vectors[:, : -MODES - 1 : -1] * omega
    # The vectors have unit strain energy: summed over all of them their squares are the compliance.
    others, out_of_band = vectors[:, :-MODES], np.zeros(stiffness.shape)
    out_of_band[held] = others @ others.T
    with _LOCK:
        _LATEST[key] = omega, phi, out_of_band
        while len(_LATEST) > _KEPT:
            _LATEST.popitem(last=False)
    return omega, phi, out_of_band


def undamped_key(s: Structure) -> tuple[object, ...]:
    """What the undamped modes depend on; to remember them by."""
    size = s.length_m, s.width_m, s.thickness_m, s.youngs_modulus_pa, s.density_kg_m3
    fields = s.ei_field.tobytes(), s.mass_field.tobytes()
    attached = s.masses, s.springs, s.rotation_springs, s.losses, s.hung, s.tension_n, s.bedding
    return (*size, *fields, s.root_rotation, s.root_translation, *attached)


def matrices(structure: Structure) -> tuple[Array, Array]:
    """Stiffness and mass over all degrees of freedom; those a rigid root takes are still in."""
    pattern, length = patterns(structure.length_m), structure.length_m
    ei, rho_a = structure.bending_stiffness, structure.mass_per_length
    stiffness = ei * _with_field(pattern.stiffness, structure.ei_field)
    mass = rho_a * (_with_field(pattern.mass, structure.mass_field) + structure.thickness_m**2 / 12 * pattern.rotary)
    if structure.root_translation > RIGID:
        stiffness[0, 0] += ei / length**3 / structure.root_translation
    if structure.root_rotation > RIGID:
        stiffness[1, 1] += ei / length / structure.root_rotation
    for x, share, width in structure.losses:
        stiffness += ei * weakened(x, width, length, share)
    for attached, rows, total in (
        (structure.springs, shape_rows, stiffness),
        (structure.rotation_springs, slope_rows, stiffness),
        (structure.masses, shape_rows, mass),
    ):
        if attached:
            places, values = np.array(attached).T
            own = rows(np.ascontiguousarray(places), length)
            total += own.T @ (values[:, None] * own)
    if structure.tension_n:
        # The work of an axial force goes with the square of the slope, as the rotary inertia of unit rhoI does.
        stiffness += structure.tension_n * pattern.rotary
    if structure.bedding:
        stiffness += structure.bedding * pattern.mass[0]
    return (stiffness, mass) if not structure.hung else _with_hung(structure, stiffness, mass)


def _with_hung(structure: Structure, stiffness: Array, mass: Array) -> tuple[Array, Array]:
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


def _with_field(patterns_of: Array, field_of: Array) -> Array:
    if not np.any(field_of):
        return patterns_of[0]
    return patterns_of[0] + np.tensordot(field_of, patterns_of[1:], 1)


def _free(structure: Structure) -> NDArray[np.int64]:
    held = {i for i, c in enumerate((structure.root_translation, structure.root_rotation)) if c <= RIGID}
    return np.array([i for i in range(OWN + len(structure.hung)) if i not in held])


def _damping(structure: Structure, omega: Array, phi: Array) -> Array:
    """(n, n) damping matrix over modes."""
    damping = np.diag(2 * structure.zeta * omega)
    if structure.dampers:
        places, values = np.array(structure.dampers).T
        own = shape_rows(np.ascontiguousarray(places), structure.length_m) @ phi[:OWN]
        damping += own.T @ (values[:, None] * own)
    return damping


def _coupled(structure: Structure, omega: Array, phi: Array) -> tuple[Complex, Complex]:
    n = len(omega)
    damping = _damping(structure, omega, phi)
    state = np.zeros((2 * n, 2 * n))
    state[:n, n:], state[n:, :n], state[n:, n:] = np.eye(n), -np.diag(omega**2), -damping
    poles, vectors = (v.astype(np.complex128) for v in np.linalg.eig(state))
    # Of a conjugate pair one half is kept; a real pole counts half, as the conjugate doubles it.
    keep = poles.imag >= 0
    poles, shapes = poles[keep], vectors[:n, keep]
    norm = np.sum(shapes * (damping @ shapes), axis=0) + 2 * poles * np.sum(shapes**2, axis=0)
    weight = np.where(poles.imag == 0, 0.5, 1.0)
    order = np.argsort(np.abs(poles))
    scaled = shapes * np.sqrt(weight / norm)
    return poles[order].astype(np.complex128), scaled[:, order].astype(np.complex128)


class Neighbours:
    """The modes of structures next to one, to first order in what differs.

    Without dampers Fox and Kapoor, AIAA J. 6 (1968), 2426, eqs. 4 and 16, the modes beyond those kept by their static
    compliance; what damping then couples by the same expansion over the complex modes (Adhikari, AIAA J. 37, 1999,
    1452).
    """

    def __init__(self, structure: Structure) -> None:
        """Solve the structure in the middle."""
        self._middle, self._key = structure, undamped_key(structure)
        self._free = _free(structure)
        self._stiffness, self._mass = matrices(structure)
        self._omega, self._phi, self._out_of_band = _undamped(structure)
        if structure.dampers:
            self._poles, self._mixing = _coupled(structure, self._omega, self._phi)
        else:
            damped = self._omega * np.sqrt(np.maximum(1 - structure.zeta**2, 1e-6))
            self._poles = -structure.zeta * self._omega + 1j * damped
            self._mixing = np.diag(1 / np.sqrt(2j * damped)).astype(np.complex128)
        self._damping = _damping(structure, self._omega, self._phi)
        whole = np.concatenate([self._poles, self._poles.conj()])
        apart = self._poles - whole[:, None]
        self._near = np.where(apart == 0, 0.0, 1 / np.where(apart == 0, 1.0, apart))
        self._whole = np.concatenate([self._mixing, self._mixing.conj()], axis=1)

    def solve(self, structure: Structure) -> Modes:
        """The modes of a structure next to the one in the middle."""
        if len(self._poles) != MODES or np.any(self._poles.imag == 0):
            return solve(structure)
        if undamped_key(structure) == self._key:
            omega, phi = self._omega, self._phi
        elif np.array_equal(_free(structure), self._free):
            omega, phi = self._undamped(structure)
        else:
            return solve(structure)
        poles, mixing = self._coupled(structure, omega, phi)
        bending = Modes(poles, phi[:OWN] @ mixing, structure.length_m, self._out_of_band[:OWN, :OWN])
        return _beside(structure, bending)

    def _undamped(self, structure: Structure) -> tuple[Array, Array]:
        phi, squared = self._phi, self._omega**2
        stiffness, mass = matrices(structure)
        heavier = (mass - self._mass) @ phi
        # Columns: what the change does on each mode.
        pushed = (stiffness - self._stiffness) @ phi - heavier * squared
        coupling = phi.T @ pushed
        apart = squared - squared[:, None]
        mixing = coupling / np.where(apart == 0, np.inf, apart) - 0.5 * np.diag(np.sum(phi * heavier, axis=0))
        moved = phi + phi @ mixing - self._out_of_band @ pushed
        return np.sqrt(np.maximum(squared + np.diag(coupling), 1e-12)), moved

    def _coupled(self, structure: Structure, omega: Array, phi: Array) -> tuple[Complex, Complex]:
        more = _damping(structure, omega, phi) - self._damping
        pushed = (omega**2 - self._omega**2)[:, None] * self._mixing + (more @ self._mixing) * self._poles
        coupling = -self._whole.T @ pushed
        own = np.diag(coupling)
        weights = coupling * self._near
        kept = self._mixing * (1 - 0.5 * np.sum(self._mixing * (more @ self._mixing), axis=0))
        return self._poles + own, kept + self._whole @ weights
