"""Files of programs that say above a table, and not above its columns, what the columns are."""

from pathlib import Path

import numpy as np
import pytest

from modallab.core.block import Campaign
from modallab.core.errors import DataError
from modallab.core.rig import Channel, Point, Rig
from modallab.formats.importer import import_recordings, import_sources
from modallab.formats.options import ImportOptions

RATE_HZ, N = 2000.0, 300
RIG = Rig(
    name="two sensors",
    model="unknown",
    points=(Point(id=1, x_m=0.1), Point(id=2, x_m=0.3)),
    channels=(
        Channel(index=0, name="force", quantity="force", unit="N", point=1),
        Channel(index=1, name="a1", quantity="acceleration", unit="m/s^2", point=1),
        Channel(index=2, name="a2", quantity="acceleration", unit="m/s^2", point=2),
    ),
)
NAMES = ("force", "a1", "a2")
SAMPLES = np.random.default_rng(1).normal(size=(3, N)).round(6)
T = np.arange(N) / RATE_HZ
LINES = np.arange(1, 200) * 0.5
FRFS = np.array([-(LINES**2) / (c**2 - LINES**2 + 0.02j * c * LINES) for c in (30.0, 60.0)]).round(6)


def counted(unit: str, kind: str, of: str, amplitude: str, columns: list[np.ndarray]) -> str:
    """As an analyser writes one function: facts of four cells, then numbered rows."""
    facts = {"Header Size:": "12", "Decimal Symbol:": ".", "Data Type:": kind, "Z-Axis unit:": "", "X-Axis unit:": unit}
    facts |= {"AmplitudeUnit:": amplitude, "Domain:": "1", "Ref_Signal:": "force", "Signal:": of, "Date:": "15/11/2026"}
    rows = [f"{k}\t" + "\t".join(f" {v:.9e}" for v in row) for k, row in enumerate(np.array(columns).T, 1)]
    return "\n".join([*(f"{key}\t{value}\t \t " for key, value in facts.items()), *rows]) + "\n"


def frf(k: int) -> str:
    return counted("Hz", "Complex", NAMES[k + 1], "(m/s²)/N", [LINES, FRFS[k].real, FRFS[k].imag])


def rows(between: str, columns: list[np.ndarray]) -> list[str]:
    return [between.join(f"{v:.9g}" for v in row) for row in np.array(columns).T]


def test_a_rate_above_the_table_that_its_times_contradict_is_rejected(tmp_path: Path) -> None:
    """Times in s under a heading that says ms: one of the two is wrong, and which one is not said."""
    head = [f"Sample rate [Hz],{RATE_HZ:g},,", "time [ms],force [N],a1 [m/s^2],a2 [m/s^2]"]
    text = "\n".join([*head, *rows(",", [T, *SAMPLES])]) + "\n"
    with pytest.raises(DataError, match="times say 2e\\+06 Hz, and beside them stands a rate of 2000 Hz"):
        read(tmp_path, text)
    np.testing.assert_allclose(read(tmp_path, text.replace("[ms]", "[s]")).blocks[0].samples, SAMPLES)


def read(folder: Path, *texts: str, rig: Rig = RIG) -> Campaign:
    paths = [folder / f"file{k}.txt" for k in range(len(texts))]
    for path, text in zip(paths, texts, strict=True):
        path.write_text(text, encoding="utf-8")
    return import_sources(paths, rig, ImportOptions(drive_point=1))


UNITS = ("N", "m/s^2", "m/s^2")
RECORDS = {
    "rows with a number that no name is above": "\n".join(
        ['"time [s]" "force [N]" "a1 [m/s^2]" "a2 [m/s^2]"']
        + [f'"{k}" {row}' for k, row in enumerate(rows(" ", [T, *SAMPLES]), start=1)]
    )
    + "\n",
    "counts of a clock beside seconds": "\n".join(
        ["time,seconds_elapsed,force,a1,a2", *rows(",", [1.7e18 + 1e9 * T, T, *SAMPLES])]
    )
    + "\n",
    "a function below each other": "".join(
        counted("s", "Real", name, unit, [T, row]) for name, unit, row in zip(NAMES, UNITS, SAMPLES, strict=True)
    ),
    "keys before the names": "\n".join(
        [
            "CSVFormatType,Time",
            f"Delta,{1 / RATE_HZ}",
            "AxisUnit,s",
            "",
            "Name,force,a1,a2",
            "FunctionType,Streamed",
            "Unit,N,m/s^2,m/s^2",
            "OutputDOF,New DOF.1Z+,New DOF.1Z+,New DOF.2Z+",
            *rows(",", [T, *SAMPLES]),
        ]
    )
    + "\n",
    "keys in lines of their own": "\n".join(
        [
            "channel names:",
            "force\ta1\ta2",
            "start times:",
            "\t".join(["11/26/2026 10:00:00.123456"] * 3),
            "dt:",
            "\t".join(["0.000500"] * 3),
            "data:",
            *rows("\t", list(SAMPLES)),
        ]
    )
    + "\n",
    "times before each channel": "\n".join(
        [
            "Hamm:1\t\tBeam:1\t\tBeam:2\t",
            "Time\tforce\tTime\ta1\tTime\ta2",
            "s\tN\ts\tm/s^2\ts\tm/s^2",
            *rows("\t", [c for row in SAMPLES for c in (T, row)]),
        ]
    )
    + "\n",
    "units in the cells": "time,force,a1,a2\n"
    + "".join(f"{t:.6g} sec,{f:.6f} N,{a:.6f} m/s²,{b:.6f} m/s²\n" for t, f, a, b in zip(T, *SAMPLES, strict=True)),
}


@pytest.mark.parametrize("text", RECORDS.values(), ids=RECORDS.keys())
def test_a_record_is_read_by_the_facts_above_it(tmp_path: Path, text: str) -> None:
    (block,) = read(tmp_path, text).blocks
    assert block.rate_hz == pytest.approx(RATE_HZ)
    np.testing.assert_allclose(block.samples, SAMPLES, atol=1e-6)


def test_frfs_of_numbered_rows_are_those_of_their_signals(tmp_path: Path) -> None:
    (found,) = read(tmp_path, frf(0) + frf(1)).frfs
    assert found.outputs == ("a1", "a2")
    np.testing.assert_allclose(found.values[:, 0], FRFS, atol=1e-6)


def test_files_of_one_frf_each_are_one_matrix_with_a_rig_and_without(tmp_path: Path) -> None:
    (found,) = read(tmp_path, frf(1), frf(0)).frfs
    np.testing.assert_allclose(found.values[[found.outputs.index("a1"), found.outputs.index("a2")], 0], FRFS, atol=1e-6)
    drafted = import_recordings([tmp_path / "file0.txt", tmp_path / "file1.txt"], None, {})
    assert [channel.name for channel in drafted.rig.channels] == ["force", "a2", "a1"]
    assert drafted.frfs[0].outputs == ("a2", "a1")


def test_one_frf_of_two_is_not_taken_for_both(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="no FRF of channel a2"):
        read(tmp_path, frf(0))


def test_points_above_tables_say_whose_mobilities_they_are(tmp_path: Path) -> None:
    parts = [
        "\n".join([f"Point Index\t{k}", "Signal\tVib & Ref1 H1", "", "Frequency\tReal\tImaginary"])
        + "\n[ Hz ]\t[ m/s^2 / N ]\t[ m/s^2 / N ]\n"
        + "\n".join(rows("\t", [LINES, h.real, h.imag]))
        for k, h in enumerate(FRFS, 1)
    ]
    (found,) = read(tmp_path, "\n".join(parts) + "\n").frfs
    np.testing.assert_allclose(found.values[:, 0], FRFS, atol=1e-6)


@pytest.mark.parametrize(("said", "taken"), [("Units: Ratio", True), ("Units: Product", False)])
def test_a_product_of_units_is_a_ratio_where_that_is_said(tmp_path: Path, said: str, taken: bool) -> None:
    head = [said, "Ref Chan:Resp Chan\t1-Z:1-Z", "", "Frequency\tReal\tImaginary", "", "Units:", "Hz\t(m/s²)(N)\t "]
    text = "\n".join([*head, *rows("\t", [LINES, FRFS[0].real, FRFS[0].imag])]) + "\n"
    rig = RIG.model_copy(update={"channels": RIG.channels[:2]})
    if taken:
        np.testing.assert_allclose(read(tmp_path, text, rig=rig).frfs[0].values[0, 0], FRFS[0], atol=1e-6)
    else:
        with pytest.raises(DataError):
            read(tmp_path, text, rig=rig)
