"""Results of a frequency step of CalculiX: the text file that ends in .frd.

Its layout is in the manual of CalculiX GraphiX (Wittig, "CalculiX USER'S MANUAL - CalculiX GraphiX", section "Result
Format"): lines of fixed columns, which a key begins. CalculiX scales real modes to unit modal mass.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from modallab.core.errors import DataError, FormatError
from modallab.formats.modes import NodeModes

_AGAIN = "write it as text, with *NODE FILE and U in the *FREQUENCY step"
_WIDTH = 12
"""Columns of a number."""
Rows = dict[int, tuple[float, ...]]


def read_calculix(path: Path) -> NodeModes:
    """Modes and nodes of such a file.

    Raises:
        FormatError: it is damaged, or binary.
        DataError: it holds no modes.
    """
    where = str(path)
    try:
        lines = path.read_text(encoding="ascii").splitlines()
    except UnicodeDecodeError as error:
        raise FormatError("is binary", where=where, remedy=_AGAIN) from error
    try:
        places = dict(_places(lines))
        modes = list(_modes(lines))
    except (ValueError, IndexError) as error:
        raise FormatError(f"is no whole result file of CalculiX: {error}", where=where, remedy=_AGAIN) from error
    if not modes:
        raise DataError("holds no modes", where=where, remedy="compute them: *FREQUENCY, with *NODE FILE and U")
    nodes = sorted(set.intersection(*(set(rows) for _, rows in modes)))
    hz = np.array([f for f, _ in modes])
    at = {n: np.array([rows[n][:3] for _, rows in modes]) for n in nodes}
    return NodeModes(path.stem, hz, at, places, np.full(hz.size, np.nan))


def _places(lines: Sequence[str]) -> Iterator[tuple[int, tuple[float, float, float]]]:
    for n, line in enumerate(lines):
        if line.startswith("    2C"):
            found = _rows(lines, n + 1, _digits(line))
            yield from ((node, (at[0], at[1], at[2])) for node, at in found.items())


def _modes(lines: Sequence[str]) -> Iterator[tuple[float, Rows]]:
    """Natural frequency and motions of each mode; a step of another kind says no mode."""
    square: float | None = None
    mode = False
    hz = 0.0
    digits = 10
    for n, line in enumerate(lines):
        key = line[:10].strip()
        if key.startswith("1PSTEP"):
            mode, square = False, None
        elif key.startswith("1PGK"):
            square = float(line[24:].split()[0])
        elif key.startswith("1PMODE"):
            mode = True
        elif line.startswith("  100C"):
            hz, digits = float(line[12:24]), _digits(line)
        elif mode and line.startswith(" -4  DISP "):
            # The generalised stiffness is that of a mode of unit mass.
            yield (hz if square is None else float(np.sqrt(max(square, 0.0))) / (2 * np.pi)), _rows(lines, n, digits)


def _digits(head: str) -> int:
    """Columns of a node's number, by the last number of the line that begins a block."""
    kind = int(head.split()[-1][0])
    if kind > 1:
        raise ValueError("a block is binary")
    return 10 if kind else 5


def _rows(lines: Sequence[str], first: int, digits: int) -> Rows:
    """Node -> numbers of the lines that begin with -1, up to the one that begins with -3."""
    found: Rows = {}
    for line in lines[first:]:
        if line.startswith(" -3"):
            return found
        if line.startswith(" -1"):
            numbers = line[3 + digits :].rstrip()
            row = tuple(float(numbers[k : k + _WIDTH]) for k in range(0, len(numbers), _WIDTH))
            if len(row) < 3:
                raise ValueError(f"a node has {len(row)} numbers")
            found[int(line[3 : 3 + digits])] = row
    raise ValueError("a block has no end")
