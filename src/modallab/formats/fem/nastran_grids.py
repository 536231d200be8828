"""Grid points of a Nastran model, which its results do not hold."""

from collections.abc import Iterator
from pathlib import Path

from modallab.core.errors import DataError

ENDINGS = (".bdf", ".dat", ".nas")


def read_grids(results: Path) -> dict[int, tuple[float, float, float]]:
    """Node -> x, y, z in the model's unit of length, from the model that is called like its results; {} if none is.

    Raises:
        DataError: a grid point is given in another coordinate system than the basic one.
    """
    model = next((results.with_suffix(end) for end in ENDINGS if results.with_suffix(end).exists()), None)
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
        x, y, z = (_number(text) for text in fields[3:6])
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


def _number(text: str) -> float:
    from modallab.formats.fem.nastran import number

    return number(text) if text.strip() else 0.0
