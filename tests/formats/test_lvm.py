"""LabVIEW measurement files, in the layouts that LabVIEW can be set to."""

from pathlib import Path

import numpy as np
import pytest

from modallab.core.block import Campaign
from modallab.core.errors import DataError, FormatError
from modallab.core.rig import Channel, Rig
from modallab.formats.importer import draft_rig, import_sources
from modallab.formats.options import ImportOptions

RATE_HZ, N = 2000.0, 300
RIG = Rig(
    name="one sensor",
    model="unknown",
    channels=(
        Channel(index=0, name="Force", quantity="force", unit="N"),
        Channel(index=1, name="Acc 1", quantity="acceleration", unit="g"),
    ),
)
_RNG = np.random.default_rng(1)
SAMPLES = _RNG.normal(size=(2, N))


def number(value: float, mark: str) -> str:
    return f"{value:.8E}".replace(".", mark)


def header(mark: str, columns: str, separator: str) -> list[str]:
    pairs = {"Writer_Version": "2", "Separator": "Comma" if separator == "," else "Tab", "Decimal_Separator": mark}
    pairs |= {"Multi_Headings": "Yes", "X_Columns": columns, "Time_Pref": "Absolute", "Operator": "somebody"}
    rows = ["LabVIEW Measurement", *(separator.join(pair) for pair in pairs.items()), "***End_of_Header***"]
    return [row + separator for row in rows] + [separator]


def segment(
    mark: str, columns: str, separator: str, late: int = 0, samples: int = N, *, step: float = 1 / RATE_HZ
) -> list[str]:
    """The second channel begins `late` samples after the first."""
    x0 = (number(0, mark), number(late * step, mark))
    said = number(step, mark)
    facts = [("Channels", "2"), ("Samples", f"{samples}", f"{samples}"), ("Date", "2026/11/26", "2026/11/26")]
    facts += [("Time", f"10:00:01{mark}5", f"10:00:01{mark}5"), ("Y_Unit_Label", "Newtons", "g"), ("X0", *x0)]
    facts += [("Delta_X", said, said), ("***End_of_Header***",)]
    heads = ["X_Value", "Force", *(["X_Value"] if columns == "Multi" else []), "Acc 1", "Comment"]
    if columns == "Multi":
        # Each value stands above the samples of its channel.
        facts = [(tag, *(cell for value in values for cell in (value, ""))) for tag, *values in facts]
    rows: list[str] = [separator.join((*fact, "", "")) for fact in facts] + [separator.join(heads)]
    for k in range(samples):
        first = number(k * step, mark) if columns != "No" else ""
        between = [number((k + late) * step, mark)] if columns == "Multi" else []
        second = number(SAMPLES[1, k + late], mark) if k + late < N else ""
        rows.append(separator.join([first, number(SAMPLES[0, k], mark), *between, second]))
    rows[-1] += f"{separator}a comment"
    return [*rows, ""]


def read(folder: Path, lines: list[str], options: ImportOptions | None = None) -> Campaign:
    path = folder / "hit.lvm"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return import_sources([path], RIG, options)


@pytest.mark.parametrize("columns", ["No", "One", "Multi"])
@pytest.mark.parametrize(("mark", "separator"), [(".", "\t"), (",", "\t"), (".", ",")])
@pytest.mark.parametrize("hits", [1, 3])
def test_every_layout_gives_the_same_records(
    tmp_path: Path, columns: str, mark: str, separator: str, hits: int
) -> None:
    text = header(mark, columns, separator) + hits * segment(mark, columns, separator)
    blocks = read(tmp_path, text).blocks
    assert len(blocks) == hits
    for block in blocks:
        assert (block.rate_hz, block.units) == (RATE_HZ, ("N", "g"))
        np.testing.assert_allclose(block.samples, SAMPLES, atol=1e-7)


def test_what_a_program_keeps_for_itself_is_left_out(tmp_path: Path) -> None:
    special = ["***Start_Special***", "anything\tat all", "***End_Special***"]
    text = [*header(".", "One", "\t"), *special, *segment(".", "One", "\t")]
    assert len(read(tmp_path, text).blocks) == 1


def test_channels_that_begin_at_different_times_are_aligned(tmp_path: Path) -> None:
    campaign = read(tmp_path, header(".", "Multi", "\t") + segment(".", "Multi", "\t", late=6))
    np.testing.assert_allclose(campaign.blocks[0].samples, SAMPLES[:, 6:], atol=1e-7)
    assert "begin at different times" in campaign.provenance["notes"]


def test_a_channel_that_ends_earlier_cuts_the_others_where_each_sample_has_its_time(tmp_path: Path) -> None:
    lines = segment(".", "Multi", "\t")
    last = [k for k, line in enumerate(lines) if line][-7:]
    for k in last:
        lines[k] = "\t".join([*lines[k].split("\t")[:2], "", ""])
    campaign = read(tmp_path, header(".", "Multi", "\t") + lines)
    np.testing.assert_allclose(campaign.blocks[0].samples, SAMPLES[:, :-7], atol=1e-7)
    assert f"cut to the first {N - 7} samples" in campaign.provenance["notes"]


def test_a_rig_is_drafted_from_names_and_units(tmp_path: Path) -> None:
    path = tmp_path / "hit.lvm"
    path.write_text("\n".join(header(".", "No", "\t") + segment(".", "No", "\t")), encoding="utf-8")
    channels = draft_rig(path, ImportOptions()).channels
    assert [(c.name, c.quantity, c.unit) for c in channels] == [("Force", "force", "N"), ("Acc 1", "acceleration", "g")]


def test_a_cut_file_and_a_wrong_mark_are_named(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="header that begins at line 11 has no end"):
        read(tmp_path, header(".", "One", "\t") + segment(".", "One", "\t")[:4])
    with pytest.raises(FormatError, match=r"is no number with the decimal mark '\.'"):
        read(tmp_path, header(".", "One", "\t") + segment(",", "One", "\t"))


def test_a_channel_that_is_missing_is_named(tmp_path: Path) -> None:
    sensor = RIG.channels[1].model_copy(update={"index": 2, "name": "a9"})
    rig = RIG.model_copy(update={"channels": (*RIG.channels, sensor)})
    path = tmp_path / "hit.lvm"
    path.write_text("\n".join(header(".", "One", "\t") + segment(".", "One", "\t")), encoding="utf-8")
    with pytest.raises(DataError, match="no column for channel a9"):
        import_sources([path], rig)


@pytest.mark.parametrize("columns", ["No", "One"])
def test_segments_under_one_header_are_records_of_their_own(tmp_path: Path, columns: str) -> None:
    one = segment(".", columns, "\t")
    rows = one[next(k for k, line in enumerate(one) if line.startswith("X_Value")) + 1 :]
    blocks = read(tmp_path, header(".", columns, "\t") + one + rows).blocks
    assert len(blocks) == 2
    for block in blocks:
        np.testing.assert_allclose(block.samples, SAMPLES, atol=1e-7)


def test_segments_whose_x_runs_on_are_one_record(tmp_path: Path) -> None:
    lines = [line.replace(f"Samples\t{N}\t{N}", f"Samples\t{N // 3}\t{N // 3}") for line in segment(".", "One", "\t")]
    (block,) = read(tmp_path, header(".", "One", "\t") + lines).blocks
    np.testing.assert_allclose(block.samples, SAMPLES, atol=1e-7)


def test_a_step_of_few_digits_is_that_of_the_whole_rate(tmp_path: Path) -> None:
    lines = [line.replace(number(1 / RATE_HZ, "."), "0.000977") for line in segment(".", "No", "\t")]
    assert read(tmp_path, header(".", "No", "\t") + lines).blocks[0].rate_hz == 1024


def test_a_column_of_x_that_contradicts_the_step_is_rejected(tmp_path: Path) -> None:
    step = number(1 / RATE_HZ, ".")
    lines = [
        line.replace(step, "0.001000") if line.startswith("Delta_X") else line for line in segment(".", "One", "\t")
    ]
    with pytest.raises(DataError, match="Delta_X says 1000 Hz, the column of x 2000 Hz"):
        read(tmp_path, header(".", "One", "\t") + lines)


def test_a_file_without_headers_is_a_table(tmp_path: Path) -> None:
    rows = [f"{k / RATE_HZ:.6f}\t{f:.8f}\t{a:.8f}" for k, (f, a) in enumerate(SAMPLES.T)]
    (block,) = read(tmp_path, rows).blocks
    assert block.rate_hz == RATE_HZ
    np.testing.assert_allclose(block.samples, SAMPLES, atol=1e-7)


def test_a_column_of_x_too_coarse_for_the_rate_leaves_it_to_the_step(tmp_path: Path) -> None:
    lines = segment(".", "One", "\t")
    first = next(k for k, line in enumerate(lines) if line.startswith("X_Value")) + 1
    rows = [f"{k / RATE_HZ:.3f}\t{line.split(chr(9), 1)[1]}" for k, line in enumerate(lines[first:-1])]
    assert read(tmp_path, header(".", "One", "\t") + lines[:first] + rows).blocks[0].rate_hz == RATE_HZ


def test_a_segment_with_fewer_rows_than_it_says_is_cut_off(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=f"stand 200 of {N} samples"):
        read(tmp_path, header(".", "One", "\t") + segment(".", "One", "\t")[: 200 - N - 1])


@pytest.mark.parametrize("columns", ["No", "One", "Multi"])
def test_a_step_that_only_counts_samples_leaves_the_rate_to_the_user(tmp_path: Path, columns: str) -> None:
    lines = [*header(".", columns, "\t"), *segment(".", columns, "\t", step=1.0)]
    found = read(tmp_path, lines, ImportOptions(rate_hz=RATE_HZ)).blocks[0]
    np.testing.assert_allclose(found.samples, SAMPLES, atol=1e-7)
    assert found.rate_hz == RATE_HZ
    assert "if its file only counts samples, give the rate with --rate" in read(tmp_path, lines).provenance["notes"]


def test_a_rate_against_that_of_the_file_says_what_may_be_wrong(tmp_path: Path) -> None:
    lines = [*header(".", "One", "\t"), *segment(".", "One", "\t")]
    with pytest.raises(DataError, match="the file says 2000 Hz, --rate says 500 Hz") as caught:
        read(tmp_path, lines, ImportOptions(rate_hz=500.0))
    assert "correct its times or its step" in caught.value.remedy


def test_rows_that_somebody_left_out_have_the_rate_of_their_column_of_x(tmp_path: Path) -> None:
    lines = header(".", "One", "\t") + segment(".", "One", "\t")
    thinned = [line.replace("5.00000000E-04", "5.00000000E-05").replace(f"\t{N}", f"\t{10 * N}") for line in lines]
    thinned = [new if old.startswith(("Samples", "Delta_X")) else old for old, new in zip(lines, thinned, strict=True)]
    (block,) = read(tmp_path, thinned).blocks
    assert block.rate_hz == pytest.approx(RATE_HZ)
    assert block.samples.shape == (2, N)


def test_a_spectrum_by_its_name_is_no_record_of_time(tmp_path: Path) -> None:
    lines = [
        line.replace("Force", "Force (FFT - (RMS))") for line in header(".", "One", "\t") + segment(".", "One", "\t")
    ]
    with pytest.raises(DataError, match="over Frequency"):
        read(tmp_path, lines, ImportOptions(variables=(("Force", "Force (FFT - (RMS))"),)))
