"""Universal files: records, FRFs, places and modes."""

import json
from pathlib import Path

import numpy as np
from known import (
    DISPLACEMENT,
    MODES,
    RATE,
    VELOCITY,
    G,
    Known,
    KnownFrf,
    Record,
    case,
    hit,
    inertance,
    moved,
    receptance,
)
from uff_written import (
    ACCELERATION,
    FORCE,
    INCH,
    MILLIMETRE,
    SI,
    Function,
    binary_58,
    cut,
    header_151,
    nodes_15,
    nodes_2411,
    save,
    shapes_55,
    text_58,
    units_164,
)
from uff_written import DISPLACEMENT as DISPLACED
from uff_written import VELOCITY as MOVING

LINES = np.arange(20.0, 220.0, 0.5)
NODES = ((1, 3), (1, 3), (2, 3))


def functions(record: Record, units: tuple[str, ...] = ("N", "m/s^2", "m/s^2"), **more: object) -> list[Function]:
    kinds = (FORCE, ACCELERATION, ACCELERATION)
    return [
        Function(row, 1 / record.rate, response=node, ordinate=(kind, unit), **more)
        for row, node, kind, unit in zip(record.rows, NODES, kinds, units, strict=True)
    ]


def frfs(
    values: np.ndarray, lines: np.ndarray | None = LINES, kind: int = ACCELERATION, unit: str = "m/s^2", **more: object
) -> list[Function]:
    even = {"step": 0.5, "first": 20.0} if lines is LINES else {"step": 0.0, "lines": lines}
    common = {"kind": 4, "reference": (1, 3), "ordinate": (kind, unit), "denominator": (FORCE, "N")} | even | more
    return [Function(h, response=(k, 3), **common) for k, h in enumerate(values, start=1)]


@case("uff")
def single_precision(folder: Path) -> Known:
    """Datasets 151, 164 and 58, 6E13.5; 2048 Hz, of which a step has six digits."""
    record = hit(rate=2048.0)
    return Known(save(folder, header_151() + units_164(SI) + text_58(functions(record))), (record,))


@case("uff")
def double_precision_crlf(folder: Path) -> Known:
    """4E20.12, CR LF, blanks to column 80."""
    lines = [f"{line:<80s}" for line in text_58(functions(hit(), double=True))]
    return Known(save(folder, lines, "\r\n"), (hit(),))


@case("uff")
def exponents_of_fortran(folder: Path) -> Known:
    """Exponents with d, numbers without the leading zero."""
    lines = []
    for line in text_58(functions(hit(), double=True)):
        is_numbers = len(line) == 80 and "E" in line and "NONE" not in line
        lines.append(line.replace("E+", "d+").replace("E-", "d-") if is_numbers else line)
    return Known(save(folder, lines), (hit(),))


@case("uff")
def binary_big_double(folder: Path) -> Known:
    """58b, most significant byte first, double precision."""
    data = b"".join(binary_58(f, big=True) for f in functions(hit(), double=True))
    return Known(save(folder, data), (hit(),))


@case("uff")
def binary_cut(folder: Path) -> Known:
    """58b cut off in the last function."""
    data = b"".join(binary_58(f) for f in functions(hit()))
    return Known(save(folder, cut(data, 0.9)), rejected="(?i)cut|bytes|end|damaged")


@case("uff")
def inches_without_labels(folder: Path) -> Known:
    """Dataset 164 says inch and pound; the functions have no labels."""
    record = hit()
    scaled = Record(record.force * 0.22480894309971047, record.a1 / 0.0254, record.a2 / 0.0254)
    lines = units_164(INCH) + text_58(functions(scaled, ("NONE",) * 3))
    return Known(save(folder, lines), (record,))


@case("uff")
def labels_before_units(folder: Path) -> Known:
    """Dataset 164 says inch and pound, labels say N and g: labels are of the axis itself."""
    record = hit()
    scaled = Record(record.force, record.a1 / G, record.a2 / G)
    return Known(save(folder, units_164(SI) + text_58(functions(scaled, ("N", "g", "g")))), (record,))


@case("uff")
def later_channels(folder: Path) -> Known:
    """The abscissa's minimum of each channel: 0, 4 and 7 samples."""
    rows, right = moved(hit(), (0, 4, 7))
    parts = [
        Function(r, 1 / RATE, k / RATE, response=n, ordinate=(t, u))
        for r, k, n, t, u in zip(
            rows, (0, 4, 7), NODES, (FORCE, ACCELERATION, ACCELERATION), ("N", "m/s^2", "m/s^2"), strict=True
        )
    ]
    return Known(save(folder, text_58(parts)), (right,))


@case("uff")
def against_the_axis(folder: Path) -> Known:
    """The second response points along -Z: it is turned."""
    record = hit()
    parts = functions(Record(record.force, record.a1, -record.a2))
    last = Function(parts[2].values, 1 / RATE, response=(2, -3), ordinate=(ACCELERATION, "m/s^2"))
    return Known(save(folder, text_58([*parts[:2], last])), (record,))


@case("uff")
def two_hits(folder: Path) -> Known:
    """Two hits after each other, channels in another order in the second."""
    one, two = functions(hit(1)), functions(hit(2))
    return Known(save(folder, text_58([*one, two[2], two[0], two[1]])), (hit(1), hit(2)))


@case("uff")
def velocities(folder: Path) -> Known:
    """Velocities in mm/s by label."""
    record = hit(derivatives=1)
    rows = [Function(record.force, 1 / RATE, ordinate=(FORCE, "N"))]
    rows += [
        Function(1e3 * v, 1 / RATE, response=(k, 3), ordinate=(MOVING, "mm/s"))
        for k, v in ((1, record.a1), (2, record.a2))
    ]
    return Known(save(folder, text_58(rows)), (record,), rig=VELOCITY)


@case("uff")
def uneven_double_complex(folder: Path) -> Known:
    """FRFs at lines on a log scale: E13.5, 2E20.12."""
    lines = np.geomspace(20, 200, 200)
    right = KnownFrf(lines, inertance(lines)[:, 0])
    return Known(save(folder, text_58(frfs(right.values, lines, double=True))), frf=right, tolerance=5e-5)


@case("uff")
def binary_complex(folder: Path) -> Known:
    """58b, complex single precision, inertance in g/N."""
    right = KnownFrf(LINES, inertance(LINES)[:, 0])
    data = b"".join(binary_58(f) for f in frfs(right.values / G, unit="g"))
    return Known(save(folder, data), frf=right)


@case("uff")
def receptance_millimetres(folder: Path) -> Known:
    """Receptances in mm/N, a rig of displacements."""
    right = KnownFrf(LINES, receptance(LINES)[:, 0], "receptance")
    return Known(
        save(folder, text_58(frfs(1e3 * right.values, kind=DISPLACED, unit="mm"))), frf=right, rig=DISPLACEMENT
    )


@case("uff")
def force_against_the_axis(folder: Path) -> Known:
    """The force points along -Z, the responses along +Z: FRFs are turned."""
    right = KnownFrf(LINES, inertance(LINES)[:, 0])
    return Known(save(folder, text_58(frfs(-right.values, reference=(1, -3)))), frf=right)


@case("uff")
def with_spectra_and_coherence(folder: Path) -> Known:
    """FRFs beside coherences, auto spectra, and a dataset that nobody knows."""
    c = 1 - 0.01 * np.exp(-LINES / 100)
    right = KnownFrf(LINES, inertance(LINES)[:, 0], coherence=np.array([c, c]))
    spectrum = Function(np.abs(right.values[0]) ** 2, 0.5, 20.0, 2, (1, 3), (1, 3), ordinate=(ACCELERATION, "m/s^2"))
    quality = [Function(c, 0.5, 20.0, 6, (k, 3), (1, 3), ordinate=(1, "NONE")) for k in (1, 2)]
    other = ["    -1", "  1858", "         1         2", "  0.1 0.2", "    -1"]
    return Known(save(folder, other + text_58([*frfs(right.values), spectrum, *quality])), frf=right)


@case("uff")
def complex_modes(folder: Path) -> Known:
    """Datasets 2411 in mm and 55 with complex eigenvalues, no rig."""
    places = [(1, 100.0, 0.0, 0.0), (2, 300.0, 50.0, 0.0)]
    lines = units_164(MILLIMETRE) + nodes_2411(places)
    for number, (f0, zeta, shape) in enumerate(MODES, start=1):
        w = 2 * np.pi * f0
        facts = (-zeta * w, w * np.sqrt(1 - zeta**2), 0.0, 2 * w, 0.0, 0.0)
        lines += shapes_55(number, facts, {k: (0j, 0j, complex(v)) for k, v in enumerate(shape, start=1)})
    return Known(save(folder, lines), rig=None, options=(), check=modes_right)


@case("uff")
def normal_modes_six_values(folder: Path) -> Known:
    """Datasets 15 in m and 55 with normal modes, six values a node."""
    lines = nodes_15([(1, 0.1, 0.0, 0.0), (2, 0.3, 0.05, 0.0)])
    for number, (f0, zeta, shape) in enumerate(MODES, start=1):
        vectors = {k: (0, 0, complex(v), 0, 0, 0) for k, v in enumerate(shape, start=1)}
        lines += shapes_55(number, (f0, 1.0, zeta, 0.0), vectors, 6)
    return Known(save(folder, lines), rig=None, options=(), check=modes_right)


def modes_right(folder: Path) -> str:
    """What is wrong with the frequencies, damping ratios, shapes and places that were written."""
    found = json.loads((folder / "out.json").read_text(encoding="utf-8"))
    f, zeta = (np.array([m[k] for m in found["modes"]]) for k in ("frequency_hz", "damping_ratio"))
    if not np.allclose(f, [m[0] for m in MODES], rtol=1e-5) or not np.allclose(zeta, [m[1] for m in MODES], rtol=1e-4):
        return f"frequencies {f}, damping {zeta}"
    for mode, (_, _, shape) in zip(found["modes"], MODES, strict=True):
        if not np.allclose([mode["shape"][k][2] for k in "12"], [(v, 0) for v in shape]):
            return f"shape {mode['shape']}"
    places = [[p[k] for k in ("x_m", "y_m", "z_m")] for p in found["points"]]
    return "" if np.allclose(places, [[0.1, 0, 0], [0.3, 0.05, 0]]) else f"places {places}"
