"""A cantilever of beam elements: matrices, and the files that finite-element programs write of its modes."""

from pathlib import Path

import numpy as np
from scipy.linalg import eigh

ROOTS = np.array([1.8751041, 4.6940911, 7.8547574])
"""cos b cosh b = -1: the cantilever's, by closed form."""


def beam(
    ei: float, per_m: float, length: float, elements: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """K, M, freedoms (node, direction: z and about y) and nodes (id, x, y, z), clamped at x = 0.

    Cubic elements with their consistent mass (Przemieniecki, Theory of Matrix Structural Analysis, 1968, ch. 11).
    """
    h, n = length / elements, 2 * (elements + 1)
    one_k = ei / h**3 * np.array([[12, 6 * h, -12, 6 * h], [6 * h, 4 * h**2, -6 * h, 2 * h**2],
                                  [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h**2, -6 * h, 4 * h**2]])  # fmt: skip
    one_m = per_m * h / 420 * np.array([[156, 22 * h, 54, -13 * h], [22 * h, 4 * h**2, 13 * h, -3 * h**2],
                                        [54, 13 * h, 156, -22 * h],
                                        [-13 * h, -3 * h**2, -22 * h, 4 * h**2]])  # fmt: skip
    k, m = np.zeros((n, n)), np.zeros((n, n))
    for e in range(elements):
        rows = slice(2 * e, 2 * e + 4)
        k[rows, rows] += one_k
        m[rows, rows] += one_m
    freedoms = np.array([(node, direction) for node in range(elements + 1) for direction in (3, 5)])[2:]
    nodes = np.array([(node, node * h, 0.0, 0.0) for node in range(1, elements + 1)])
    return k[2:, 2:], m[2:, 2:], freedoms, nodes


def modes(k: np.ndarray, m: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """(count,) eigenvalues and (nodes, count) deflections at unit modal mass."""
    squares, vectors = eigh(k, m, subset_by_index=(0, count - 1))
    return squares, vectors[::2]


def closed_form(ei: float, per_m: float, length: float) -> np.ndarray:
    """Natural frequencies in Hz (Blevins, Formulas for Dynamics, Acoustics and Vibration, 2016)."""
    return ROOTS**2 / (2 * np.pi) * np.sqrt(ei / (per_m * length**4))


def frd(nodes: np.ndarray, squares: np.ndarray, deflections: np.ndarray) -> str:
    """As CalculiX writes a *FREQUENCY step, with a static step before it."""
    count = len(nodes)
    text = ["    1C", f"    2C{count:30d}{'':37s}1"]
    text += [f" -1{int(i):10d}" + "".join(f"{v:12.5E}" for v in at) for i, *at in nodes] + [" -3"]
    still = np.ones(count)
    text += ["    1PSTEP                         1           1           1"]
    text += _block(nodes, still, "  100CL  101 1.000000000" + f"{count:12d}" + " " * 21 + "1           1")
    for mode, (square, shape) in enumerate(zip(squares, deflections.T, strict=True), start=1):
        hz = np.sqrt(square) / (2 * np.pi)
        text += [
            f"    1PSTEP            {mode + 1:14d}{mode:12d}{2:12d}",
            f"    1PGM                {1.0:12.6E}",
            f"    1PGK                {square:12.6E}",
            f"    1PHID               {-1:14d}",
            "    1PSUBC                             0",
            f"    1PMODE              {mode:14d}",
        ]
        text += _block(
            nodes, shape, f"  100CL{101 + mode:5d}{hz:12.5E}{count:12d}" + " " * 21 + "2           1MODAL      1"
        )
    return "\n".join([*text, " 9999", ""])


def _block(nodes: np.ndarray, shape: np.ndarray, head: str) -> list[str]:
    parts = [" -4  DISP        4    1", *(f" -5  D{k}          1    2    {k}    0" for k in (1, 2, 3))]
    rows = [f" -1{int(i):10d}{0.0:12.5E}{0.0:12.5E}{w:12.5E}" for i, w in zip(nodes[:, 0], shape, strict=True)]
    return [head, *parts, " -5  ALL         1    2    0    0    1ALL", *rows, " -3"]


def pch(nodes: np.ndarray, squares: np.ndarray, deflections: np.ndarray) -> str:
    """As Nastran punches eigenvectors; columns 73 to 80 count the lines."""
    text: list[str] = []
    for mode, (square, shape) in enumerate(zip(squares, deflections.T, strict=True), start=1):
        head = (
            "$TITLE   = BEAM",
            "$SUBTITLE=",
            "$LABEL   =",
            "$EIGENVECTOR",
            "$REAL OUTPUT",
            "$SUBCASE ID =           1",
        )
        text += [*head, f"$EIGENVALUE = {square:14.7E}  MODE = {mode:5d}"]
        for i, w in zip(nodes[:, 0], shape, strict=True):
            text += [
                f"{int(i):10d}       G{0.0:18.6E}{0.0:18.6E}{w:18.6E}",
                f"-CONT-{'':12s}{0.0:18.6E}{0.0:18.6E}{0.0:18.6E}",
            ]
    return "".join(f"{line:72s}{n:8d}\n" for n, line in enumerate(text, start=1))


def f06(nodes: np.ndarray, squares: np.ndarray, deflections: np.ndarray, mass: float) -> str:
    """As Nastran prints them, scaled so that every mode has this mass."""
    text = [
        "1    BEAM    PAGE     1",
        "",
        f"{'':46s}R E A L   E I G E N V A L U E S",
        "   MODE    EXTRACTION      EIGENVALUE",
    ]
    for mode, square in enumerate(squares, start=1):
        omega = np.sqrt(square)
        numbers = (square, omega, omega / (2 * np.pi), mass, mass * square)
        text.append(f"{mode:9d}{mode:10d}" + "".join(f"{v:20.6E}" for v in numbers))
    for mode, (square, shape) in enumerate(zip(squares, deflections.T, strict=True), start=1):
        text += [f"1    BEAM    PAGE     {mode + 1}", f"      EIGENVALUE = {square:13.6E}"]
        text += [
            f"          CYCLES = {np.sqrt(square) / 6.2831853:13.6E}         "
            f"R E A L   E I G E N V E C T O R   N O .{mode:11d}"
        ]
        text += [
            "",
            "      POINT ID.   TYPE          T1             T2             T3             R1             R2",
        ]
        for i, w in zip(nodes[:, 0], shape * np.sqrt(mass), strict=True):
            text.append(f"{int(i):14d}      G " + "".join(f"{v:15.6E}" for v in (0.0, 0.0, w, 0.0, 0.0, 0.0)))
    return "\n".join([*text, ""])


def bdf(nodes: np.ndarray) -> str:
    """The grid points: of eight columns, of sixteen, between commas."""
    text: list[str] = ["BEGIN BULK"]
    for n, (i, x, y, z) in enumerate(nodes.tolist()):
        if n % 3 == 0:
            text.append(f"GRID    {int(i):8d}{'':8s}{x:8.5f}{y:8.5f}{z:8.5f}")
        elif n % 3 == 1:
            text += [f"GRID*   {int(i):16d}{0:16d}{x:16.9f}{y:16.9f}", f"*       {z:16.9f}"]
        else:
            text.append(f"GRID,{int(i)},,{x:.7f},{y},{z}")
    return "\n".join([*text, "ENDDATA", ""])


def written(folder: Path, name: str, text: str) -> Path:
    """The path of a text that was written."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path
