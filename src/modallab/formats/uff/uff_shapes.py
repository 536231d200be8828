"""Mode shapes of a universal file: dataset 55, at the nodes of dataset 15."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import DataError
from modallab.core.rig import Channel, Rig
from modallab.formats.modes import ModeShapes
from modallab.formats.uff.uff_functions import read_datasets
from modallab.formats.uff.uff_match import sense
from modallab.signals.conversion import sign_of

NODES_SET, SHAPE_SET, UNITS_SET = 15, 55, 164
NORMAL, COMPLEX = 2, 3
"""Analysis types that are modes; others are static or forced responses."""
_DIGITS = 2e-5
"""Two coordinates of six digits differ by less, relative to the larger one, if they are the same place."""


@dataclass(frozen=True, eq=False)
class _Mode:
    title: str
    pole: complex
    mass_kg: float
    at: dict[int, NDArray[np.complex128]]


def read_uff_shapes(path: Path, rig: Rig) -> tuple[ModeShapes, ...]:
    """The modes of a universal file, those with the same first identification line together; () if there are none.

    A shape is taken at the rig's response channels that stand at one of its nodes, positive along the drive.

    Raises:
        FormatError: no universal file, cut off or damaged.
        DataError: not in SI, no node is a point of the rig, nodes are apart by other distances than the rig's points,
            or modes of one title are at different nodes.
    """
    where = str(path)
    modes = [_mode(content) for content in read_datasets(path, SHAPE_SET) if _is_mode(content)]
    if not modes:
        return ()
    for units in read_datasets(path, UNITS_SET):
        if units.get("units_code") != 1:
            raise DataError("its shapes are not in SI", where=where, remedy="export them again in SI units")
    for nodes in read_datasets(path, NODES_SET):
        _check_nodes(nodes, rig, where)
    titles = dict.fromkeys(mode.title for mode in modes)
    return tuple(_model(title, [m for m in modes if m.title == title], rig, where) for title in titles)


def _is_mode(content: Mapping[str, Any]) -> bool:
    return int(content["analysis_type"]) in (NORMAL, COMPLEX)


def _mode(content: Mapping[str, Any]) -> _Mode:
    if int(content["analysis_type"]) == NORMAL:
        omega, zeta = 2 * np.pi * float(content["freq"]), float(content["modal_damp_vis"])
        pole = complex(-zeta * omega, omega * np.sqrt(max(0.0, 1 - zeta**2)))
        mass = float(content["modal_m"])
    else:
        pole = complex(content["eig"])
        # Modal A of a mode of mass m is 2 j omega_d m.
        mass = float((complex(content["modal_a"]) / (2j * pole.imag)).real) if pole.imag else 0.0
    components = [np.asarray(content[name], dtype=np.complex128) for name in ("r1", "r2", "r3")]
    nodes = [int(node) for node in content["node_nums"]]
    at = dict(zip(nodes, np.stack(components, axis=1), strict=True))
    return _Mode(str(content["id1"]).strip(), pole, mass if mass > 0 else float("nan"), at)


def _model(title: str, modes: Sequence[_Mode], rig: Rig, where: str) -> ModeShapes:
    if any(mode.at.keys() != modes[0].at.keys() for mode in modes):
        raise DataError(f"the modes of {title!r} are at different nodes", where=where, remedy="export them as one")
    channels = [channel for channel in rig.responses if channel.point in modes[0].at]
    if not channels:
        nodes = ", ".join(map(str, modes[0].at))
        raise DataError(
            f"no response channel of the rig stands at a node of {title!r} ({nodes})",
            where=where,
            remedy="give the rig's channels these points",
        )
    poles = np.array([mode.pole for mode in modes], dtype=np.complex128)
    return ModeShapes(
        title=title,
        frequency_hz=np.abs(poles) / (2 * np.pi),
        damping_ratio=-np.real(poles) / np.abs(poles),
        outputs=tuple(channel.name for channel in channels),
        output_points=tuple(channel.point for channel in channels),
        modal_mass_kg=np.array([mode.mass_kg for mode in modes]),
        shapes=np.array([[_along(mode, channel, rig, where) for channel in channels] for mode in modes]),
    )


def _along(mode: _Mode, channel: Channel, rig: Rig, where: str) -> complex:
    axis = "xyz".index(channel.direction[1])
    assert channel.point is not None
    along = sense(axis + 1, channel.direction, where, f"the direction of channel {channel.name}")
    return complex(mode.at[channel.point][axis]) * along * sign_of(rig, channel)


def _check_nodes(content: Mapping[str, Any], rig: Rig, where: str) -> None:
    places = np.stack([np.asarray(content[name], dtype=np.float64) for name in "xyz"], axis=1)
    known = {point.id: np.array([point.x_m, point.y_m, point.z_m]) for point in rig.points}
    common = [(int(node), at) for node, at in zip(content["node_nums"], places, strict=True) if int(node) in known]
    for node, at in common[1:]:
        first, origin = common[0]
        apart, own = float(np.linalg.norm(at - origin)), float(np.linalg.norm(known[node] - known[first]))
        if abs(apart - own) > _DIGITS * max(float(np.abs(places).max()), float(np.abs(known[node]).max())):
            raise DataError(
                f"nodes {first} and {node} are {apart:g} m apart, the rig's points {own:g} m",
                where=where,
                remedy="correct the points of the rig file, or number the nodes as the rig does",
            )
