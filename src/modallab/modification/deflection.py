"""How a structure moves at one frequency: a mode's shape, or the operating deflection shape that FRFs show."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Complex, Real
from modallab.core.errors import DataError
from modallab.core.frf import UNIT, Frf
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.modification.freedoms import Freedom
from modallab.modification.structure import Structure


@dataclass(frozen=True, eq=False, slots=True)
class Deflection:
    """Motion of every freedom at one frequency.

    Attributes:
        what: it is, in words.
        frequency_hz: at which.
        freedoms: (freedoms,) point and axis.
        values: (freedoms,) complex, in `unit`.
        sigma: (freedoms,) one standard deviation of the complex number; NaN where not known.
        unit: of values and sigma.
    """

    what: str
    frequency_hz: float
    freedoms: tuple[Freedom, ...]
    values: Complex
    sigma: Real
    unit: str

    @property
    def names(self) -> tuple[str, ...]:
        """(freedoms,) as figures and tables call them: an axis only where a point moves along several."""
        several = len({f[0] for f in self.freedoms}) < len(self.freedoms)
        return tuple(f"{point}{axis}" if several else str(point) for point, axis in self.freedoms)


def mode_deflection(structure: Structure, samples: Structure, mode: int) -> Deflection:
    """The shape of a mode at unit modal mass, as real as a turn of its phase makes it.

    Args:
        structure: as the model has it.
        samples: (samples, ...) of it, for the deviation.
        mode: from 1.

    Raises:
        DataError: no such mode.
    """
    modes = len(structure.poles)
    if not 1 <= mode <= modes:
        raise DataError(f"there is no mode {mode}", remedy=f"name one from 1 to {modes}")
    pole = structure.poles[mode - 1]
    phi, varied = (rotate_to_real(s.psi[..., mode - 1, :] * np.sqrt(2j * pole.imag)) for s in (structure, samples))
    hz = float(np.abs(pole)) / (2 * np.pi)
    return Deflection(f"mode {mode}", hz, structure.freedoms, phi, np.std(varied, axis=0), "kg^-1/2")


def operating_deflection(frf: Frf, freedoms: tuple[Freedom, ...], hz: float, at: int) -> Deflection:
    """The motion per newton at one point, as FRFs show it at their line nearest to a frequency.

    Points that were only driven take part where a sensor stands at that point: a hit there moves the sensor as a hit at
    the sensor moves that point (reciprocity).

    Args:
        frf: as measured.
        freedoms: (outputs,) point and axis.
        hz: frequency.
        at: point of the force.

    Raises:
        DataError: no force acted at the point nor stood a sensor there, or a frequency outside the lines.
    """
    line = _nearest_line(frf, hz)
    sigma = deviation_of_frf(frf)
    found: dict[Freedom, tuple[complex, float]] = {}
    if at in frf.input_points:
        column = frf.input_points.index(at)
        seen = zip(frf.values[:, column, line], sigma[:, column, line], strict=True)
        found = dict(zip(freedoms, seen, strict=True))
    stands = [n for n, f in enumerate(freedoms) if f[0] == at]
    if stands:
        axis = freedoms[stands[0]][1]
        row = zip(frf.values[stands[0], :, line], sigma[stands[0], :, line], strict=True)
        for point, value in zip(frf.input_points, row, strict=True):
            found.setdefault((int(point or 0), axis), value)
    if not found:
        driven = ", ".join(str(p) for p in frf.input_points)
        raise DataError(f"no force acted at point {at}", remedy=f"name one that was driven: {driven}")
    values, deviations = (np.array(part) for part in zip(*found.values(), strict=True))
    what = f"operating deflection shape, force at point {at}"
    return Deflection(what, float(frf.frequency_hz[line]), tuple(found), values, deviations, UNIT[frf.quantity])


def deviation_of_frf(frf: Frf) -> Real:
    """Standard deviation of each complex number; from coherence, where no variance is stated; else NaN.

    Bendat, Piersol, Random Data, 4th ed. 2010, section 9.2, unbiased: a single block says nothing of its noise.

    Args:
        frf: as measured.

    Returns:
        (outputs, inputs, lines) in the unit of the FRFs.
    """
    if frf.variance is not None:
        return np.sqrt(frf.variance)
    unknown = np.full(frf.values.shape, np.nan)
    if frf.coherence is None or not frf.averages:
        return unknown
    explained = frf.coherence * (np.array(frf.averages)[:, None] - 1)
    share = np.divide(1 - frf.coherence, explained, out=unknown, where=explained > 0)
    return np.asarray(np.abs(frf.values) * np.sqrt(share))


def _nearest_line(frf: Frf, hz: float) -> int:
    low, high = frf.frequency_hz[0], frf.frequency_hz[-1]
    if not low <= hz <= high:
        raise DataError(f"{hz:g} Hz is outside the FRFs", remedy=f"stay within {low:.4g} to {high:.4g} Hz")
    return int(np.argmin(np.abs(frf.frequency_hz - hz)))


def rotate_to_real(values: Complex) -> NDArray[np.complex128]:
    """(..., freedoms) as real as a common turn makes them, positive where they are largest."""
    real = values * np.exp(-0.5j * np.angle(np.sum(values**2, axis=-1, keepdims=True)))
    largest = np.argmax(np.abs(real), axis=-1)[..., None]
    negative = np.real(np.take_along_axis(real, largest, axis=-1)) < 0
    return np.asarray(real * np.where(negative, -1, 1), np.complex128)


def motion_in_space(rig: Rig, deflection: Deflection) -> NDArray[np.complex128]:
    """(points, 3) the motion at the points of a rig along x, y, z; a point that is not known stays at rest."""
    return motion_at_points(rig, deflection.freedoms, deflection.values)


def shapes_at_freedoms(model: ModalModel, rig: Rig) -> tuple[tuple[Freedom, ...], Complex, Real] | None:
    """Shapes where sensors stood, and by reciprocity where forces acted; operating shapes if there are no others.

    Returns:
        (freedoms,), (modes, freedoms) along them at unit modal mass, and one sigma, NaN where not known; None for none.
    """
    own = (model.shapes, model.shape_sigma)
    phi, sigma = own if model.shapes is not None else (model.operating_shapes, model.operating_shape_sigma)
    if phi is None:
        return None
    channels = {c.name: c for c in rig.responses if c.point is not None}
    rows = [n for n, name in enumerate(model.outputs) if name in channels]
    known = [channels[model.outputs[n]] for n in rows]
    freedoms = [(c.point or 0, c.direction[1]) for c in known]
    moved = np.asarray(phi[:, rows] * [rig.sense_of(c) for c in known])
    off = np.full(moved.shape, np.nan) if sigma is None else sigma[:, rows]
    struck = {(p, rig.drive_direction[1]): i for i, p in enumerate(model.input_points) if p is not None}
    other = [f for f in struck if f not in freedoms] if model.shapes is not None else []
    driven, driven_off = _shapes_at_inputs(model, [struck[f] for f in other])
    return (*freedoms, *other), np.hstack([moved, driven]), np.hstack([off, driven_off])


def _shapes_at_inputs(model: ModalModel, inputs: list[int]) -> tuple[Complex, Real]:
    """(modes, inputs) of A_jk = phi_j phi_k by least squares over the outputs j, and one sigma."""
    phi = np.zeros((model.n_modes, len(model.outputs))) if model.shapes is None else model.shapes
    sigma = model.modal_constant_sigma[:, :, inputs]
    weight = 1 / np.where(sigma > 0, sigma, 1.0) ** 2
    power = np.einsum("moi,mo->mi", weight, np.abs(phi) ** 2)
    found = np.einsum("moi,mo,moi->mi", weight, phi.conj(), model.modal_constants[:, :, inputs]) / power
    return found, np.where(np.isfinite(sigma).all(axis=1), power**-0.5, np.nan)


def motion_at_points(rig: Rig, freedoms: Sequence[Freedom], values: Complex) -> NDArray[np.complex128]:
    """The same of values (freedoms,) at freedoms."""
    place = {p.id: n for n, p in enumerate(rig.points)}
    motion = np.zeros((len(rig.points), 3), np.complex128)
    drive = rig.drive_direction
    for (point, axis), value in zip(freedoms, values, strict=True):
        # Freedoms along the drive are positive along it.
        sign = -1.0 if axis == drive[1] and drive[0] == "-" else 1.0
        if point in place and np.isfinite(value):
            motion[place[point], "xyz".index(axis or "z")] = sign * value
    return motion
