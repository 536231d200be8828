"""Measurement files of LabVIEW, after NI's specification of the format (versions 1 and 2)."""

from pathlib import Path

import numpy as np
from known import RATE, G, Known, case, hit, moved

END = "***End_of_Header***"


def head(
    separator: str = "\t", columns: str = "One", decimal: str = ".", multi: str = "No", version: int = 2
) -> list[str]:
    word = {"\t": "Tab", ",": "Comma"}[separator]
    lines = [["LabVIEW Measurement", ""], ["Writer_Version", "2" if version == 2 else "0.92"], ["Reader_Version", "1"]]
    lines += [["Separator", word], ["Multi_Headings", multi], ["X_Columns", columns], ["Time_Pref", "Absolute"]]
    lines += [["Decimal_Separator", decimal]] if version == 2 else []
    lines += [["Operator", "somebody"], ["Date", "2026/03/29"], ["Time", f"10:00:00{decimal}125"], [END, ""], [""]]
    return [separator.join(line) for line in lines]


def number(value: float, decimal: str = ".") -> str:
    return f"{value:.7E}".replace(".", decimal)


def segment(
    rows: list[np.ndarray],
    columns: str = "One",
    separator: str = "\t",
    decimal: str = ".",
    x0: tuple[float, ...] = (0, 0, 0),
    delta: tuple[float, ...] = (1 / RATE,) * 3,
    units: tuple[str, ...] = ("N", "m/s^2", "m/s^2"),
    names: tuple[str, ...] = ("force", "a1", "a2"),
    comments: dict[int, str] | None = None,
) -> list[str]:
    """One segment; with columns `Multi` each channel has its X before it, with `No` the first column is empty."""
    pad = [""] if columns != "Multi" else []
    double = columns == "Multi"

    def tag(word: str, values: tuple[str, ...]) -> str:
        cells = [c for v in values for c in ((v, "") if double else (v,))]
        return separator.join([word, *cells])

    x = [tuple(x0[k] + delta[k] * np.arange(len(row))) for k, row in enumerate(rows)]
    lines = [separator.join(["Channels", str(len(rows))]), tag("Samples", tuple(str(len(r)) for r in rows))]
    lines += [tag("Date", ("2026/03/29",) * len(rows)), tag("Time", (f"10:00:01{decimal}5",) * len(rows))]
    lines += [tag("Y_Unit_Label", units), tag("X_Dimension", ("Time",) * len(rows))]
    lines += [
        tag("X0", tuple(number(v, decimal) for v in x0)),
        tag("Delta_X", tuple(number(v, decimal) for v in delta)),
    ]
    lines += [separator.join([END] + [""] * len(rows))]
    headings = [c for name in names for c in ("X_Value", name)] if double else ["X_Value", *names]
    lines.append(separator.join([*headings, "Comment"]))
    for i in range(max(len(r) for r in rows)):
        cells = [number(x[0][i], decimal) if columns == "One" else ""] if pad else []
        for k, row in enumerate(rows):
            there = i < len(row)
            cells += ([number(x[k][i], decimal) if there else ""] if double else []) + [
                number(row[i], decimal) if there else ""
            ]
        lines.append(separator.join([*cells, (comments or {}).get(i, "")]))
    return [*lines, ""]


def save(folder: Path, lines: list[str]) -> tuple[str, ...]:
    (folder / "case.lvm").write_text("\r\n".join(lines) + "\r\n", encoding="latin-1", newline="")
    return ("case.lvm",)


@case("lvm")
def lvm_comma_version_1(folder: Path) -> Known:
    """Version 1: comma between columns, no Decimal_Separator, X_Columns No."""
    record = hit()
    lines = head(",", "No", version=1) + segment(list(record.rows), "No", ",")
    return Known(save(folder, lines), (record,))


@case("lvm")
def lvm_multi(folder: Path) -> Known:
    """X_Columns Multi: an X before each channel."""
    record = hit()
    return Known(save(folder, head(columns="Multi") + segment(list(record.rows), "Multi")), (record,))


@case("lvm")
def lvm_multi_later(folder: Path) -> Known:
    """X_Columns Multi, each channel with an X0 of its own: 0, 2 and 5 samples."""
    rows, right = moved(hit(), (0, 2, 5))
    lines = segment(rows, "Multi", x0=(0, 2 / RATE, 5 / RATE))
    return Known(save(folder, head(columns="Multi") + lines), (right,))


@case("lvm")
def lvm_no_columns_later(folder: Path) -> Known:
    """X_Columns No: the X0 of the second channel is 3 samples, its column begins with the first row."""
    rows, right = moved(hit(), (0, 3, 0))
    lines = segment(rows, "No", x0=(0, 3 / RATE, 0))
    return Known(save(folder, head(columns="No") + lines), (right.part(0),))


@case("lvm")
def lvm_special_block(folder: Path) -> Known:
    """A special block of another program between the headers, with rows of numbers in it."""
    record = hit()
    special = ["***Start_Special***", "Gain\t1.0\t2.0\t3.0", "1.0\t2.0\t3.0\t4.0", "***End_Special***", ""]
    return Known(save(folder, head() + special + segment(list(record.rows))), (record,))


@case("lvm")
def lvm_two_segments_other_channels(folder: Path) -> Known:
    """Two segments, decimal comma, the second with its channels in another order, and comments in rows."""
    one, two = hit(1), hit(2)
    said = {0: "hit no. 1,5 of 2", 40: "3.5"}
    lines = head(decimal=",", multi="Yes") + segment(list(one.rows), decimal=",", comments=said)
    rows = [two.a2, two.force, two.a1]
    lines += segment(rows, decimal=",", names=("a2", "force", "a1"), units=("m/s^2", "N", "m/s^2"))
    return Known(save(folder, lines), (one, two))


@case("lvm")
def lvm_slow_channel(folder: Path) -> Known:
    """A fourth channel with 16 samples at a 64th of the rate, its cells empty after them."""
    record = hit()
    rows = [*record.rows, np.linspace(20, 21, 16)]
    lines = segment(
        rows,
        "No",
        x0=(0,) * 4,
        delta=(1 / RATE,) * 3 + (64 / RATE,),
        units=("N", "m/s^2", "m/s^2", "degC"),
        names=("force", "a1", "a2", "temperature"),
    )
    return Known(save(folder, head(columns="No") + lines), (record,), says="temperature")


@case("lvm")
def lvm_units(folder: Path) -> Known:
    """Units that differ: kN, g, mm/s^2; decimal comma; the X column begins before the trigger."""
    record = hit()
    rows = [record.force / 1e3, record.a1 / G, record.a2 * 1e3]
    lines = segment(rows, decimal=",", x0=(-0.03,) * 3, units=("kN", "g", "mm/s^2"))
    return Known(save(folder, head(decimal=",") + lines), (record,))


@case("lvm")
def lvm_without_header(folder: Path) -> Known:
    """Saved with 'No headers': rows of X and channels, and nothing else."""
    record = hit()
    rows = [
        f"{t:.6f}\t" + "\t".join(f"{v:.6f}" for v in row) for t, row in zip(record.time, record.rows.T, strict=True)
    ]
    return Known(save(folder, rows), (record,))


@case("lvm")
def lvm_one_header(folder: Path) -> Known:
    """'One header only': a second segment follows without a header, its X begins again at 0."""
    one, two = hit(1), hit(2)
    lines = head() + segment(list(one.rows)) + segment(list(two.rows))[10:]
    reason = r"(?i)line \d+|segment|header|begin|ascend|back"
    return Known(save(folder, lines), (one, two), rejected=reason)


@case("lvm")
def lvm_few_digits_of_delta(folder: Path) -> Known:
    """Version 1: 1024 Hz, of which Delta_X says 0.000977; X_Columns No."""
    record = hit(rate=1024.0)
    lines = head(columns="No", version=1) + segment(list(record.rows), "No")
    lines = [line.replace(number(1 / RATE), "0.000977") if line.startswith("Delta_X") else line for line in lines]
    return Known(save(folder, lines), (record,))


@case("lvm")
def lvm_notes_and_empty_channels(folder: Path) -> Known:
    """A segment's header begins with notes, and lists a channel without samples; version 1, decimal comma unsaid."""
    one, two = hit(1), hit(2)
    lines = head(multi="Yes", version=1)
    for record in (one, two):
        rows = [record.force, np.empty(0), record.a1, record.a2]
        facts = {"x0": (0,) * 4, "delta": (1 / RATE, 1.0, 1 / RATE, 1 / RATE), "units": ("N", "", "m/s^2", "m/s^2")}
        part = segment(rows, decimal=",", names=("force", "Untitled", "a1", "a2"), **facts)
        lines += ["Notes\tX values guaranteed valid only for force", *part]
    return Known(save(folder, lines), (one, two))
