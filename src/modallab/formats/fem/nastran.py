"""Real eigenvectors as Nastran prints (.f06) and punches them (.pch).

Sources: MSC Nastran Quick Reference Guide, case control DISPLACEMENT and EIGRL. Eigenvectors are scaled to unit modal
mass unless the EIGRL entry says otherwise; a printed file says what the modal mass is, and it is divided by then.
"""

import re
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from modallab.core.errors import DataError, FormatError
from modallab.formats.modes import NodeModes

_MODEL_ENDINGS = (".bdf", ".dat", ".nas")
_DO = "ask for them: DISPLACEMENT(PRINT,PUNCH) = ALL in the case control of SOL 103"
_NUMBER = r"[-+]?\d+\.\d*(?:[EeDd]?[-+]?\d+)?"
_PRINTED = re.compile(rf"^\s*(\d+)\s+G\s+({_NUMBER})\s+({_NUMBER})\s+({_NUMBER})\s")
_TABLE = re.compile(rf"^\s*(\d+)\s+\d+\s+({_NUMBER})\s+{_NUMBER}\s+{_NUMBER}\s+({_NUMBER})\s+{_NUMBER}\s*$")
_HEAD = re.compile(r"R E A L   E I G E N V E C T O R   N O \.\s+(\d+)")
Motions = dict[int, dict[int, tuple[float, float, float]]]
"""Mode -> node -> motion."""


def read_nastran(path: Path) -> NodeModes:
    """Modes of a printed or punched file; grid points from the model beside it, if there is one.

    Raises:
        FormatError: it is no text.
        DataError: it holds no real eigenvectors, or grid points in another coordinate system than the basic one.
    """
    try:
        lines = path.read_text(encoding="latin-1").splitlines()
        squares, motions, masses = _punched(lines) if path.suffix.lower() == ".pch" else _printed(lines)
    except ValueError as error:
        raise FormatError(f"is damaged: {error}", where=str(path), remedy="write it again") from error
    order = sorted(set(motions) & set(squares), key=lambda mode: squares[mode])
    if not order:
        raise DataError("holds no real eigenvectors", where=str(path), remedy=_DO)
    nodes = sorted(set.intersection(*(set(motions[mode]) for mode in order)))
    scale = np.array([1 / np.sqrt(masses.get(mode, 1.0)) for mode in order])
    hz = np.sqrt(np.maximum([squares[mode] for mode in order], 0.0)) / (2 * np.pi)
    at = {n: scale[:, None] * np.array([motions[mode][n] for mode in order]) for n in nodes}
    return NodeModes(path.stem, hz, at, read_grids(path), np.full(len(order), np.nan))


def number(text: str) -> float:
    """A number as Nastran writes it, whose exponent may have no letter: 1.5-3.

    Raises:
        ValueError: it is none.
    """
    plain = text.strip().upper().replace("D", "E")
    return float(re.sub(r"(?<=[\d.])([-+]\d+)$", r"E\1", plain) if "E" not in plain else plain)


def _printed(lines: Iterable[str]) -> tuple[dict[int, float], Motions, dict[int, float]]:
    squares: dict[int, float] = {}
    masses: dict[int, float] = {}
    motions: Motions = {}
    mode: int | None = None
    table = False
    for line in lines:
        if line.startswith("1") or "R E A L   E I G E N V A L U E S" in line:
            # A page: what follows belongs to the vector of its own head.
            mode, table = None, "E I G E N V A L U E S" in line
        if head := _HEAD.search(line):
            mode, table = int(head[1]), False
        elif table and (row := _TABLE.match(line)):
            squares[int(row[1])], masses[int(row[1])] = number(row[2]), number(row[3])
        elif mode is not None and (row := _PRINTED.match(line)):
            motions.setdefault(mode, {})[int(row[1])] = (number(row[2]), number(row[3]), number(row[4]))
    return squares, motions, {mode: m for mode, m in masses.items() if m > 0}


def _punched(lines: Iterable[str]) -> tuple[dict[int, float], Motions, dict[int, float]]:
    squares: dict[int, float] = {}
    motions: Motions = {}
    for mode, square, node, motion in _punched_rows(lines):
        squares[mode] = square
        motions.setdefault(mode, {})[node] = motion
    return squares, motions, {}


def _punched_rows(lines: Iterable[str]) -> Iterator[tuple[int, float, int, tuple[float, float, float]]]:
    """Mode, eigenvalue, node and motion; columns 73 to 80 count the lines."""
    here, vectors = (0, 0.0), False
    for line in (text[:72] for text in lines):
        if line.startswith("$EIGENVALUE") and vectors:
            value, _, mode = line.partition("=")[2].partition("MODE")
            here = (int(mode.replace("=", " ").split()[0]), number(value))
        elif line.startswith("$"):
            # Every block says after its title what it is of, and whether that is real.
            if line.startswith(("$EIGENVECTOR", "$DISPLACEMENTS")):
                vectors = True
            elif line.startswith(("$TITLE", "$REAL-IMAGINARY", "$MAGNITUDE-PHASE")):
                vectors = False
        elif vectors and line[17:18] == "G" and here[0]:
            yield here[0], here[1], int(line[:10]), (number(line[18:36]), number(line[36:54]), number(line[54:72]))


def read_grids(results: Path) -> dict[int, tuple[float, float, float]]:
    """Node -> x, y, z in the model's unit of length, from the model that is called like its results; {} if none is.

    Raises:
        DataError: a grid point is given in another coordinate system than the basic one.
    """
    model = next((results.with_suffix(end) for end in _MODEL_ENDINGS if results.with_suffix(end).exists()), None)
    if model is None:
        return {}
    found: dict[int, tuple[float, float, float]] = {}
    for fields in _grids(model.read_text(encoding="latin-1").splitlines()):
        if fields[2].strip() not in ("", "0"):
            raise DataError(
                f"grid point {fields[1].strip()} is in coordinate system {fields[2].strip()}",
                where=str(model),
                remedy="give grid points in the basic system, or leave the model out: nodes are matched by number then",
            )
        x, y, z = (number(text) if text.strip() else 0.0 for text in fields[3:6])
        found[int(fields[1])] = (x, y, z)
    return found


def _grids(lines: list[str]) -> Iterator[list[str]]:
    """Fields of each GRID entry: of eight columns, of sixteen over two lines (GRID*), or between commas."""
    for n, line in enumerate(lines):
        entry = line.partition("$")[0]
        if not entry.upper().startswith("GRID") or entry[4:5] not in (" ", "*", ","):
            continue
        if "," in entry:
            fields = entry.split(",")
        elif entry[4] == "*":
            more = lines[n + 1] if n + 1 < len(lines) else ""
            fields = [entry[:8], *(part[k : k + 16] for part in (entry, more) for k in range(8, 72, 16))]
        else:
            fields = [entry[k : k + 8] for k in range(0, 72, 8)]
        yield [*fields, *[""] * 6]
