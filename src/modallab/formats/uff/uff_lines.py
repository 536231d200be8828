"""The lines of universal datasets as the format prescribes them: 15, 55, 58b, 82, 151 and 164."""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from modallab.core.block import Block

WIDTH = 80
Values = NDArray[np.float64] | NDArray[np.complex128]


def dataset(kind: int, lines: Sequence[str]) -> bytes:
    """A dataset of text between its marks."""
    return "\n".join(["    -1", f"{kind:6d}", *lines, "    -1", ""]).encode("ascii", errors="replace")


def binary_58(head: Sequence[str], axis: NDArray[np.float64] | None, values: Values) -> bytes:
    """Dataset 58b: eleven lines, then little-endian IEEE doubles; with an axis, each value follows its abscissa."""
    flat = np.ascontiguousarray(values).view(np.float64).reshape(len(values), -1)
    body = flat if axis is None else np.column_stack([axis, flat])
    raw = np.ascontiguousarray(body, dtype="<f8").tobytes()
    first = f"{58:6d}b{1:6d}{2:6d}{len(head):12d}{len(raw):12d}{0:6d}{0:6d}{0:12d}{0:12d}"
    text = "\n".join(["    -1", first, *head, ""]).encode("ascii", errors="replace")
    return text + raw + b"\n    -1\n"


def function_head(
    ids: Sequence[str],
    kind: int,
    response: tuple[str, int, int],
    reference: tuple[str, int, int],
    form: tuple[int, int, float, float] | tuple[int, int],
    labels: Sequence[tuple[int, str, str]],
) -> list[str]:
    """The eleven lines of a function.

    Args:
        ids: five lines.
        kind: function type.
        response: entity name, node and direction.
        reference: the same of the excitation.
        form: ordinates' type and their number; for an even abscissa also its start and step.
        labels: specific type, label and unit of abscissa, ordinate, its denominator and z.
    """
    even = len(form) == 4
    start, step = (form[2], form[3]) if len(form) == 4 else (0.0, 0.0)
    where = f"{kind:5d}{0:10d}{0:5d}{0:10d} {response[0]:<10.10}{response[1]:10d}{response[2]:4d}"
    where += f" {reference[0]:<10.10}{reference[1]:10d}{reference[2]:4d}"
    shape = f"{form[0]:10d}{form[1]:10d}{int(even):10d}{start:13.5E}{step:13.5E}{0:13.5E}"
    axes = [f"{special:10d}{0:5d}{0:5d}{0:5d} {label:<20.20} {unit:<20.20}" for special, label, unit in labels]
    return [*(line[:WIDTH] or "NONE" for line in ids), where, shape, *axes]


def header_151(name: str, program: str, moment: str) -> bytes:
    """Dataset 151: whose file this is. `moment` is a date and a time, as 21-Nov-26 and 17:30:00."""
    return dataset(
        151, [name[:WIDTH] or "NONE", "modal test", program[:WIDTH], moment, moment, program[:WIDTH], moment]
    )


def units_164() -> bytes:
    """Dataset 164: SI."""
    factors = "".join(f"{value:25.17E}".replace("E", "D") for value in (1.0, 1.0, 1.0))
    return dataset(164, [f"{1:10d}{'SI: Meter (newton)':<20}{2:10d}", factors, f"{273.15:25.17E}".replace("E", "D")])


def nodes_15(points: Sequence[tuple[int, float, float, float]]) -> bytes:
    """Dataset 15: points by number, x, y and z in m."""
    return dataset(15, [f"{n:10d}{0:10d}{0:10d}{0:10d}{x:13.5E}{y:13.5E}{z:13.5E}" for n, x, y, z in points])


def traces_82(lines: Sequence[tuple[int, int]]) -> bytes:
    """Dataset 82: pairs of nodes that are joined, as one trace that lifts its pen between them."""
    nodes = [n for pair in lines for n in (*pair, 0)][:-1]
    rows = [_ints(*nodes[k : k + 8]) for k in range(0, len(nodes), 8)]
    return dataset(82, [_ints(1, len(nodes), 1), "lines of the rig", *rows])


def shape_55(
    ids: Sequence[str], mode: int, pole: complex, mass: float, shape: dict[int, NDArray[np.complex128]]
) -> bytes:
    """Dataset 55: one mode shape, of real or of complex numbers.

    Args:
        ids: five lines.
        mode: its number, from 1.
        pole: in rad/s.
        mass: modal mass in kg.
        shape: node -> (3,) displacement.
    """
    frequency, damping = abs(pole) / (2 * np.pi), -pole.real / abs(pole)
    is_real = all(not value.imag.any() for value in shape.values())
    if is_real:
        head = [_ints(1, 2, 2, 8, 2, 3), _ints(2, 4, 0, mode), _reals([frequency, mass, damping, 0.0])]
    else:
        # Modal A of a mode of unit mass is 2 j omega_d, modal B is -A times the pole.
        modal_a = 2j * pole.imag * mass
        parts = [pole, modal_a, -modal_a * pole]
        head = [_ints(1, 3, 2, 8, 5, 3), _ints(2, 6, 0, mode), _reals([p for z in parts for p in (z.real, z.imag)])]
    body = [line for node, value in shape.items() for line in (_ints(node), _reals(_plain(value, is_real)))]
    return dataset(55, [*(line[:WIDTH] or "NONE" for line in ids), *head, *body])


def _plain(value: NDArray[np.complex128], is_real: bool) -> list[float]:
    return [float(v.real) for v in value] if is_real else [p for v in value for p in (float(v.real), float(v.imag))]


def _ints(*numbers: int) -> str:
    return "".join(f"{number:10d}" for number in numbers)


def _reals(numbers: Sequence[float]) -> str:
    return "".join(f"{number:13.5E}" for number in numbers)


def axis_of(direction: str) -> int:
    """1, 2, 3 for x, y, z, negative for the other sense."""
    number = "xyz".index(direction[1]) + 1
    return number if direction[0] == "+" else -number


def physical(block: Block) -> Iterator[NDArray[np.float64]]:
    """The rows of a block in its units, as real numbers."""
    for row, scale in zip(block.samples, block.scale, strict=True):
        yield np.ascontiguousarray(row, dtype=np.float64) * scale
