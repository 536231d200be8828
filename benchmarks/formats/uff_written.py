"""Universal files, column by column after the description of datasets 15, 55, 58, 58b, 151, 164 and 2411."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

EDGE = "    -1"
SI = (1, "SI: Meter (newton)", 1.0, 1.0)
INCH = (7, "IN: Inch (pound f)", 39.37007874015748, 0.22480894309971047)
MILLIMETRE = (5, "MM: mm (milli-newton)", 1000.0, 1000.0)
FORCE, DISPLACEMENT, VELOCITY, ACCELERATION, TIME, FREQUENCY = 13, 8, 11, 12, 17, 18


@dataclass(frozen=True)
class Function:
    """What a dataset 58 holds. Nodes and directions are of the response and of the reference."""

    values: np.ndarray
    step: float
    first: float = 0.0
    kind: int = 1
    response: tuple[int, int] = (1, 3)
    reference: tuple[int, int] = (0, 0)
    name: str = "NONE"
    ordinate: tuple[int, str] = (ACCELERATION, "NONE")
    denominator: tuple[int, str] = (0, "NONE")
    double: bool = False
    lines: np.ndarray | None = None

    @property
    def type_number(self) -> int:
        return (5 if np.iscomplexobj(self.values) else 2) + (1 if np.iscomplexobj(self.values) else 2) * self.double


def axis(kind: int, label: str, unit: str) -> str:
    return f"{kind:10d}{0:5d}{0:5d}{0:5d} {label:<20.20s} {unit:<20.20s}"


def function_head(f: Function) -> list[str]:
    """The eleven records above the numbers."""
    lines = ["one function of a case", "NONE", "29-Mar-26 10:00:00", "NONE", "NONE"]
    names = (
        f" {f.name:<10.10s}{f.response[0]:10d}{f.response[1]:4d} {'NONE':<10s}{f.reference[0]:10d}{f.reference[1]:4d}"
    )
    lines.append(f"{f.kind:5d}{0:10d}{0:5d}{0:10d}{names}")
    even = int(f.lines is None)
    lines.append(
        f"{f.type_number:10d}{len(f.values):10d}{even:10d}{f.first:13.5E}{f.step if even else 0:13.5E}{0:13.5E}"
    )
    spectral = f.kind != 1
    lines.append(axis(FREQUENCY if spectral else TIME, "Frequency" if spectral else "Time", "Hz" if spectral else "s"))
    lines.append(axis(f.ordinate[0], "NONE", f.ordinate[1]))
    return [*lines, axis(f.denominator[0], "NONE", f.denominator[1]), axis(0, "NONE", "NONE")]


def parts_of(f: Function) -> np.ndarray:
    """(points, numbers of a point): the abscissa where it is uneven, real, imaginary."""
    columns = [f.values.real, f.values.imag] if np.iscomplexobj(f.values) else [f.values]
    return np.array([*([f.lines] if f.lines is not None else []), *columns]).T


def numbers(f: Function) -> list[str]:
    """As 6E13.5 or 4E20.12; uneven doubles as E13.5 and E20.12."""
    rows = parts_of(f)
    if f.double and f.lines is not None:
        pairs = rows.reshape(-1, 4 if rows.shape[1] == 2 else 3)
        widths = ["13.5E", "20.12E"] * 2 if rows.shape[1] == 2 else ["13.5E", "20.12E", "20.12E"]
        return ["".join(f"{v:{w}}" for v, w in zip(row, widths, strict=True)) for row in pairs]
    form, each = ("20.12E", 4) if f.double else ("13.5E", 6)
    flat = rows.ravel()
    return ["".join(f"{v:{form}}" for v in flat[k : k + each]) for k in range(0, len(flat), each)]


def text_58(functions: Sequence[Function]) -> list[str]:
    return [line for f in functions for line in (EDGE, "    58", *function_head(f), *numbers(f), EDGE)]


def binary_58(f: Function, big: bool = False) -> bytes:
    body = parts_of(f).astype((">" if big else "<") + ("f8" if f.double else "f4")).tobytes()
    head = f"{58:6d}b{2 if big else 1:6d}{2:6d}{11:12d}{len(body):12d}{0:6d}{0:6d}{0:12d}{0:12d}"
    return "\n".join([EDGE, head, *function_head(f), ""]).encode() + body + f"\n{EDGE}\n".encode()


def header_151() -> list[str]:
    lines = ["model", "a case", "somebody", "29-Mar-26 10:00:00         1         1         0", "29-Mar-26 10:00:00"]
    return [EDGE, "   151", *lines, "a program", "29-Mar-26 10:00:00", EDGE]


def units_164(system: tuple[int, str, float, float]) -> list[str]:
    code, words, length, force = system
    row = "".join(f"{v:25.16E}".replace("E", "D") for v in (length, force, 1.0))
    return [EDGE, "   164", f"{code:10d}{words:<20.20s}{2:10d}", row, f"{273.15:25.16E}".replace("E", "D"), EDGE]


def nodes_15(places: Sequence[tuple[int, float, float, float]]) -> list[str]:
    rows = [f"{n:10d}{0:10d}{0:10d}{8:10d}" + "".join(f"{v:13.5E}" for v in xyz) for n, *xyz in places]
    return [EDGE, "    15", *rows, EDGE]


def nodes_2411(places: Sequence[tuple[int, float, float, float]]) -> list[str]:
    rows = []
    for n, *xyz in places:
        rows += [f"{n:10d}{1:10d}{1:10d}{11:10d}", "".join(f"{v:25.16E}".replace("E", "D") for v in xyz)]
    return [EDGE, "  2411", *rows, EDGE]


def shapes_55(number: int, facts: Sequence[float], shape: dict[int, Sequence[complex]], values: int = 3) -> list[str]:
    """Complex eigenvalue (six facts) or normal mode (four facts), by nodes."""
    is_complex = len(facts) == 6
    lines = ["mode", "NONE", "29-Mar-26", "NONE", "NONE"]
    lines.append(
        "".join(
            f"{v:10d}" for v in (1, 3 if is_complex else 2, 2 if values == 3 else 3, 8, 5 if is_complex else 2, values)
        )
    )
    lines.append("".join(f"{v:10d}" for v in (2, len(facts), 0, number)))
    lines.append("".join(f"{v:13.5E}" for v in facts))
    for node, vector in shape.items():
        flat = [p for v in vector for p in ((v.real, v.imag) if is_complex else (v.real,))]
        lines += [f"{node:10d}", "".join(f"{v:13.5E}" for v in flat)]
    return [EDGE, "    55", *lines, EDGE]


def save(folder: Path, content: list[str] | bytes, ending: str = "\n") -> tuple[str, ...]:
    data = content if isinstance(content, bytes) else (ending.join(content) + ending).encode()
    (folder / "case.uff").write_bytes(data)
    return ("case.uff",)


def cut(data: bytes, share: float) -> bytes:
    return data[: int(len(data) * share)]
