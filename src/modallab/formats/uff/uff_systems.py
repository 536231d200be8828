"""Coordinate systems of a universal file: dataset 2420, in which nodes are placed and their motions counted.

The rows of a system's matrix are its axes and its origin, so that global = local R + origin. Nodes may be placed in one
system and move in another: fields `def_cs` and `disp_cs` of datasets 15 and 2411. A number that dataset 2420 does not
describe is the whole part's own system.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.core.errors import DataError
from modallab.core.rig import Direction
from modallab.formats.uff.uff_functions import read_datasets

CARTESIAN, CYLINDRICAL = 0, 1
_NAMES = {CYLINDRICAL: "cylindrical", 2: "spherical"}
_SQUARE = 1e-6
"""By how much axes may miss being perpendicular and of unit length."""


@dataclass(frozen=True, eq=False, slots=True)
class System:
    """One coordinate system.

    Attributes:
        label: its number.
        kind: 0 Cartesian, 1 cylindrical, 2 spherical.
        axes: (3, 3) a row for each axis, in those of the whole part.
        origin: (3,) in the unit of the file.
    """

    label: int
    kind: int
    axes: Real
    origin: Real


@dataclass(frozen=True, eq=False, slots=True)
class Nodes:
    """Where the nodes of a file are, and along which axes each one's motion is counted.

    Attributes:
        at: node -> (3,) in the axes of the whole part, in the unit of the file.
        axes: node -> (3, 3) a row for each local axis, for those whose axes are not the whole part's.
    """

    at: dict[int, Real]
    axes: dict[int, Real]

    def turned(self, node: int, motion: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """A motion along the node's own axes, along those of the whole part."""
        return motion @ self.axes[node] if node in self.axes else motion

    def direction(self, node: int, local: Direction, where: str) -> Direction:
        """A direction at a node, in the axes of the whole part.

        Raises:
            DataError: it lies between them, which no rig file can say.
        """
        if node not in self.axes:
            return local
        row = self.axes[node]["xyz".index(local[1])] * (1 if local[0] == "+" else -1)
        main = int(np.argmax(np.abs(row)))
        if abs(row[main]) < 1 - _SQUARE:
            raise DataError(
                f"direction {local} at node {node} is {np.round(row, 3).tolist()} in global coordinates, "
                "and along none of their axes",
                where=where,
                remedy="export in the global coordinate system, or give a rig file with --rig",
            )
        return f"{'+' if row[main] > 0 else '-'}{'xyz'[main]}"  # pyrefly: ignore[bad-return]


def read_nodes(path: Path) -> Nodes:
    """The nodes of a universal file in the axes of the whole part.

    Raises:
        FormatError: no universal file, cut off or damaged.
        DataError: nodes are placed in a cylindrical or spherical system, or the axes of one are not perpendicular.
    """
    systems = {s.label: s for s in _systems(read_datasets(path, 2420), str(path))}
    found = Nodes({}, {})
    for content in (*read_datasets(path, 15), *read_datasets(path, 2411)):
        columns = (content[name] for name in ("node_nums", "def_cs", "disp_cs", "x", "y", "z"))
        for n, placed, moving, *xyz in zip(*columns, strict=True):
            node, local = int(n), np.array([float(v) for v in xyz])
            found.at[node] = _placed(local, systems.get(int(placed)), node, str(path))
            axes = _axes(found.at[node], systems.get(int(moving)), node, str(path))
            if axes is not None and not np.allclose(axes, np.eye(3), atol=_SQUARE):
                found.axes[node] = axes
    return found


def _systems(contents: Iterable[Mapping[str, Any]], where: str) -> Iterable[System]:
    for content in contents:
        parts = (content[name] for name in ("CS_sys_labels", "CS_types", "CS_matrices"))
        for label, kind, matrix in zip(*parts, strict=True):
            values = np.asarray(matrix, np.float64)
            axes = values[:3]
            if values.shape != (4, 3) or not np.allclose(axes @ axes.T, np.eye(3), atol=1e-3):
                raise DataError(
                    f"the axes of coordinate system {label} are not perpendicular, or not of unit length",
                    where=where,
                    remedy="export the file again, in the global coordinate system",
                )
            yield System(int(label), int(kind), axes, values[3])


def _placed(local: Real, system: System | None, node: int, where: str) -> Real:
    if system is None:
        return local
    if system.kind != CARTESIAN:
        raise DataError(
            f"node {node} is placed in the {_NAMES.get(system.kind, 'unknown')} coordinate system {system.label}, and "
            "in which unit its angles are, such files do not say",
            where=where,
            remedy="export the geometry in the global coordinate system",
        )
    return local @ system.axes + system.origin


def _axes(at: Real, system: System | None, node: int, where: str) -> Real | None:
    if system is None or system.kind == CARTESIAN:
        return None if system is None else system.axes
    if system.kind != CYLINDRICAL:
        raise DataError(
            f"node {node} moves in the {_NAMES.get(system.kind, 'unknown')} coordinate system {system.label}",
            where=where,
            remedy="export in the global coordinate system",
        )
    # Along the radius, around the axis and along it, where the node stands.
    x, y, _ = (at - system.origin) @ system.axes.T
    radius = np.hypot(x, y)
    c, s = (x / radius, y / radius) if radius > 0 else (1.0, 0.0)
    return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) @ system.axes
