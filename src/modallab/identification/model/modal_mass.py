"""Shapes at unit modal mass, from modal constants and the driving points.

A modal constant is a response over a force, so that both sensitivities count; a shape at unit modal mass takes its
scale from the driving point by a root. Sensors are taken as independent of each other.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.digits import number_ranges
from modallab.core.errors import DataError
from modallab.core.model import ModalModel, ScaleUncertainty
from modallab.core.rig import Channel, Rig
from modallab.core.units import BROADBAND


@dataclass(frozen=True, eq=False, slots=True)
class UnitMassShapes:
    """phi (modes, outputs) at unit modal mass with one sigma, or why there are none."""

    phi: NDArray[np.complex128] | None
    sigma: NDArray[np.float64] | None
    unavailable: str


def unit_mass_shapes(
    constants: NDArray[np.complex128],
    sigma: NDArray[np.float64],
    output_points: Sequence[int | None],
    input_points: Sequence[int | None],
    driving: Sequence[int | None] | None = None,
) -> UnitMassShapes:
    """Shapes with A_jk = phi_j phi_k (eq. 13), by least squares over all inputs, weighted by 1 / sigma^2.

    An input without a sensor at its point helps with the shape, but only a driving point gives the modal mass.

    Args:
        constants: (modes, outputs, inputs) modal constants, kg^-1.
        sigma: (modes, outputs, inputs) their uncertainty.
        output_points: point of each output.
        input_points: point of each input.
        driving: point of each output that moves along the drive, None for the others; None where all do.

    Raises:
        DataError: constants that are not finite, or do not fit sigma or points.
    """
    check_constants(constants, sigma, output_points, input_points)
    driving = output_points if driving is None else driving
    unavailable = reason_without_unit_mass(output_points, input_points, driving)
    if unavailable:
        return UnitMassShapes(None, None, unavailable)
    rows = [None if p is None else _index_of_point(driving, p) for p in input_points]
    found = [_one_mode(a, s, rows) for a, s in zip(constants, sigma, strict=True)]
    return UnitMassShapes(np.array([f[0] for f in found]), np.array([f[1] for f in found]), "")


def check_constants(
    constants: NDArray[np.complex128],
    sigma: NDArray[np.float64],
    output_points: Sequence[int | None],
    input_points: Sequence[int | None],
) -> None:
    """Reject modal constants that cannot be.

    Raises:
        DataError: they are not finite, or not (modes, outputs, inputs) of these points and sigmas.
    """
    shape = (len(constants), len(output_points), len(input_points))
    if constants.shape != shape or sigma.shape != shape or not np.isfinite(constants).all():
        raise DataError(
            f"modal constants {constants.shape} with sigma {sigma.shape} are not {shape}, or not finite",
            remedy="give (modes, outputs, inputs) of both, with a point for every output and input",
        )


def reason_without_unit_mass(
    output_points: Sequence[int | None],
    input_points: Sequence[int | None],
    driving: Sequence[int | None] | None = None,
) -> str:
    """Why there can be no shapes at unit modal mass, or "" if there can; arguments as of `unit_mass_shapes`."""
    known = [p for p in output_points if p is not None]
    if not known:
        return "no shapes: no sensor stands at a known point; no modal mass for the same reason"
    along = known if driving is None else driving
    if not any(p is not None and p in along for p in input_points):
        driven = number_ranges(input_points)
        if any(p is not None and p in known for p in input_points):
            return f"no modal mass: no sensor at a driven point (driven: {driven}) looks along the drive; put one there"
        return f"no modal mass: no sensor stands at a driven point (driven: {driven}); put one there"
    return ""


def _index_of_point(points: Sequence[int | None], point: int) -> int | None:
    return list(points).index(point) if point in points else None


def _one_mode(
    a: NDArray[np.complex128], sigma: NDArray[np.float64], rows: Sequence[int | None]
) -> tuple[NDArray[np.complex128], NDArray[np.float64]]:
    weight = 1 / np.maximum(sigma, 1e-12 * np.abs(a).max() + 1e-300) ** 2
    driven = [(k, row) for k, row in enumerate(rows) if row is not None]
    # The best driving point is the one whose own constant is known best.
    best, row = max(driven, key=lambda item: np.abs(a[item[1], item[0]]) / sigma[item[1], item[0]])
    phi = a[:, best] / np.sqrt(a[row, best])
    for _ in range(20):
        at_input = np.array(
            [phi[r] if r is not None else _is_unseen(a[:, k], phi, weight[:, k]) for k, r in enumerate(rows)]
        )
        phi = (weight * a) @ at_input.conj() / (weight @ np.abs(at_input) ** 2)
    at_input = np.array(
        [phi[r] if r is not None else _is_unseen(a[:, k], phi, weight[:, k]) for k, r in enumerate(rows)]
    )
    own = (weight @ np.abs(at_input) ** 2) ** -0.5
    relative = sigma[row, best] / (2 * np.abs(a[row, best]))
    turned = phi * np.exp(-1j * np.angle(phi[np.argmax(np.abs(phi))]))
    # Keep the phase that belongs to unit modal mass; only the sign is free.
    sign = 1.0 if np.real(np.vdot(turned, phi)) >= 0 else -1.0
    return sign * phi, np.sqrt(own**2 + (np.abs(phi) * relative) ** 2)


def _is_unseen(
    column: NDArray[np.complex128], phi: NDArray[np.complex128], weight: NDArray[np.float64]
) -> np.complex128:
    return np.sum(weight * phi.conj() * column) / np.sum(weight * np.abs(phi) ** 2)


def driving_points(rig: Rig) -> tuple[int | None, ...]:
    """(responses,) the point of each response that moves along the drive's axis, None for every other."""
    axis = rig.drive_direction[1]
    return tuple(c.point if c.direction[1] == axis else None for c in rig.responses)


def relative_sigma(channel: Channel, rig: Rig) -> float | None:
    """One standard deviation of a channel's sensitivity, relative: by its last calibration; None where none states it.

    A certificate and the rig's history both count; the later one is taken.
    """
    history = [e for e in rig.history if e.channel == channel.name and e.sigma_v_per_unit > 0]
    latest = max(history, key=lambda entry: entry.date, default=None)
    certificate = channel.certificate
    if certificate is not None and (latest is None or latest.date <= certificate.date):
        return certificate.relative_sigma
    if latest is None:
        return None
    return latest.sigma_v_per_unit / abs(latest.sensitivity_v_per_unit)


def with_scale(model: ModalModel, rig: Rig) -> ModalModel:
    """The model with the uncertainty of its scale, as far as certificates or calibrations state it."""
    force = _force_sigma(model, rig)
    known = {channel.name: relative_sigma(channel, rig) for channel in rig.responses}
    if force is None and not any(known.get(name) for name in model.outputs):
        return model
    f = np.nan if force is None else force
    u = np.array([np.nan if (value := known.get(name)) is None else value for name in model.outputs])
    constants = np.hypot(u, f)
    row = _driving_row(model, rig)
    if row is None:
        shapes, mass = np.full(len(u), np.nan), None
    else:
        shapes = np.sqrt(u**2 + (u[row] ** 2 + f**2) / 4)
        mass = float(constants[row]) if np.isfinite(constants[row]) else None
        shapes[row] = constants[row] / 2
    scale = ScaleUncertainty(force=force, responses=u, modal_constants=constants, shapes=shapes, modal_mass=mass)
    return model.model_copy(update={"scale_uncertainty": scale})


def _force_sigma(model: ModalModel, rig: Rig) -> float | None:
    """Of the force; of several that drove at once the least certain one's, None where one of them states none."""
    used = rig.forces if model.test in BROADBAND and len(model.input_points) > 1 else (rig.force_channel,)
    sigmas = [relative_sigma(channel, rig) for channel in used]
    known = [sigma for sigma in sigmas if sigma is not None]
    return max(known) if len(known) == len(sigmas) else None


def _driving_row(model: ModalModel, rig: Rig) -> int | None:
    along = dict(zip((c.name for c in rig.responses), driving_points(rig), strict=True))
    driven = [p for p in model.input_points if p is not None]
    rows = (n for p in driven for n, name in enumerate(model.outputs) if along.get(name) == p)
    return next(rows, None)
