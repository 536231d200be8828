"""The modes that follow from a structure."""

from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, replace
from threading import Lock
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from modallab.core.arrays import Complex, Real
from modallab.twin.elements import shape_rows
from modallab.twin.matrices import OWN, RIGID, stiffness_and_mass
from modallab.twin.structure import MODES, TwinStructure, out_of_band_compliance, poles_and_columns

T = TypeVar("T")


@dataclass(frozen=True, eq=False, slots=True)
class TwinModes:
    """Poles and shapes: displacement at a by force at b is sum_p psi_ap psi_bp / (s - pole_p) and its conjugate.

    Attributes:
        poles: (p,) rad/s, imaginary part >= 0.
        columns: (n, p) complex shapes over the elements' degrees of freedom, scaled so that the formula holds.
        length_m: length of the beam.
        out_of_band: (n, n) static compliance in m/N that all other modes add, over the same degrees of freedom.
    """

    poles: Complex
    columns: Complex
    length_m: float
    out_of_band: Real

    def shapes_at(self, x_m: float | Real) -> Complex:
        """(points, p) shapes at places on the beam."""
        return shape_rows(x_m, self.length_m) @ self.columns

    def remainder(self, x_m: Real, drive_x_m: float) -> Real:
        """(points,) static displacement in m per N at `drive_x_m` that the modes left out add."""
        return shape_rows(x_m, self.length_m) @ (self.out_of_band @ shape_rows(drive_x_m, self.length_m)[0])

    @property
    def frequency_hz(self) -> Real:
        """(p,) undamped natural frequencies."""
        return np.abs(self.poles) / (2 * np.pi)


def solve_modes(structure: TwinStructure) -> TwinModes:
    """The modes of a structure; a damper couples them, otherwise each keeps its own damping ratio."""
    key = (*undamped_modes_key(structure), structure.zeta.tobytes(), structure.dampers)
    return with_side_modes(structure, _DAMPED.of(key, lambda: _damped_modes(structure, *undamped_modes(structure))))


def with_side_modes(structure: TwinStructure, bending: TwinModes) -> TwinModes:
    """The modes of bending, and after them those of the families beside."""
    if not structure.side:
        return bending
    families = [poles_and_columns(one, structure.length_m) for one in structure.side]
    more = sum(
        (out_of_band_compliance(one, structure.length_m) for one in structure.side),
        np.zeros_like(bending.out_of_band),
    )
    return replace(
        bending,
        poles=np.concatenate([bending.poles, *(own for own, _ in families)]),
        columns=np.hstack([bending.columns, *(own for _, own in families)]),
        out_of_band=bending.out_of_band + more,
    )


def have_same_modes(structure: TwinStructure, other: TwinStructure) -> bool:
    """Whether two structures have the same modes."""
    if (structure.dampers, structure.side) != (other.dampers, other.side):
        return False
    if not np.array_equal(structure.zeta, other.zeta):
        return False
    return undamped_modes_key(structure) == undamped_modes_key(other)


def _damped_modes(structure: TwinStructure, omega: Real, phi: Real, out_of_band: Real) -> TwinModes:
    if structure.dampers:
        poles, mixing = damped_poles(structure, omega, phi)
        return TwinModes(poles, phi[:OWN] @ mixing, structure.length_m, out_of_band[:OWN, :OWN])
    zeta = structure.zeta
    damped = omega * np.sqrt(np.maximum(1 - zeta**2, 1e-6))
    columns = (phi[:OWN] / np.sqrt(2j * damped)).astype(np.complex128)
    return TwinModes(-zeta * omega + 1j * damped, columns, structure.length_m, out_of_band[:OWN, :OWN])


class _LatestResults(Generic[T]):
    """The latest results by what they depend on: a search asks for the same again and again."""

    def __init__(self, kept: int) -> None:
        self.kept, self.found, self.lock = kept, OrderedDict[tuple[object, ...], T](), Lock()

    def of(self, key: tuple[object, ...], make: Callable[[], T]) -> T:
        """The result of a key, made where it is not remembered."""
        with self.lock:
            if key in self.found:
                self.found.move_to_end(key)
                return self.found[key]
        made = make()
        with self.lock:
            self.found[key] = made
            while len(self.found) > self.kept:
                self.found.popitem(last=False)
        return made


_UNDAMPED = _LatestResults[tuple[Real, Real, Real]](48)
_DAMPED = _LatestResults[TwinModes](48)


def undamped_modes(structure: TwinStructure) -> tuple[Real, Real, Real]:
    """The undamped modes: (MODES,) rad/s, (n, MODES) shapes, and the (n, n) compliance of the modes above them.

    n counts the freedoms of the beam and of what hangs on it. Results are kept: damping and chain do not change them.
    """
    return _UNDAMPED.of(undamped_modes_key(structure), lambda: _undamped_modes(structure))


def _undamped_modes(structure: TwinStructure) -> tuple[Real, Real, Real]:
    stiffness, mass = stiffness_and_mass(structure)
    free = _free_degrees(structure)
    held = np.ix_(free, free)
    # The low modes are the large eigenvalues of this pencil, exact to the last digits; of the other they are the small.
    values, vectors = eigh(mass[held], stiffness[held], check_finite=False, overwrite_a=True, overwrite_b=True)
    omega, phi = 1 / np.sqrt(values[: -MODES - 1 : -1]), np.zeros((len(stiffness), MODES))
    phi[free] = vectors[:, : -MODES - 1 : -1] * omega
    # The vectors have unit strain energy: summed over all of them their squares are the compliance.
    others, out_of_band = vectors[:, :-MODES], np.zeros(stiffness.shape)
    out_of_band[held] = others @ others.T
    return omega, phi, out_of_band


def undamped_modes_key(s: TwinStructure) -> tuple[object, ...]:
    """What the undamped modes depend on; to remember them by."""
    size = s.length_m, s.width_m, s.thickness_m, s.youngs_modulus_pa, s.density_kg_m3
    fields = s.ei_field.tobytes(), s.mass_field.tobytes()
    attached = s.masses, s.springs, s.rotation_springs, s.losses, s.hung, s.tension_n, s.bedding
    return (*size, *fields, s.root_rotation, s.root_translation, *attached)


def is_clamped_at_root(structure: TwinStructure) -> tuple[bool, bool]:
    """Whether the root takes the deflection and the slope there."""
    return structure.root_translation <= RIGID, structure.root_rotation <= RIGID


def _free_degrees(structure: TwinStructure) -> NDArray[np.int64]:
    held = {i for i, taken in enumerate(is_clamped_at_root(structure)) if taken}
    return np.array([i for i in range(OWN + len(structure.hung)) if i not in held])


def damping_of(structure: TwinStructure, omega: Real, phi: Real) -> Real:
    """(n, n) damping matrix over modes."""
    damping = np.diag(2 * structure.zeta * omega)
    if structure.dampers:
        places, values = np.array(structure.dampers).T
        own = shape_rows(np.ascontiguousarray(places), structure.length_m) @ phi[:OWN]
        damping += own.T @ (values[:, None] * own)
    return damping


def damped_poles(structure: TwinStructure, omega: Real, phi: Real) -> tuple[Complex, Complex]:
    """(p,) poles, and (MODES, p) weights of the undamped shapes in their shapes, coupled by dampers."""
    n = len(omega)
    damping = damping_of(structure, omega, phi)
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
