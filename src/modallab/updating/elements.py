"""A finite-element model as the modal model that a test on the rig would give."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.core.errors import DataError
from modallab.core.frf import DERIVATIVES, Frf
from modallab.core.model import ModalModel
from modallab.core.rig import Channel, Point, Rig
from modallab.formats.fem.fem_file import FemModel
from modallab.identification.likelihood.basis import poles_of
from modallab.identification.model.modal_model import POWERS, fold_into_residuals
from modallab.modification.freedoms import Freedom
from modallab.modification.mesh import Mesh

COMPUTED = "finite_elements"
"""The method of a model that was computed, and not measured."""
ABOVE = 1.1
"""Modes up to this part of the band's end stay modes; of those above it there is what they move in the band."""
NEAR = 0.03
"""Of the rig's extent: a node farther than that from a point is not the point's."""
APART = 20.0
"""Ratio of two frequencies that follow each other, from which those below are motions of the whole."""
RIGID = 6
UNSEEN = 1e-6
"""Of the largest modal constant: a mode that no sensor sees by more is left out."""


def model_of_elements(fem: FemModel, rig: Rig, band_hz: tuple[float, float], inputs: tuple[int, ...]) -> ModalModel:
    """The model's modes at the rig's channels, driven at the points `inputs`, in the band of a test.

    Modes above the band add what they move within it, motions of the whole their inertance.

    Raises:
        DataError: a point is at no node, a channel has none, or the band holds no mode.
    """
    channels = _channels_of_rig(rig)
    constants = _modal_constants(fem, rig, channels, inputs)
    hz, zeta = fem.modes.frequency_hz, _damping_ratios(fem, rig)
    rigid = np.arange(hz.size) < _rigid_body_modes(hz)
    inside = ~rigid & (hz <= ABOVE * band_hz[1])
    kept = _kept_modes(inside, constants)
    if not np.any(kept):
        raise DataError(
            f"the model has no mode up to {band_hz[1]:.4g} Hz that the sensors see",
            where=fem.modes.title,
            remedy="compute more modes, or check its units: units: mm for a model in mm and tonnes",
        )
    above = ~rigid & ~inside
    # Where nothing moves as a whole, nothing is said of it: a test's own term is then not known, instead of wrong.
    whole = {-2: np.sum(constants[rigid], axis=0)} if np.any(rigid) else {}
    poles = poles_of(2 * np.pi * hz[above], zeta[above])
    outside = whole | dict(
        zip(POWERS, fold_into_residuals(poles, constants[above].astype(np.complex128), band_hz), strict=True)
    )
    return _model_of_elements(fem, rig, band_hz, channels, inputs, kept, constants, outside)


def frf_of_elements(fem: FemModel, rig: Rig, like: Frf, inputs: tuple[int, ...]) -> Frf:
    """What the model's modes, all of them, give on the lines and in the quantity of measured FRFs, without noise.

    Raises:
        DataError: a point is at no node.
    """
    channels = _channels_of_rig(rig)
    s = like.damping_shift + 2j * np.pi * like.frequency_hz[:, None]
    omega, zeta = 2 * np.pi * fem.modes.frequency_hz, _damping_ratios(fem, rig)
    kernels = s ** DERIVATIVES[like.quantity] / (s**2 + 2 * zeta * omega * s + omega**2)
    values = np.einsum("roi,lr->oil", _modal_constants(fem, rig, channels, inputs), kernels, optimize=True)
    return replace(
        like,
        values=values,
        outputs=tuple(c.name for c in channels),
        output_points=tuple(c.point for c in channels),
        input_points=inputs,
        coherence=None,
        variance=np.zeros(values.shape),
    )


def mesh_shapes(fem: FemModel, rig: Rig, band_hz: tuple[float, float], inputs: tuple[int, ...]) -> Mesh | None:
    """Shapes of the modes of `model_of_elements` at all nodes; None where the file does not say where these are.

    Nor where its owner has named the nodes of points: its places need not be those of the rig then.

    Raises:
        DataError: as `model_of_elements`.
    """
    nodes = [node for node in fem.modes.at if node in fem.modes.places_m]
    if not nodes or fem.points:
        return None
    hz = fem.modes.frequency_hz
    inside = (np.arange(hz.size) >= _rigid_body_modes(hz)) & (hz <= ABOVE * band_hz[1])
    kept = _kept_modes(inside, _modal_constants(fem, rig, _channels_of_rig(rig), inputs))
    sense, axis = rig.drive_direction
    turned = {a: -1.0 if (sense, a) == ("-", axis) else 1.0 for a in "xyz"}
    motion = np.array([fem.modes.at[node][kept] for node in nodes])
    places = np.array([fem.modes.places_m[node] for node in nodes])
    return Mesh(places, {a: turned[a] * motion[:, :, k] for k, a in enumerate("xyz")})


def shapes_at(fem: FemModel, rig: Rig, freedoms: Sequence[Freedom]) -> tuple[Real, Real]:
    """(modes,) Hz and (modes, freedoms) shapes at unit modal mass, without motions of the whole.

    Raises:
        DataError: a point is at no node.
    """
    kept = slice(_rigid_body_modes(fem.modes.frequency_hz), None)
    drive = rig.drive_direction
    columns = [_along_axis(fem, rig, point, drive if axis == drive[1] else f"+{axis}") for point, axis in freedoms]
    return fem.modes.frequency_hz[kept], np.stack(columns, axis=1)[kept]


def _channels_of_rig(rig: Rig) -> list[Channel]:
    return [channel for channel in rig.responses if channel.point is not None]


def _modal_constants(fem: FemModel, rig: Rig, channels: list[Channel], inputs: tuple[int, ...]) -> Real:
    """(modes, outputs, inputs) of all modes."""
    out = np.array([_motion_along(fem, rig, c.point or 0, c) for c in channels]).T
    into = np.array([_motion_along(fem, rig, p, None) for p in inputs]).T
    return out[:, :, None] * into[:, None, :]


def _kept_modes(inside: NDArray[np.bool_], constants: Real) -> NDArray[np.bool_]:
    """(modes,) those of the band that a sensor sees."""
    size = np.max(np.abs(constants), axis=(1, 2)) if len(constants) else np.zeros(0)
    return inside & (size > UNSEEN * size.max(initial=0.0))


def _model_of_elements(
    fem: FemModel,
    rig: Rig,
    band_hz: tuple[float, float],
    channels: list[Channel],
    inputs: tuple[int, ...],
    kept: NDArray[np.bool_],
    constants: Real,
    outside: dict[int, Real],
) -> ModalModel:
    nothing = np.full(int(kept.sum()), np.nan)
    return ModalModel(
        method=COMPUTED,
        band_hz=band_hz,
        frequency_hz=fem.modes.frequency_hz[kept],
        damping_ratio=_damping_ratios(fem, rig)[kept],
        frequency_sigma_hz=nothing,
        damping_sigma=nothing,
        outputs=tuple(c.name for c in channels),
        output_points=tuple(c.point for c in channels),
        input_points=inputs,
        modal_constants=constants[kept].astype(np.complex128),
        modal_constant_sigma=np.full(constants[kept].shape, np.nan),
        residuals=np.stack(list(outside.values())),
        residual_powers=tuple(outside),
        half_power=nothing,
        half_power_floor=nothing,
        notes=(f"Computed by finite elements: {fem.modes.title}. Its damping ratios are not computed.",),
    )


def _damping_ratios(fem: FemModel, rig: Rig) -> Real:
    """(modes,) damping ratios, guessed where they were not computed."""
    zeta = fem.modes.damping_ratio
    return np.where(np.isnan(zeta), rig.damping_ratio.guess, zeta)


def _rigid_body_modes(hz: Real) -> int:
    """How many of the lowest modes are motions of the whole: they stand apart from all others."""
    first = hz[: RIGID + 1]
    for n in range(first.size - 1, 0, -1):
        if first[n] > APART * max(first[n - 1], np.finfo(float).tiny):
            return n
    return 0


def _motion_along(fem: FemModel, rig: Rig, point: int, channel: Channel | None) -> Real:
    """(modes,) motion at a point as the channel reads it, or along the drive."""
    # What reads along the drive's axis has been turned to its sense.
    drive = rig.drive_direction
    direction = drive if channel is None or channel.direction[1] == drive[1] else channel.direction
    return _along_axis(fem, rig, point, direction)


def _along_axis(fem: FemModel, rig: Rig, point: int, direction: str) -> Real:
    sense = -1.0 if direction[0] == "-" else 1.0
    return sense * fem.modes.at[_node_of_point(fem, rig, point)][:, "xyz".index(direction[1])]


def _node_of_point(fem: FemModel, rig: Rig, point: int) -> int:
    here = next(p for p in rig.points if p.id == point)
    named = fem.points.get(point, point)
    if point in fem.points or (named in fem.modes.at and not fem.modes.places_m):
        return _require_node(fem, named, point)
    known = [node for node in fem.modes.at if node in fem.modes.places_m]
    if not known:
        return _require_node(fem, named, point)
    away = np.linalg.norm(np.array([fem.modes.places_m[n] for n in known]) - _coordinates(here), axis=1)
    nearest = int(np.argmin(away))
    if away[nearest] > NEAR * _extent_of_rig(rig):
        raise DataError(
            f"point {point} at {tuple(_coordinates(here).tolist())} m is {away[nearest]:.3g} m from the nearest node",
            where=fem.modes.title,
            remedy=f"describe the model in a YAML file: points: {{{point}: NODE}}, or units: mm if that is its unit",
        )
    # Nodes at one place, of a hinge or a rigid link: the one of the point's own number before others.
    same = [n for n, d in zip(known, away, strict=True) if d <= away[nearest] + 1e-9]
    return named if named in same else same[0]


def _require_node(fem: FemModel, node: int, point: int) -> int:
    if node in fem.modes.at:
        return node
    raise DataError(
        f"has no node {node} for point {point}",
        where=fem.modes.title,
        remedy=f"give the node in a YAML file: points: {{{point}: NODE}}",
    )


def _coordinates(point: Point) -> Real:
    return np.array([point.x_m, point.y_m, point.z_m])


def _extent_of_rig(rig: Rig) -> float:
    return float(np.ptp(np.array([_coordinates(p) for p in rig.points]), axis=0).max())
