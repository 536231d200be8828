"""SEP005: time series as a list in JSON, after the guideline of SDyPy."""

import json
from pathlib import Path

import numpy as np
from known import RATE, G, Known, Record, case, hit, moved

NAMES = ("force", "a1", "a2")
UNITS = ("N", "m/s^2", "m/s^2")


def save(folder: Path, series: list[dict] | dict) -> tuple[str, ...]:
    (folder / "case.json").write_text(json.dumps(series), encoding="utf-8")
    return ("case.json",)


def listed(rows: list[np.ndarray], units: tuple[str, ...] = UNITS, **more: object) -> list[dict]:
    return [
        {"data": row.tolist(), "name": name, "unit_str": unit, "fs": RATE} | more
        for row, name, unit in zip(rows, NAMES, units, strict=True)
    ]


@case("sep005")
def sep_starts(folder: Path) -> Known:
    """start_timestamp with a zone, 0, 3 and 0 samples."""
    rows, right = moved(hit(), (0, 3, 0))
    series = listed(rows)
    for entry, later in zip(series, (0, 3, 0), strict=True):
        entry["start_timestamp"] = f"2026-03-29T10:00:00.{later * 500:06d}+00:00"
    return Known(save(folder, series), (right,))


@case("sep005")
def sep_times(folder: Path) -> Known:
    """`time` in place of `fs`, units kN and g."""
    record = hit()
    series = listed([record.force / 1e3, record.a1 / G, record.a2 / G], ("kN", "g", "g"))
    for entry in series:
        del entry["fs"]
        entry["time"] = record.time.tolist()
    return Known(save(folder, series), (record,))


@case("sep005")
def sep_groups(folder: Path) -> Known:
    """Two groups, each a hit, entries mixed."""
    one, two = (listed(list(hit(k).rows), group=f"hit {k}") for k in (1, 2))
    return Known(save(folder, [e for pair in zip(one, two, strict=True) for e in pair]), (hit(1), hit(2)))


@case("sep005")
def sep_rates_differ(folder: Path) -> Known:
    """One series of another rate."""
    record: Record = hit()
    series = listed(list(record.rows))
    series[2] |= {"fs": RATE / 2, "data": series[2]["data"][::2]}
    return Known(save(folder, series), rejected=r"(?is)a2.*(1000|rate)|(1000|rate).*a2")
