"""Text files of loggers and analysers: quotes, decimal commas, clock times, few digits, columns by other names."""

import re
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from modallab.core.block import Campaign
from modallab.core.errors import DataError, FormatError, ModallabError
from modallab.core.rig import Channel, Point, Rig
from modallab.formats.importer import draft_rig, import_recordings, import_sources
from modallab.formats.options import ImportOptions

RATE_HZ, N = 2000.0, 400
RIG = Rig(
    name="one sensor",
    model="unknown",
    points=(Point(id=1, x_m=0.1),),
    channels=(
        Channel(index=0, name="force", quantity="force", unit="N", point=1),
        Channel(index=1, name="a1", quantity="acceleration", unit="g", point=1),
    ),
)
T = np.arange(N) / RATE_HZ
_RNG = np.random.default_rng(1)
FORCE = np.where((T > 0.02) & (T < 0.024), 1500 * np.sin(np.pi * (T - 0.02) / 0.004), 0.0) + _RNG.normal(0, 0.01, N)
MOTION = np.exp(-5 * T) * np.sin(2 * np.pi * 40 * T) + _RNG.normal(0, 1e-3, N)
BEGIN = datetime(2026, 11, 26, 23, 59, 59, 900000)  # noqa: DTZ001 - what a file says has no zone


def comma(value: float) -> str:
    return f"{value:.6f}".replace(".", ",")


def clock(form: str) -> list[str]:
    return [(BEGIN + timedelta(seconds=float(t))).strftime(form) for t in T]


def table(head: str, form: str, times: list[str] | None = None) -> str:
    rows = zip(times or [f"{t:.6f}" for t in T], FORCE, MOTION, strict=True)
    return "\n".join([head, *[form.format(t, f, a, tc=t.replace(".", ","), fc=comma(f), ac=comma(a)) for t, f, a in rows]]) + "\n"  # fmt: skip # noqa: E501


PLAIN = "{},{:.6f},{:.6f}"
DIALECTS = {
    "decimal commas in quotes": table('"time [s]","force [N]","a1 [g]"', '"{tc}","{fc}","{ac}"'),
    "marks between thousands": table("time [s];force [N];a1 [g]", "{};{:,.6f};{:.6f}"),
    "apostrophes between thousands": table("time [s];force [mN];a1 [g]", "{};{:_.6f};{:.6f}").replace("_", "'"),
    "narrow blanks between thousands": table("time [s];force [mN];a1 [g]", "{};{:_.6f};{:.6f}").replace("_", "\u202f"),
    "exponents of Fortran": re.sub("(?<=[0-9])E(?=[+-])", "D", table("# time force a1", "{} {:.9E} {:.9E}")),
    "facts and units above the table": (
        '"TIME",\n"15:26:55"\n"NUM_SIGS",\n3\n"INTERVAL",\n5.000E-04\n"VERT_UNITS","S","N","g"\n"SIGNAL",\n'
        + table('"TIME","force","a1"\n"DATA"', PLAIN)
    ),
    "a delimiter at the end of each line": table("time [s],force [N],a1 [g],", PLAIN + ","),
    "an empty column of comments": table("time [s],force [N],a1 [g],Comment", PLAIN + ","),
    "a slow channel whose cells are left out": re.sub(
        r"(?m)^(0\.0[0-9]0000.*)$", r"\1,21.5", table("time [s],force [N],a1 [g],T [°C]", PLAIN)
    ),
    "wrapped headings": table('"Time\n[s]","force\n[N]","a1\n\n[g]"', PLAIN),
    "a column of words": table("time [s],force [N],a1 [g],state", PLAIN + ",ok"),
    "a clock across midnight": table("time,force [N],a1 [g]", PLAIN, clock("%H:%M:%S.%f")),
    "ISO times": table("timestamp,force [N],a1 [g]", PLAIN, clock("%Y-%m-%dT%H:%M:%S.%f")),
    "ISO times with a zone": table("timestamp,force [N],a1 [g]", PLAIN, clock("%Y-%m-%dT%H:%M:%S.%fZ")),
    "date and clock, decimal comma": table("Date;force [N];a1 [g]", "{tc};{fc};{ac}", clock("%d/%m/%Y %H:%M:%S.%f")),
    "date and clock in two columns": table("Date,Time,force [N],a1 [g]", PLAIN, clock("%Y/%m/%d,%H:%M:%S.%f")),
    "AM and PM": table("time,force [N],a1 [g]", PLAIN, clock("%I:%M:%S.%f %p")),
    "units in a row of their own": "Time,Force,A1\n(ms),(N),(g)\n" + table("", PLAIN, [f"{1e3 * t:.4f}" for t in T]),
    "quantities over units": table("t/ms;force/N;a1/g", "{};{:.6f};{:.6f}", [f"{1e3 * t:.4f}" for t in T]),
    "microseconds": table("time [µs],force [N],a1 [g]", PLAIN, [f"{1e6 * t:.1f}" for t in T]),
    "minutes": table("time [min],force [N],a1 [g]", PLAIN, [f"{t / 60:.12f}" for t in T]),
    "hours": table("t (h),force [N],a1 [g]", PLAIN, [f"{t / 3600:.14f}" for t in T]),
    "days of a spreadsheet": table("time [d],force [N],a1 [g]", PLAIN, [f"{46110 + t / 86400:.12f}" for t in T]),
    "upright lines between columns": table("time [s] | force [N] | a1 [g]", "{} | {:.6f} | {:.6f}"),
    "blanks between thousands": table("time [s];force [mN];a1 [g]", "{};{:_.6f};{:.6f}").replace("_", " "),
    "thousandths of g": table("time [s],force [N],a1 [mg]", PLAIN),
}


def read(folder: Path, text: str, options: ImportOptions | None = None, rig: Rig = RIG) -> Campaign:
    path = folder / "hit.csv"
    path.write_text(text, encoding="utf-8")
    return import_sources([path], rig, options)


@pytest.mark.parametrize("text", DIALECTS.values(), ids=DIALECTS.keys())
def test_every_dialect_gives_the_same_record(tmp_path: Path, text: str) -> None:
    (block,) = read(tmp_path, text).blocks
    assert block.rate_hz == pytest.approx(RATE_HZ, rel=1e-6)
    np.testing.assert_allclose(block.samples, [FORCE, MOTION], atol=1e-6)


@pytest.mark.parametrize("heading", ["force/kN", "force / (kN)", "force [kN]", "force (kN)"])
def test_the_unit_of_a_heading_counts(tmp_path: Path, heading: str) -> None:
    (block,) = read(tmp_path, table(f"time [s],{heading},a1 [g]", PLAIN)).blocks
    assert block.units == ("kN", "g")


@pytest.mark.parametrize("unit", ["m·s⁻²", "m*s^-2", "m s-2", "m/s²", "m.s-2"])
def test_a_unit_may_have_negative_exponents(tmp_path: Path, unit: str) -> None:
    (block,) = read(tmp_path, table(f"time [s],force [N],a1 [{unit}]", PLAIN)).blocks
    assert block.units == ("N", "m/s^2")


def test_commas_between_columns_and_in_numbers_are_said_to_be_both(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="6 cells for 3 columns: commas stand between the columns and as decimal"):
        read(tmp_path, table("time [s],force [N],a1 [g]", "{tc},{fc},{ac}"))


def test_a_file_without_numbers_says_how_its_lines_begin(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="line 2, begins with 'nothing") as caught:
        read(tmp_path, "time,force,a1\nnothing,here,\n")
    assert caught.value.remedy


def test_columns_of_other_names_are_taken_by_those_that_are_said(tmp_path: Path) -> None:
    text = table("Zeit [s];Kraft [N];Beschl [g]", "{tc};{fc};{ac}")
    with pytest.raises(DataError, match="no column for channel force, a1") as caught:
        read(tmp_path, text)
    assert "--variable force='Kraft'" in caught.value.remedy
    (block,) = read(tmp_path, text, ImportOptions(variables=(("force", "Kraft"), ("a1", "Beschl")))).blocks
    np.testing.assert_allclose(block.samples, [FORCE, MOTION], atol=1e-6)


def test_columns_that_are_no_channels_are_left_out_with_a_note(tmp_path: Path) -> None:
    campaign = read(tmp_path, table("time [s],force [N],a1 [g],temperature", PLAIN + ",21.5"))
    assert campaign.blocks[0].channels == ("force", "a1")
    assert "temperature" in campaign.provenance["notes"]


def test_a_drafted_rig_has_the_channels_that_are_taken(tmp_path: Path) -> None:
    path = tmp_path / "hit.csv"
    path.write_text(table("time [s],force [N],a1 [g],inside", PLAIN + ",21.5"), encoding="utf-8")
    only, without = ImportOptions(channels=("force", "A1")), ImportOptions(ignore=("inside",))
    for options in (only, without):
        assert [c.name for c in draft_rig(path, options).channels] == ["force", "a1"]
    with pytest.raises(DataError, match=r"no channel a2; there are force, a1, inside"):
        draft_rig(path, ImportOptions(channels=("a2",)))
    assert [(c.index, c.name) for c in import_recordings([path], RIG, {"ignore": "force"}).rig.channels] == [(0, "a1")]


def test_the_level_of_each_file_can_be_said(tmp_path: Path) -> None:
    paths = [tmp_path / f"{name}.csv" for name in ("low", "high")]
    for path in paths:
        path.write_text(table("time [s],force [N],a1 [g]", PLAIN), encoding="utf-8")
    blocks = import_recordings(paths, RIG, {"test": "random", "level": ["low", "high"]}).blocks
    assert [b.level for b in blocks] == ["low", "high"]
    with pytest.raises(DataError, match="level: 3 values are given for 2 files"):
        import_recordings(paths, RIG, {"level": ["a", "b", "c"]})


@pytest.mark.parametrize(
    ("rate_hz", "seconds"),
    [
        pytest.param(1024.0, 120.0, marks=pytest.mark.thorough("reads a table of 120000 rows")),
        pytest.param(51200.0, 2.0, marks=pytest.mark.thorough("reads a table of 100000 rows")),
        (4096.0, 9.9),
    ],
)
def test_times_of_seven_digits_give_the_rate(tmp_path: Path, rate_hz: float, seconds: float) -> None:
    """Many decimals near 0, few later, none at the end of round numbers: as %.7g writes them."""
    n = int(rate_hz * seconds)
    values = np.random.default_rng(2).normal(size=(n, 2))
    lines = [f"{k / rate_hz:.7g},{f:.5f},{a:.5f}" for k, (f, a) in enumerate(values)]
    (block,) = read(
        tmp_path, "\n".join(["time [s],force [N],a1 [g]", *lines]) + "\n", ImportOptions(test="random")
    ).blocks
    assert block.rate_hz == pytest.approx(rate_hz, rel=1e-6)


def test_a_sample_that_is_lost_among_times_of_few_digits_is_found(tmp_path: Path) -> None:
    times = np.delete(np.arange(4000) / 1024, 2000)
    lines = [f"{t:.5g},{np.sin(t):.5f},{np.cos(t):.5f}" for t in times]
    with pytest.raises(DataError, match="uneven"):
        read(tmp_path, "\n".join(["time [s],force [N],a1 [g]", *lines]) + "\n")


ORDERS = {
    "Frequency (Hz)\tPhase (deg)\tGain (dB)": (0, 2, 1),
    "Frequency (Hz)\tMagnitude (dB)\tPhase (deg)": (0, 1, 2),
    "frequency\tModulus (dB)\tPhase [deg]": (0, 1, 2),
}


def inertance(f: NDArray[np.float64]) -> NDArray[np.complex128]:
    w, w0 = 2 * np.pi * f, 2 * np.pi * 57
    return np.asarray(-(w**2) / (0.5 * (w0**2 - w**2 + 2j * 0.012 * w0 * w)), np.complex128)


@pytest.mark.parametrize("head", ORDERS)
def test_an_analysers_table_is_known_by_its_names_in_any_order(tmp_path: Path, head: str) -> None:
    f = np.geomspace(10, 200, 60)
    columns = np.stack([f, 20 * np.log10(np.abs(inertance(f))), np.degrees(np.angle(inertance(f)))])[list(ORDERS[head])]
    path = tmp_path / "a.txt"
    np.savetxt(path, columns.T, delimiter="\t", header=head, comments="", fmt="%.10g")
    (frf,) = import_sources([path], RIG, ImportOptions(drive_point=1)).frfs
    np.testing.assert_allclose(frf.values[0, 0], inertance(frf.frequency_hz), rtol=1e-6)


def test_tables_below_each_other_are_a_record_each(tmp_path: Path) -> None:
    one = table("time [s],force [N],a1 [g]", PLAIN)
    blocks = read(tmp_path, f"Measurement 1\n{one}\nMeasurement 2\n{one}").blocks
    assert [block.name for block in blocks] == ["hit_1", "hit_2"]
    np.testing.assert_array_equal(blocks[0].samples, blocks[1].samples)


def test_days_that_no_unit_names_are_not_taken_for_seconds(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="taken as s, give"):
        read(tmp_path, table("time,force [N],a1 [g]", PLAIN, [f"{46110 + t / 86400:.12f}" for t in T]))


def swept_down(path: Path, head: str) -> Path:
    f = np.geomspace(200, 10, 60)
    columns, names = [f, inertance(f).real, inertance(f).imag, 99 - f / 100], f"f [Hz],Re [m/s^2/N],Im [m/s^2/N],{head}"
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=names, comments="")
    return path


def test_a_sweep_down_is_turned_and_its_coherence_in_percent_is_a_share(tmp_path: Path) -> None:
    (frf,) = import_sources(
        [swept_down(tmp_path / "down.csv", "Coherence [%]")], RIG, ImportOptions(drive_point=1)
    ).frfs
    np.testing.assert_allclose(frf.values[0, 0], inertance(frf.frequency_hz), rtol=1e-6)
    assert frf.coherence is not None
    np.testing.assert_allclose(frf.coherence[0, 0], 0.99 - frf.frequency_hz / 1e4, rtol=1e-6)


def test_a_coherence_beyond_one_is_rejected(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="a coherence is not between 0 and 1"):
        import_sources([swept_down(tmp_path / "down.csv", "Coherence")], RIG, ImportOptions(drive_point=1))


@pytest.mark.parametrize("kind", ["csv", "uff", "mat"])
def test_a_sensor_mounted_against_the_drive_is_turned_in_frfs_as_in_records(tmp_path: Path, kind: str) -> None:
    against = RIG.model_copy(
        update={"channels": (RIG.channels[0], RIG.channels[1].model_copy(update={"direction": "-z", "unit": "m/s^2"}))}
    )
    f = np.linspace(10, 200, 96)
    path = tmp_path / f"frf.{kind}"
    _write(path, f, -inertance(f))
    (frf,) = import_sources([path], against, ImportOptions(drive_point=1)).frfs
    np.testing.assert_allclose(frf.values[0, 0], inertance(frf.frequency_hz), rtol=1e-4)


def _write(path: Path, f: NDArray[np.float64], values: NDArray[np.complex128]) -> None:
    """What the sensor read, along its own direction, -z."""
    if path.suffix == ".csv":
        rows = np.column_stack([f, values.real, values.imag])
        np.savetxt(path, rows, delimiter=",", header="frequency [Hz],Re a1 [m/s^2/N],Im a1 [m/s^2/N]", comments="")
    elif path.suffix == ".mat":
        from scipy.io import savemat

        savemat(path, {"frequency": f, "frf": values[:, None]})
    else:
        head = ["    -1", "    58", "a1", "NONE", "26-Nov-26 10:00:00", "NONE", "NONE"]
        head += [f"{4:5d}{0:10d}{0:5d}{0:10d} {'NONE':10s}{1:10d}{-3:4d} {'NONE':10s}{1:10d}{3:4d}"]
        head += [f"{5:10d}{f.size:10d}{1:10d}{f[0]:13.5E}{f[1] - f[0]:13.5E}{0:13.5E}"]
        axes = ((18, "Frequency", "Hz"), (12, "Acceleration", "m/s^2"), (13, "Force", "N"), (0, "NONE", "NONE"))
        head += [f"{code:10d}{0:5d}{0:5d}{0:5d} {name:20s} {unit:20s}" for code, name, unit in axes]
        flat = np.column_stack([values.real, values.imag]).ravel()
        rows_ = ["".join(f"{v:13.5E}" for v in flat[k : k + 6]) for k in range(0, flat.size, 6)]
        path.write_text("\n".join([*head, *rows_, "    -1"]) + "\n")


def test_every_rejection_says_what_to_do(tmp_path: Path) -> None:
    for text in ("time,force,a1\n0,1,2\n1,x,3\n2,1,2\n", "time,force\n0,1\n1,2\n", "a;b\n"):
        with pytest.raises(ModallabError) as caught:
            read(tmp_path, text)
        assert caught.value.remedy


NO_HEADER = table("", PLAIN).lstrip("\n")


def test_the_columns_of_a_table_without_a_header_can_be_said_for_a_rig_too(tmp_path: Path) -> None:
    path = tmp_path / "hit.csv"
    path.write_text(table("", PLAIN + ",7").lstrip("\n"), encoding="utf-8")
    options = ImportOptions(columns="time,force:kN,tip:g,")
    rig = draft_rig(path, options)
    assert [(c.name, c.quantity, c.unit) for c in rig.channels] == [
        ("force", "force", "kN"),
        ("tip", "acceleration", "g"),
    ]
    (block,) = import_sources([path], rig, options).blocks
    np.testing.assert_allclose(block.samples, [FORCE, MOTION], atol=1e-6)


@pytest.mark.parametrize("said", ["", "time,force:N"])
def test_a_table_without_a_header_is_rejected_with_the_option_that_helps(tmp_path: Path, said: str) -> None:
    path = tmp_path / "hit.csv"
    path.write_text(NO_HEADER, encoding="utf-8")
    with pytest.raises(DataError, match=r"no header|has 3 columns, and --columns names 2") as caught:
        draft_rig(path, ImportOptions(columns=said))
    assert "--columns" in str(caught.value.remedy) + caught.value.what


def test_what_is_said_of_the_columns_of_frfs_stands_instead_of_their_header(tmp_path: Path) -> None:
    lines = np.linspace(1, 100, 50)
    path = tmp_path / "frf.csv"
    path.write_text("".join(f"{f},{f / 2},{-f}\n" for f in lines), encoding="utf-8")
    options = ImportOptions(columns="frequency:Hz,Re a1:g/N,Im a1")
    (frf,) = import_sources([path], draft_rig(path, options), options).frfs
    np.testing.assert_allclose(frf.values[0, 0], 9.80665 * (lines / 2 - 1j * lines))


def test_words_below_the_table_are_left_out_with_a_note(tmp_path: Path) -> None:
    head = "Title:\tx\t \n\nTime:\t\t10:49:15:530\n"
    path = tmp_path / "hit.txt"
    path.write_text(head + table("", "{}\t{:.6f}\t{:.6f}").lstrip("\n") + "TagsEnd:\t \t\n", encoding="utf-8")
    with pytest.raises(FormatError, match="3 columns, and no line above it names as many"):
        import_sources([path], RIG)
    campaign = import_sources([path], RIG, ImportOptions(columns="time,force,a1"))
    np.testing.assert_allclose(campaign.blocks[0].samples, [FORCE, MOTION], atol=1e-6)
    assert "below the table, from line 404, 'TagsEnd:'" in campaign.provenance["notes"]
