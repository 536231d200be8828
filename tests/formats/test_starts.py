"""Channels that begin at different times: aligned in every format that says so, or rejected."""

import json
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from exchange_records import RATE_HZ, hit, uff_set, write_uff
from exchange_rigs import beam_rig
from scipy.io import savemat
from tdms_files import channel, segment

from modallab.core.errors import DataError
from modallab.formats.importer import import_sources

RIG = beam_rig()
NAMES = tuple(c.name for c in RIG.channels)
UNITS = tuple(c.unit for c in RIG.channels)
SECONDS = 3_800_000_000
"""As many since 1904 in November 2024: a double has steps of half a microsecond there."""


def tdms_stamp(path: Path, rows: list[Any], starts: list[float]) -> Path:
    stamps = [(SECONDS + int(0.25 + s), int((0.25 + s) % 1 * 2**64)) for s in starts]
    objects = [
        channel(f"/'hit'/'{n}'", r, {"wf_increment": 1 / RATE_HZ, "wf_start_time": s})
        for n, r, s in zip(NAMES, rows, stamps, strict=True)
    ]
    path.write_bytes(segment(objects, b"".join(r.tobytes() for r in rows)))
    return path


def tdms_offset(path: Path, rows: list[Any], starts: list[float]) -> Path:
    said = [{"wf_increment": 1 / RATE_HZ, "wf_start_offset": s, "wf_start_time": (SECONDS, 0)} for s in starts]
    objects = [channel(f"/'hit'/'{n}'", r, p) for n, r, p in zip(NAMES, rows, said, strict=True)]
    path.write_bytes(segment(objects, b"".join(r.tobytes() for r in rows)))
    return path


def sep005(path: Path, rows: list[Any], starts: list[float]) -> Path:
    begin = datetime(2026, 11, 26, 10, tzinfo=UTC)
    series = [
        {
            "name": n, "unit_str": u, "fs": RATE_HZ, "data": r.tolist(),
            "start_timestamp": (begin + timedelta(seconds=s)).isoformat(timespec="microseconds"),
        }
        for n, u, r, s in zip(NAMES, UNITS, rows, starts, strict=True)
    ]  # fmt: skip
    path.write_text(json.dumps(series))
    return path


def sep005_times(path: Path, rows: list[Any], starts: list[float]) -> Path:
    series = [
        {"name": n, "unit_str": u, "time": (s + np.arange(len(r)) / RATE_HZ).tolist(), "data": r.tolist()}
        for n, u, r, s in zip(NAMES, UNITS, rows, starts, strict=True)
    ]
    path.write_text(json.dumps(series))
    return path


def mat_times(path: Path, rows: list[Any], starts: list[float]) -> Path:
    each = zip(NAMES, rows, starts, strict=True)
    savemat(path, {n: {"data": r, "time": s + np.arange(len(r)) / RATE_HZ} for n, r, s in each})
    return path


def mat_numbers(path: Path, rows: list[Any], starts: list[float]) -> Path:
    content: dict[str, Any] = {"fs": RATE_HZ}
    for n, r, s in zip(NAMES, rows, starts, strict=True):
        content |= {n: r, f"{n}_t0": s}
    savemat(path, content)
    return path


def uff(path: Path, rows: list[Any], starts: list[float]) -> Path:
    force = {"ordinate_axis_units_lab": "N", "ordinate_spec_data_type": 13}
    return write_uff(
        path,
        *(
            uff_set(r, s + np.arange(len(r)) / RATE_HZ, 1, rsp_node=k, rsp_dir=3 if k else 0, **({} if k else force))
            for k, (r, s) in enumerate(zip(rows, starts, strict=True))
        ),
    )


MAKERS: dict[str, Callable[[Path, list[Any], list[float]], Path]] = {
    "stamp.tdms": tdms_stamp,
    "offset.tdms": tdms_offset,
    "stamp.json": sep005,
    "times.json": sep005_times,
    "times.mat": mat_times,
    "numbers.mat": mat_numbers,
    "record.uff": uff,
}
LATE = 6


@pytest.mark.parametrize("name", MAKERS)
def test_samples_of_one_moment_stand_in_one_column(tmp_path: Path, name: str) -> None:
    whole = hit(4)
    rows = [row[LATE:].copy() if k == 2 else row[: 256 - LATE].copy() for k, row in enumerate(whole)]
    found = import_sources([MAKERS[name](tmp_path / name, rows, [0.0, 0.0, LATE / RATE_HZ, 0.0])], RIG)
    (block,) = found.blocks
    np.testing.assert_allclose(block.samples, whole[:, LATE : 256 - LATE], rtol=0, atol=1e-9)
    assert "begin at different times" in found.provenance["notes"]


@pytest.mark.parametrize("name", MAKERS)
def test_records_that_share_no_moment_are_rejected(tmp_path: Path, name: str) -> None:
    rows = list(hit(4))
    with pytest.raises(DataError, match=r"do not overlap: a02.* begins 0\.2 s after the first"):
        import_sources([MAKERS[name](tmp_path / name, rows, [0.0, 0.0, 0.2, 0.0])], RIG)


@pytest.mark.parametrize("name", ["stamp.tdms", "offset.tdms", "times.mat", "numbers.mat"])
def test_a_part_of_a_sample_is_taken_off_as_a_delay(tmp_path: Path, name: str) -> None:
    """A sine of a tenth of the rate, sampled from 6.4 samples later on: its phase comes back to 0.01 degrees."""
    n, late = 400, 6.4
    phase = 2 * np.pi * 0.1 * np.arange(n)
    noise = np.random.default_rng(1).normal(0, 1e-6, (4, n))
    rows = [np.sin(phase) + noise[k] for k in range(4)]
    rows[2] = np.sin(phase + 2 * np.pi * 0.1 * late) + noise[2]
    (block,) = import_sources([MAKERS[name](tmp_path / name, rows, [0.0, 0.0, late / RATE_HZ, 0.0])], RIG).blocks
    used = block.samples[:, 60:300]
    turn = np.exp(-2j * np.pi * 0.1 * np.arange(used.shape[1]))
    phases = np.angle(used @ turn)
    assert np.abs(np.degrees(phases - phases[2])).max() < 0.01


def test_a_whole_second_without_its_zeros_is_as_exact_as_the_others(tmp_path: Path) -> None:
    path = sep005(
        tmp_path / "c.json", [row[k:] for row, k in zip(hit(4), (0, 3, 0, 0), strict=True)], [0, 0.0015, 0, 0]
    )
    path.write_text(path.read_text().replace("10:00:00.000000", "10:00:00"))
    (block,) = import_sources([path], RIG).blocks
    np.testing.assert_array_equal(block.samples, hit(4)[:, 3:])


def test_starts_written_too_coarsely_are_rejected(tmp_path: Path) -> None:
    path = sep005(tmp_path / "c.json", list(hit(4)), [0.0, 0.0, 0.0, 0.0])
    text = path.read_text().replace("10:00:00.000000", "10:00:00")
    path.write_text(text)
    assert len(import_sources([path], RIG).blocks) == 1
    path.write_text(text.replace("10:00:00", "10:00:01", 1))
    with pytest.raises(DataError, match=r"written to 1 s where a sample lasts 0\.0005 s"):
        import_sources([path], RIG)


def test_a_channel_that_says_no_start_beside_others_that_differ_is_rejected(tmp_path: Path) -> None:
    path = sep005(tmp_path / "c.json", list(hit(4)), [0.0, 0.001, 0.001, 0.001])
    series = json.loads(path.read_text())
    del series[3]["start_timestamp"]
    path.write_text(json.dumps(series))
    with pytest.raises(DataError, match="a03 says none"):
        import_sources([path], RIG)
