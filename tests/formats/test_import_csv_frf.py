"""FRFs in tables as people write them: complex numbers, Re and Im, magnitude and phase."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from exchange_rigs import beam_rig
from numpy.typing import NDArray

from modallab.cli import main
from modallab.core.errors import DataError
from modallab.core.frf import Frf
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.formats.csv.csv_cells import plain_numbers
from modallab.formats.csv.frf_heading import frf_heading
from modallab.formats.importer import draft_rig, import_sources
from modallab.formats.options import ImportOptions

RIG = beam_rig()
LINES = np.arange(1.0, 61.0)
NAMES = ("a01", "a02", "a03")


def inertances() -> NDArray[np.complex128]:
    """(3, lines) of two modes."""
    s = 2j * np.pi * LINES
    poles = np.array([-1.0 + 90j, -2.0 + 250j])
    residues = np.array([[1, 0.5], [2, -1], [-1, 0.7]])
    return np.array([sum(s**2 * a / (s - p) / (s - p.conj()) for a, p in zip(r, poles, strict=True)) for r in residues])


def table(head: str, row: Callable[[complex], list[str]], delimiter: str = ",") -> str:
    rows = ([f"{f:g}", *(cell for v in at for cell in row(v))] for f, at in zip(LINES, inertances().T, strict=True))
    return head + "\n" + "\n".join(delimiter.join(cells) for cells in rows) + "\n"


def read(folder: Path, text: str, **options: Any) -> Frf:
    path = folder / "frf.csv"
    path.write_text(text, encoding="utf-8")
    (frf,) = import_sources([path], RIG, ImportOptions(**options)).frfs
    return frf


def two(v: complex) -> list[str]:
    return [f"{v.real:.12g}", f"{v.imag:.12g}"]


def polar(v: complex, turn: float = 180 / np.pi) -> list[str]:
    return [f"{abs(v):.12g}", f"{np.angle(v) * turn:.12g}"]


WAYS = {
    "the force first": table("Channel name,force:a01,,force:a02,,force:a03,\nHz,Real,Imag,Real,Imag,Real,Imag", two),
    "Italian": table("Frequenza [Hz]," + ",".join(f"Parte reale {n},Parte imm. {n}" for n in NAMES), two),
    "names above bare parts": table(
        "Signal,a01,,a02,,a03,\nFrequency (Hz),Real,Imaginary,Real,Imaginary,Real,Imaginary", two
    ),
    "functions above bare parts": table(
        '"","H1,2(f)","H1,2(f)","H2,2(f)","H2,2(f)","H3,2(f)","H3,2(f)"\nHz,Real,Imaginary,Real,Imaginary,Real,Imaginary',
        two,
    ),
    "functions in words": table(
        "f [Hz]," + ",".join(f"Re(H {n}),Im(H {n}),\u03b3\u00b2({n})" for n in NAMES),
        lambda v: [*two(v), "0.99"],
    ),
    "in kilograms": table("Frequency in Hz," + ",".join(f"Re {n} in 1/kg,Im {n} in 1/kg" for n in NAMES), two),
    "i": table("Frequency [Hz],a01,a02,a03", lambda v: [f"{v.real:.12g}{v.imag:+.12g}i"]),
    "spaced j": table("f;a01;a02;a03", lambda v: [f"{v.real:.12g} {'+-'[int(v.imag < 0)]} {abs(v.imag):.12g}j"], ";"),
    "j first": table("f,a01,a02,a03", lambda v: [f"{v.real:.12g}{'+-'[int(v.imag < 0)]}j*{abs(v.imag):.12g}"]),
    "pairs": table("f,a01,a02,a03", lambda v: [f"({v.real:.12g}, {v.imag:.12g})"]),
    "decimal commas": table("Frequenz [Hz];a01;a02;a03", lambda v: [f"{v.real:.12g}{v.imag:+.12g}i"], ";").replace(
        ".", ","
    ),
    "no header": table("", lambda v: [f"{v.real:.12g}{v.imag:+.12g}i"]).lstrip(),
    "blanks": table("# f re_a01 im_a01 re_a02 im_a02 re_a03 im_a03", two, "  "),
    "re im": table("freq,Re(a01),Im(a01),Re(a02),Im(a02),Real a03,Imaginary a03", two),
    "per channel": table("Frequency (Hz)\ta01 real\ta01 imag\ta02 real\ta02 imag\ta03_re\ta03_im", two, "\t"),
    "degrees": table("f,|a01|,a01 phase [deg],Mag a02,Phase a02 (°),a03_mag,a03_phase_deg", polar),
    "a phase beside it": table("f,a01,a01 phase [deg],a02,Phase a02 (°),a03,a03_phase_deg", polar),
    "radians": table("f,abs a01,arg a01 [rad],abs a02,arg a02 [rad],abs a03,arg a03 [rad]", lambda v: polar(v, 1.0)),
    "by point": table("f [Hz],H1,H2,H3", lambda v: [f"{v.real:.12g}{v.imag:+.12g}i"]),
    "a title and units": "Test of 3 May;;\nFrequency;Re a01;Im a01;Re a02;Im a02;Re a03;Im a03\n"
    + table("Hz;m/s²/N;m/s²/N;m/s²/N;m/s²/N;m/s²/N;m/s²/N", two, ";"),
    "kilo": table("f,Re a01 [mm/s^2/N],Im a01 [mm/s^2/N],Re a02,Im a02,Re a03,Im a03", two),
    "decibel of g": table(
        "f,a01 mag [dB re 1 g/N],a01 phase [deg],a02 mag [dB (g/N)],a02 phase [deg],"
        "a03 mag [dB ref. 1 m/s²/N],a03 phase [deg]",
        lambda v: [f"{20 * np.log10(abs(v)):.14g}", polar(v)[1]],
    ),
    "decibel": table(
        "f,a01 mag [dB],a01 phase [deg],a02 mag [dB],a02 phase [deg],a03 mag [dB],a03 phase [deg]",
        lambda v: [f"{20 * np.log10(abs(v)):.14g}", polar(v)[1]],
    ),
}


FACTORS = {"kilo": (1e-3, 1, 1), "decibel of g": (9.80665, 9.80665, 1)}


@pytest.mark.parametrize("way", WAYS)
def test_the_same_frfs_come_from_every_way_of_writing_them(tmp_path: Path, way: str) -> None:
    frf = read(tmp_path, WAYS[way], drive_point=2)
    expected = inertances() * np.array(FACTORS.get(way, (1, 1, 1)))[:, None]
    np.testing.assert_allclose(frf.values[:, 0], expected, rtol=1e-9)
    np.testing.assert_array_equal(frf.frequency_hz, LINES)
    assert (frf.quantity, frf.outputs, frf.input_points) == ("inertance", NAMES, (2,))


def test_a_first_column_in_a_unit_of_frequency_holds_the_lines(tmp_path: Path) -> None:
    text = table("omega [rad/s],Re a01,Im a01,Re a02,Im a02,Re a03,Im a03", two)
    np.testing.assert_allclose(read(tmp_path, text).frequency_hz, LINES / (2 * np.pi))


def test_the_point_of_the_force_stands_behind_the_response(tmp_path: Path) -> None:
    head = "f," + ",".join(f"Re {n}/p{p},Im {n}/p{p}" for n in NAMES for p in (1, 3))
    frf = read(tmp_path, table(head, lambda v: two(v) + two(2 * v)))
    assert frf.input_points == (1, 3)
    np.testing.assert_allclose(frf.values[:, 1], 2 * inertances(), rtol=1e-9)


def test_coherences_come_along(tmp_path: Path) -> None:
    head = "f," + ",".join(f"Re {n},Im {n},Coherence {n}" for n in NAMES)
    frf = read(tmp_path, table(head, lambda v: [*two(v), "0.75"]))
    assert frf.coherence is not None
    assert np.all(frf.coherence == 0.75)


def test_numbers_without_a_unit_are_in_those_of_the_rig(tmp_path: Path) -> None:
    content = RIG.model_dump()
    channels = [c | ({"unit": "g"} if c["quantity"] == "acceleration" else {}) for c in content["channels"]]
    path = tmp_path / "frf.csv"
    path.write_text(WAYS["i"], encoding="utf-8")
    (frf,) = import_sources([path], type(RIG).model_validate(content | {"channels": channels})).frfs
    np.testing.assert_allclose(frf.values[:, 0], 9.80665 * inertances(), rtol=1e-9)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (table("f,Mag a01,Phase a01,Mag a02,Phase a02,Mag a03,Phase a03", polar), r"'' is no unit of a phase"),
        (table("f,|a01|,|a02|,|a03|", lambda v: [f"{abs(v):g}"]), "which is no complex number"),
        (table("f,Re a01,Im a01,Re a02,Im a02,Re b,Im b", two), "column 'Re b' is the FRF of no response"),
        (table("f [h],a01,a02,a03", lambda v: [f"{v.real:g}{v.imag:+g}i"]), "'h' is no unit of frequency"),
        (table("f,a01 mag [dB re 1 mm],a01 ph [deg],a02,a02 ph,a03,a03 ph", polar), "'dB re 1 mm' is none of an FRF"),
        (table("f,Re a01 [m/s^2],Im a01,Re a02,Im a02,Re a03,Im a03", two), "is none of an FRF of motion"),
        (table("f,Re a01,Im a01,Re a01,Im a01,Re a03,Im a03", two), "are of one FRF"),
        (table("f,Re a01/p1,Im a01/p1,Re a02/p2,Im a02/p2,Re a03/p1,Im a03/p1", two), "has no FRF of a01 to point 2"),
    ],
)
def test_what_is_no_frf_is_said(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(DataError, match=words):
        read(tmp_path, text)


def test_without_a_rig_the_headings_make_one(tmp_path: Path) -> None:
    path = tmp_path / "frf.csv"
    head = "Frequency [Hz]," + ",".join(f"Re H{n},10 [m/s^2/N]".replace(",", " ") + f",Im H{n} 10" for n in (3, 10))
    rows = [",".join([f"{f:g}", *two(a), *two(b)]) for f, a, b in zip(LINES, *inertances()[:2], strict=True)]
    path.write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")
    rig = draft_rig(path)
    assert [(c.name, c.quantity, c.point) for c in rig.channels] == [
        ("force", "force", 10),
        ("p3", "acceleration", 3),
        ("p10", "acceleration", 10),
    ]
    assert main(["import", str(path), "--out", str(tmp_path / "c.h5")]) == 0
    (frf,) = read_campaign(tmp_path / "c.h5").frfs
    assert (frf.outputs, frf.output_points, frf.input_points) == (("p3", "p10"), (3, 10), (10,))


def test_headings_say_part_unit_and_response() -> None:
    found = [frf_heading(*h) for h in (("Re", "H11"), ("a1_phase_deg", ""), ("|a1|", "m/N"), ("Real part", "m/N"))]
    assert [(h.part, h.unit, h.of) for h in found] == [
        ("re", "", "H11"),
        ("phase", "deg", "a1"),
        ("magnitude", "m/N", "a1"),
        ("re", "m/N", ""),
    ]


def test_every_way_of_writing_a_complex_number_is_one() -> None:
    written = ["(1.5, -2e3)", "1.5 - 2e3i", "1.5-2e3*j", "1.5-i*2e3", "1.5-j2e3", "(1.5-2e3j)"]
    assert {complex(plain_numbers(text)) for text in written} == {1.5 - 2e3j}
    assert plain_numbers("1,2;3,4") == "1,2;3,4"
    assert complex(plain_numbers("-2i")) == -2j


def test_a_motion_over_the_force_is_taken_whatever_the_sensor_measures(tmp_path: Path) -> None:
    frf = read(tmp_path, table("f,Re a01 [(mm/s)/N],Im a01,Re a02 [m/s/N],Im a02,Re a03 [m/s/N],Im a03", two))
    assert frf.quantity == "mobility"
    np.testing.assert_allclose(frf.values[:, 0], inertances() * np.array([1e-3, 1, 1])[:, None], rtol=1e-9)


@pytest.mark.parametrize("above", ["# FRF unit: g/N", "Unit;(g)/N", "Magnitude (g/N)"])
def test_one_unit_above_a_table_is_that_of_its_frfs(tmp_path: Path, above: str) -> None:
    frf = read(tmp_path, f"{above}\n" + table("f,Re a01,Im a01,Re a02,Im a02,Re a03,Im a03", two))
    np.testing.assert_allclose(frf.values[:, 0], 9.80665 * inertances(), rtol=1e-9)


def test_a_row_of_units_longer_than_the_table_gives_the_one_unit_of_its_phases(tmp_path: Path) -> None:
    head = "f,Mag a01,Phase a01,Mag a02,Phase a02,Mag a03,Phase a03\nHz,,deg,,deg,,deg,deg"
    np.testing.assert_allclose(read(tmp_path, table(head, polar)).values[:, 0], inertances(), rtol=1e-9)


def test_of_two_quantities_one_is_left_out(tmp_path: Path) -> None:
    text = table("f,Re a01 [m/s^2/N],Im a01,Re a02 [m/s^2/N],Im a02,Re a03 [m/N],Im a03", two)
    with pytest.raises(DataError, match="holds FRFs of inertance and receptance"):
        read(tmp_path, text)
    frf = read(tmp_path, text, ignore=("a03",))
    assert (frf.quantity, frf.outputs) == ("inertance", ("a01", "a02"))


def test_frfs_are_functions_of_response_and_force_over_cycles_per_minute(tmp_path: Path) -> None:
    columns = [f'"H1({n},force) {part}"' for n in NAMES for part in ("Magnitude ((m/s²)/N)", "Phase (Degree)")]
    text = table(",".join(["Frequency [CPM]", *columns]), polar)
    rows = [line.partition(",") for line in text.splitlines()[1:]]
    minutes = [f"{60 * float(f):.12g},{rest}" for f, _, rest in rows]
    frf = read(tmp_path, "\n".join([text.splitlines()[0], *minutes]) + "\n")
    np.testing.assert_allclose(frf.frequency_hz, LINES)
    np.testing.assert_allclose(frf.values[:, 0], inertances(), rtol=1e-9)


def test_a_unit_that_is_none_of_frequency_is_named(tmp_path: Path) -> None:
    text = table("Frequency [furlong]," + ",".join(f"Mag {n},Phase {n} [deg]" for n in NAMES), polar)
    with pytest.raises(DataError, match="unit 'furlong' is no unit of frequency"):
        read(tmp_path, text)
