"""One number syntax for all datasets of universal files, and one tolerance for what programs make of the standard."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from exchange_records import receptances, uff_set, write_uff
from exchange_rigs import beam_rig

from modallab.core.errors import FormatError
from modallab.formats.importer import import_sources
from modallab.formats.uff.uff_numbers import numbers
from modallab.formats.uff.uff_results import read_results

RIG = beam_rig()
N = 65
LINES = np.arange(1.0, N + 1)


def frfs(path: Path, *, binary: bool = False, even: bool = True) -> Path:
    fields = {"ordinate_spec_data_type": 8, "ordinate_axis_units_lab": "m", "abscissa_spacing": int(even)}
    sets = [
        uff_set(v, LINES, 4, rsp_node=k, rsp_dir=3, ref_node=2, ref_dir=3, **fields)
        for k, v in enumerate(receptances(N), start=1)
    ]
    return write_uff(path, *sets, binary=binary)


def old_exponent(text: str) -> str:
    return text.replace("e+", "D+").replace("e-", "D-")


def padded(text: str) -> str:
    """The last row of each set filled with zeros, as the 65 complex numbers leave room for two."""
    return text.replace("\n    -1\n    -1\n", f"{0:20.11e}{0:20.11e}\n    -1\n    -1\n")


DIALECTS: dict[str, Callable[[str], str]] = {
    "plain": lambda t: t,
    "words above the first mark": lambda t: f"exported by somebody\n{t}",
    "D": old_exponent,
    "d": lambda t: old_exponent(t).replace("D", "d"),
    "E": lambda t: t.replace("e+", "E+").replace("e-", "E-"),
    "blank sign": lambda t: t.replace("e+", "E "),
    "padded": padded,
    "blanks behind": lambda t: "\n".join(line.ljust(100) if "e" in line else line for line in t.split("\n")),
    "blank lines": lambda t: t.replace("\n    -1\n", "\n\n    -1\n"),
    "short marks": lambda t: t.replace("    -1\n", "    -1   \n"),
    "mac": lambda t: t.replace("\n", "\r"),
    "windows": lambda t: t.replace("\n", "\r\n"),
    "free columns": lambda t: "\n".join(" ".join(x.split()) if x.count("e") > 1 else x for x in t.split("\n")),
}


# Rows of whole points, as an uneven abscissa has, leave nothing to fill up.
@pytest.mark.parametrize(("name", "even"), [(n, e) for n in DIALECTS for e in (True, False) if e or n != "padded"])
def test_frfs_are_the_same_in_every_dialect(tmp_path: Path, name: str, even: bool) -> None:
    path = frfs(tmp_path / "a.uff", even=even)
    path.write_bytes(DIALECTS[name](path.read_text(encoding="ascii")).encode())
    (frf,) = import_sources([path], RIG).frfs
    np.testing.assert_allclose(frf.values[:, 0], receptances(N), rtol=1e-10)
    np.testing.assert_allclose(frf.frequency_hz, LINES, rtol=1e-5)


@pytest.mark.parametrize("announced", ["as it is", "zero"])
def test_bytes_that_read_like_an_end_mark_end_no_set(tmp_path: Path, announced: str) -> None:
    path = frfs(tmp_path / "a.uff", binary=True)
    raw = path.read_bytes()
    place = raw.index(np.ascontiguousarray(receptances(N)[0]).tobytes()) + 160
    mark = b"\n    -1\n"
    raw = raw[:place] + mark + raw[place + len(mark) :]
    path.write_bytes(raw.replace(f"{16 * N:12d}".encode(), f"{0:12d}".encode()) if announced == "zero" else raw)
    (frf,) = import_sources([path], RIG).frfs
    np.testing.assert_allclose(frf.values[1:, 0], receptances(N)[1:], rtol=1e-12)
    assert frf.values[0, 0, 10].real == np.frombuffer(mark, "<f8")[0]


@pytest.mark.parametrize(("fp", "words"), [(1, "format 1"), (3, "format 3")])
def test_binary_numbers_that_are_not_ieees_are_rejected(tmp_path: Path, fp: int, words: str) -> None:
    path = frfs(tmp_path / "a.uff", binary=True)
    path.write_bytes(path.read_bytes().replace(f"58b{1:6d}{2:6d}".encode(), f"58b{1:6d}{fp:6d}".encode()))
    with pytest.raises(FormatError, match=words):
        import_sources([path], RIG)


def test_an_uneven_abscissa_in_single_precision_beside_doubles_is_read(tmp_path: Path) -> None:
    path = frfs(tmp_path / "a.uff", binary=True, even=False)
    raw = path.read_bytes()
    for values in receptances(N):
        flat = np.column_stack([LINES, values.real, values.imag])
        mixed = np.zeros(N, np.dtype([("x", "<f4"), ("y", "<f8", (2,))]))
        mixed["x"], mixed["y"] = flat[:, 0], flat[:, 1:]
        raw = raw.replace(flat.tobytes(), mixed.tobytes())
    path.write_bytes(raw.replace(f"{24 * N:12d}".encode(), f"{20 * N:12d}".encode()))
    (frf,) = import_sources([path], RIG).frfs
    np.testing.assert_allclose(frf.values[:, 0], receptances(N), rtol=1e-12)


def test_a_whole_unit_beside_the_response_needs_none_beside_the_force(tmp_path: Path) -> None:
    path = frfs(tmp_path / "a.uff")
    text = path.read_text(encoding="ascii").replace("NONE                 m   ", "NONE                 m/N ")
    path.write_text(text.replace("NONE                 N   ", "NONE                 NONE"), encoding="ascii")
    (frf,) = import_sources([path], RIG).frfs
    assert frf.quantity == "receptance"
    np.testing.assert_allclose(frf.values[:, 0], receptances(N), rtol=1e-10)


@pytest.mark.parametrize(
    ("text", "values"),
    [
        (" 1.5D+01-2.0d-01", [15, -0.2]),
        ("-1.00000E+00-2.00000E-100", [-1, -2e-100]),
        (" 1.25-101 2.", [1.25e-101, 2]),
        ("0.1E 01 .5E1", [1, 5]),
        ("1 -2 3.", [1, -2, 3]),
    ],
)
def test_numbers_are_read_as_fortran_writes_them(text: str, values: list[float]) -> None:
    np.testing.assert_allclose(numbers([text], "a"), values, rtol=1e-14)


@pytest.mark.parametrize("text", ["1.0 ****** 2.0", "1.00000E+001.00000E+00", "1.0 abc", "1,5 2,5"])
def test_what_is_no_number_is_named(text: str) -> None:
    with pytest.raises(FormatError, match="is no number"):
        numbers([text], "a.uff, set 1")


@pytest.mark.parametrize("exponent", ["E", "D", "e", "d"])
def test_geometry_and_shapes_share_the_syntax(tmp_path: Path, exponent: str) -> None:
    def written(values: list[float], width: int, places: int) -> str:
        return "".join(f"{v:{width}.{places}E}" for v in values).replace("E", exponent)

    lines = ["    -1", "  2411"]
    for n, at in enumerate([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0)], start=1):
        lines += [f"{n:10d}{1:10d}{1:10d}{11:10d}", written(list(at), 25, 16)]
    lines += ["    -1", "    -1", "    55", "mode", *["NONE"] * 4]
    lines += ["".join(f"{v:10d}" for v in row) for row in ((1, 2, 2, 8, 2, 3), (2, 4, 1, 1))]
    lines += [written([12.5, 1.0, 0.02, 0.0], 13, 5)]
    for n in range(3):
        lines += [f"{n + 1:10d}", written([0.1 * n, 0.2, -0.3], 13, 5)]
    path = tmp_path / "a.uff"
    path.write_text("\n".join([*lines, "    -1", ""]))
    found = read_results(path)
    assert found.geometry.points[3] == (1.0, 1.0, 0.0)
    (mode,) = found.modes
    assert (mode.frequency_hz, mode.damping_ratio) == (12.5, 0.02)
    np.testing.assert_allclose(mode.at[3], [0.2, 0.2, -0.3])
