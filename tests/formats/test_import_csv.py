"""CSV files as spreadsheets, loggers and analysers write them, in English and in German."""

from pathlib import Path

import numpy as np
import pytest
from exchange_records import RATE_HZ, hit, times
from exchange_rigs import beam_rig
from numpy.typing import NDArray

from modallab.core.block import Block
from modallab.core.errors import DataError, FormatError, ModallabError
from modallab.formats.importer import import_sources
from modallab.formats.options import ImportOptions

RIG = beam_rig()
GOOD = np.vstack([times(), hit(4)]).T
HEADER = "time,force,a01,a02,a03"


def rows(values: NDArray[np.float64], form: str = "%.9g", delimiter: str = ",") -> str:
    return "\n".join(delimiter.join(form % value for value in row) for row in values) + "\n"


def write(folder: Path, text: str, encoding: str = "utf-8") -> Path:
    path = folder / "hit_1.csv"
    path.write_bytes(text.encode(encoding))
    return path


def read(path: Path, options: ImportOptions | None = None) -> Block:
    (block,) = import_sources([path], RIG, options).blocks
    return block


def rejected(kind: type[ModallabError], path: Path, options: ImportOptions | None = None) -> str:
    with pytest.raises(kind) as caught:
        import_sources([path], RIG, options)
    assert str(path) in str(caught.value)
    assert caught.value.remedy
    return str(caught.value)


VARIANTS = {
    "plain": HEADER + "\n" + rows(GOOD),
    "no header": rows(GOOD),
    "semicolons": HEADER.replace(",", ";") + "\n" + rows(GOOD, delimiter=";"),
    "tabs": HEADER.replace(",", "\t") + "\n" + rows(GOOD, delimiter="\t"),
    "decimal commas": HEADER.replace(",", ";") + "\n" + rows(GOOD, delimiter=";").replace(".", ","),
    "sep line": "sep=;\n" + HEADER.replace(",", ";") + "\n" + rows(GOOD, delimiter=";"),
    "comments, blank lines, CRLF": "# logger 1\n\n" + (HEADER + "\n" + rows(GOOD)).replace("\n", "\r\n"),
    "quotes, capitals": '"Time","Force","A01","A02","A03"\n' + rows(GOOD),
    "line of units": HEADER + "\ns,N,m/s^2,m/s²,m/s2\n" + rows(GOOD),
    "no line end": HEADER + "\n" + rows(GOOD).rstrip("\n"),
}


@pytest.mark.parametrize("text", VARIANTS.values(), ids=VARIANTS.keys())
def test_the_same_numbers_come_from_every_dialect(tmp_path: Path, text: str) -> None:
    block = read(write(tmp_path, text))
    assert (block.name, block.rate_hz, block.channels) == ("hit_1", RATE_HZ, ("force", "a01", "a02", "a03"))
    np.testing.assert_allclose(block.samples, GOOD[:, 1:].T, rtol=1e-8)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_every_usual_encoding_is_read(tmp_path: Path, encoding: str) -> None:
    head = "Zeit [s];force [N];a01 [m/s²];a02 [m/s²];a03 [m/s²]\n"
    block = read(write(tmp_path, head + rows(GOOD, delimiter=";").replace(".", ","), encoding))
    assert block.units[0] == "N"


def test_columns_are_known_by_name_and_units_by_brackets(tmp_path: Path) -> None:
    order = [4, 0, 3, 1, 2]
    text = "a03 [g],Time (ms),a02 (mm/s^2),force [V],a01\n" + rows((GOOD * [1, 1, 1, 1, 1])[:, order])
    path = write(tmp_path, text)
    block = read(path, ImportOptions())
    assert block.rate_hz == RATE_HZ * 1000
    assert block.units == ("V", "m/s^2", "mm/s^2", "g")
    np.testing.assert_allclose(block.samples, GOOD[:, 1:].T, rtol=1e-8)


def test_without_times_the_rate_must_be_given(tmp_path: Path) -> None:
    path = write(tmp_path, "force,a01,a02,a03\n" + rows(GOOD[:, 1:]))
    assert "has no column of times among force, a01, a02, a03, and no rate is given" in rejected(DataError, path)
    assert read(path, ImportOptions(rate_hz=500.0)).rate_hz == 500.0


def test_rounded_times_still_give_the_rate(tmp_path: Path) -> None:
    values = np.vstack([np.arange(2048) / 25600, hit(4, 2048)]).T
    block = read(write(tmp_path, HEADER + "\n" + rows(values, "%.6f")))
    assert block.rate_hz == 25600.0


def test_a_last_line_without_its_end_is_noted(tmp_path: Path) -> None:
    campaign = import_sources([write(tmp_path, VARIANTS["no line end"])], RIG)
    assert "the last line has no end" in campaign.provenance["notes"]


def changed(row: int, column: int, field: str) -> str:
    lines = [line.split(",") for line in rows(GOOD).splitlines()]
    lines[row][column] = field
    return HEADER + "\n" + "\n".join(",".join(line) for line in lines) + "\n"


CASES: list[tuple[str, type[ModallabError], str, str]] = [
    ("no number", FormatError, changed(8, 2, "1.2x"), "line 10, column 3 (a01): '1.2x' is no number"),
    ("empty field", FormatError, changed(8, 2, ""), "line 10, column 3 (a01): is empty"),
    (
        "NaN",
        DataError,
        changed(8, 2, "nan"),
        "channel a01: 1 of 256 samples are NaN or infinite, the first is sample 8",
    ),
    ("lost line", DataError, HEADER + "\n" + rows(np.delete(GOOD, 9, 0)), "column time: the time axis is uneven"),
    ("descending", DataError, HEADER + "\n" + rows(GOOD[::-1]), "column time: the time axis descends"),
    (
        "wrong unit",
        DataError,
        "time,force [Pa],a01,a02,a03\n" + rows(GOOD),
        "channel force: unit 'Pa' is no unit of force",
    ),
    ("wrong time unit", DataError, "time [kg],force,a01,a02,a03\n" + rows(GOOD), "unit 'kg' is no unit of time"),
    (
        "missing channel",
        DataError,
        "time,force,a01,a02,b\n" + rows(GOOD),
        "no column for channel a03; column 'b' is no",
    ),
    ("channel twice", DataError, "time,force,a01,a02,a02\n" + rows(GOOD), "column a02 is there twice"),
    ("spectra", DataError, "frequency,force,a01,a02,a03\n" + rows(GOOD), "its first column is 'frequency'"),
    ("short line", FormatError, HEADER + "\n1,2,3\n" + rows(GOOD), "line 2, column 4 (a02): is empty"),
    ("no numbers", FormatError, HEADER + "\n", "holds no table of numbers"),
    ("no header, too few", DataError, rows(GOOD[:, :3]), "has 3 columns and no header; the rig has 4 channels"),
    ("coarse times", DataError, HEADER + "\n" + rows(np.round(GOOD, 3), "%.3f"), "written too coarsely"),
    (
        "transposed",
        FormatError,
        rows(GOOD.T),
        "5 rows of 256 cells and no names above them: it looks transposed",
    ),
    ("dead force", DataError, HEADER + "\n" + rows(GOOD * [1, 0, 1, 1, 1]), "channel force is dead"),
]


@pytest.mark.parametrize(("kind", "text", "words"), [c[1:] for c in CASES], ids=[c[0] for c in CASES])
def test_bad_tables_are_rejected_by_name(tmp_path: Path, kind: type[ModallabError], text: str, words: str) -> None:
    assert words in rejected(kind, write(tmp_path, text))


def test_a_file_cut_off_within_a_line_is_reported(tmp_path: Path) -> None:
    whole = HEADER + "\n" + rows(GOOD, "%.6e")
    for keep in range(len(whole) // 2, len(whole) // 2 + 80):
        if whole[keep - 1 : keep] != "\n" and whole[keep] != "\n":
            assert "is cut off" in rejected(FormatError, write(tmp_path, whole[:keep]))


def test_bytes_that_are_no_text_are_reported(tmp_path: Path) -> None:
    path = tmp_path / "hit_1.csv"
    path.write_bytes(b"time,force\n\x00\x01\x02")
    assert "is no text" in rejected(FormatError, path)


def test_lost_samples_are_named_where_times_have_no_more_digits_than_their_step(tmp_path: Path) -> None:
    lost = np.delete(np.arange(256), slice(100, 130))
    body = "".join(f"{k / 1000:.3f},{k % 7}.5,{k % 5}.5,{k % 3}.5,{k % 11}.5\n" for k in lost)
    (tmp_path / "x.csv").write_text(f"{HEADER}\n{body}")
    with pytest.raises(DataError, match=r"uneven: place \d+ stands .* steps"):
        import_sources([tmp_path / "x.csv"], RIG)
