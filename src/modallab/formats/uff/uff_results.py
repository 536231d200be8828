"""Geometry and modes of a universal file, whatever rig they belong to: datasets 15, 2411, 82, 2412, 55 and 2414."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.formats.uff.uff_functions import read_datasets
from modallab.formats.uff.uff_systems import Nodes, read_nodes

NORMAL, COMPLEX = 2, 3
"""Analysis types that are modes; others are static or forced responses."""
MOTION = (8, 11, 12)
"""Result types that are motions: displacement, velocity and acceleration."""
AT_NODES = 1
PAIRS = (5, 6)
"""Data types that are complex, in single and double precision; others are real."""
_OPEN = range(11, 25)
"""Descriptors of rods and beams, whose nodes follow each other along a line."""
FIRST_SOLID = 101
"""Descriptors from here on are solids, springs, masses and constraints."""
_SOLID_EDGES: dict[int, Sequence[tuple[int, int]]] = {
    111: ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)),
    112: ((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)),
    115: ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)),
}
"""Edges of linear tetrahedra, wedges and bricks."""

Edge = tuple[int, int]


@dataclass(frozen=True, eq=False, slots=True)
class Geometry:
    """Where nodes are, and which are joined where the structure is drawn.

    Attributes:
        points: node -> x, y, z in m.
        lines: pairs of nodes.
        surfaces: nodes around each shell element.
    """

    points: dict[int, tuple[float, float, float]]
    lines: tuple[Edge, ...]
    surfaces: tuple[tuple[int, ...], ...] = ()


@dataclass(frozen=True, eq=False, slots=True)
class NodeMode:
    """One mode at nodes.

    Attributes:
        title: what the file says of it.
        frequency_hz: undamped natural frequency.
        damping_ratio: of critical damping.
        at: node -> (3,) complex motion along x, y, z, scaled as in the file.
        modal_mass_kg: that belongs to this scale; 0 where the file does not say.
    """

    title: str
    frequency_hz: float
    damping_ratio: float
    at: dict[int, NDArray[np.complex128]]
    modal_mass_kg: float = 0.0


@dataclass(frozen=True, eq=False, slots=True)
class Results:
    """What a universal file holds beside measurements; `forced` counts deflections under a load, which are no modes."""

    geometry: Geometry
    modes: tuple[NodeMode, ...]
    forced: int = 0


def read_results(path: Path) -> Results:
    """Geometry in m and modes of a universal file.

    Coordinates and motions are turned into the axes of the whole part, and coordinates divided by the length factor of
    dataset 164 if there is one.

    Raises:
        FormatError: no universal file, cut off or damaged.
        DataError: nodes in coordinate systems that are not understood.
    """
    units = read_datasets(path, 164)
    factor = float(units[0].get("length") or 1.0) if units else 1.0
    nodes = read_nodes(path)
    points = {n: (float(x) / factor, float(y) / factor, float(z) / factor) for n, (x, y, z) in nodes.at.items()}
    elements = [e for content in read_datasets(path, 2412) for e in _elements(content)]
    edges = [*_traced(read_datasets(path, 82)), *(edge for e in elements for edge in _edges(*e))]
    faces = tuple(tuple(nodes) for descriptor, nodes in elements if _is_shell(descriptor, nodes, points))
    lines = dict.fromkeys((min(a, b), max(a, b)) for a, b in edges if a != b and a in points and b in points)
    old, new = read_datasets(path, 55), read_datasets(path, 2414)
    modes = [_mode_55(c) for c in old if _is_modal(c)] + [_mode_2414(c) for c in new if _is_mode(c)]
    forced = sum(not _is_modal(c) for c in (*old, *new))
    return Results(Geometry(points, tuple(lines), faces), tuple(_turned(mode, nodes) for mode in modes), forced)


def _turned(mode: NodeMode, nodes: Nodes) -> NodeMode:
    return replace(mode, at={node: nodes.turned(node, motion) for node, motion in mode.at.items()})


def _traced(contents: Iterable[Mapping[str, Any]]) -> Iterator[Edge]:
    """A trace goes from node to node; at a zero the pen is lifted."""
    for content in contents:
        nodes = [int(n) for n in content["nodes"]]
        yield from ((a, b) for a, b in pairwise(nodes) if a and b)


def _elements(content: Mapping[str, Any]) -> Iterator[tuple[int, list[int]]]:
    """Descriptor and nodes of each element."""
    for descriptor, elements in content.items():
        if isinstance(descriptor, int):
            for element in elements:
                yield descriptor, [int(n) for n in element["nodes_nums"]]


def _is_shell(descriptor: int, nodes: Sequence[int], points: Mapping[int, object]) -> bool:
    """Whether an element is a face: neither a rod or a beam nor a solid, all of its nodes known."""
    line = descriptor in _OPEN or descriptor >= FIRST_SOLID
    return not line and len(set(nodes)) > 2 and all(node in points for node in nodes)


def _edges(descriptor: int, nodes: list[int]) -> Iterator[Edge]:
    if descriptor in _SOLID_EDGES:
        yield from ((nodes[a], nodes[b]) for a, b in _SOLID_EDGES[descriptor] if max(a, b) < len(nodes))
        return
    yield from pairwise(nodes)
    if descriptor not in _OPEN and len(nodes) > 2:
        yield nodes[-1], nodes[0]


def _is_modal(content: Mapping[str, Any]) -> bool:
    return int(content["analysis_type"]) in (NORMAL, COMPLEX)


def _is_mode(content: Mapping[str, Any]) -> bool:
    return (
        _is_modal(content)
        and int(content["result_type"]) in MOTION
        and int(content["dataset_location"]) == AT_NODES
        and ("data_at_node" in content or "x" in content)
    )


def _mode_55(content: Mapping[str, Any]) -> NodeMode:
    if int(content["analysis_type"]) == NORMAL:
        frequency, damping = float(content["freq"]), _damping(content["modal_damp_vis"], content["modal_damp_his"])
        mass = float(content["modal_m"])
    else:
        pole = complex(content["eig"])
        frequency, damping = _of_pole(pole)
        # Modal A of a mode of mass m is 2 j omega_d m.
        mass = float((complex(content["modal_a"]) / (2j * pole.imag)).real) if pole.imag else 0.0
    parts = [np.asarray(content[name], np.complex128) for name in ("r1", "r2", "r3")]
    at = dict(zip((int(n) for n in content["node_nums"]), np.stack(parts, axis=1), strict=True))
    return NodeMode(_title(content), frequency, damping, at, mass)


def _mode_2414(content: Mapping[str, Any]) -> NodeMode:
    reals = [float(content[f"record12_field{k}"]) for k in range(1, 7)]
    if int(content["analysis_type"]) == NORMAL:
        frequency, damping, mass = reals[1], _damping(*reals[4:6]), reals[3]
    else:
        mass = 0.0
        more = [float(content[f"record13_field{k}"]) for k in range(1, 3)]
        frequency, damping = _of_pole(complex(*more) if any(more) else complex(reals[0], reals[1]))
    pairs = int(content["data_type"]) in PAIRS
    rows = np.array([_motion(row, pairs=pairs) for row in _rows(content)])
    at = dict(zip((int(n) for n in content["node_nums"]), rows, strict=True))
    name = str(content.get("analysis_dataset_name", "")).strip()
    return NodeMode(name or _title(content), frequency, damping, at, mass)


def _rows(content: Mapping[str, Any]) -> Sequence[Any]:
    if "data_at_node" in content:
        return content["data_at_node"]
    return list(np.stack([np.asarray(content[axis]) for axis in "xyz"], axis=1))


def _motion(row: Any, *, pairs: bool) -> NDArray[np.complex128]:
    """(3,) of real numbers or of pairs of real and imaginary parts; rotations may stand behind."""
    values = np.asarray(row)
    if pairs and not np.iscomplexobj(values):
        values = values[0::2] + 1j * values[1::2]
    return values[:3].astype(np.complex128)


def _damping(viscous: float, hysteretic: float) -> float:
    """The damping ratio of a normal mode: a hysteretic one dissipates at resonance as a viscous one of half of it."""
    return float(viscous) + float(hysteretic) / 2


def _of_pole(pole: complex) -> tuple[float, float]:
    return abs(pole) / (2 * np.pi), -pole.real / abs(pole) if pole else 0.0


def _title(content: Mapping[str, Any]) -> str:
    texts = (str(content[f"id{k}"]).strip() for k in range(1, 6))
    return next((text for text in texts if text and text != "NONE"), "mode")
