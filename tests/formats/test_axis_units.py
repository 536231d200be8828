"""What a file says of its abscissa: the unit of its times or frequencies, and that it is one of them."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from exchange_records import RATE_HZ, hit, uff_set, write_uff
from exchange_rigs import plain_rig
from scipy.io import savemat
from tdms_files import channel, segment

from modallab.core.errors import DataError, FormatError
from modallab.formats.importer import draft_rig, import_sources
from modallab.formats.options import ImportOptions

RIG = plain_rig("a1")
LINES = np.arange(10.0, 74.0)


def tdms(path: Path, unit: str, step: float, group: str = "hit") -> bytes:
    said = {"wf_increment": step, "wf_xunit_string": unit}
    rows = zip(("force", "a1"), ("N", "g"), hit(2), strict=True)
    objects = [(channel(f"/'{group}'/'{n}'", r, said | {"unit_string": u}), r.tobytes()) for n, u, r in rows]
    content = segment([channel("/"), channel(f"/'{group}'"), *(o for o, _ in objects)], b"".join(r for _, r in objects))
    path.write_bytes(content)
    return content


def lvm(path: Path, dimension: str, unit: str, step: float) -> Path:
    head = ["LabVIEW Measurement", "Separator\tTab", "X_Columns\tNo", "***End_of_Header***", "Channels\t2"]
    facts = [("X_Dimension", dimension), ("X_Unit_Label", unit), ("Delta_X", f"{step}")]
    head += [f"{name}\t{value}\t{value}" for name, value in facts] + ["***End_of_Header***", "X_Value\tforce\ta1"]
    rows = ["\t" + "\t".join(f"{v:.9g}" for v in row) for row in hit(2).T]
    path.write_text("\n".join([*head, *rows]) + "\n", encoding="utf-8")
    return path


def test_times_in_ms_are_times(tmp_path: Path) -> None:
    tdms(tmp_path / "a.tdms", "ms", 1e3 / RATE_HZ)
    lvm(tmp_path / "a.lvm", "Time", "ms", 1e3 / RATE_HZ)
    for name in ("a.tdms", "a.lvm"):
        (block,) = import_sources([tmp_path / name], RIG).blocks
        assert block.rate_hz == RATE_HZ
        np.testing.assert_allclose(block.samples * block.scale[:, None], hit(2), rtol=1e-7)


def test_spectra_are_no_records(tmp_path: Path) -> None:
    spectra = tdms(tmp_path / "a.tdms", "Hz", 0.5, "spectra")
    with pytest.raises(DataError, match="'Hz' is no unit of time"):
        import_sources([tmp_path / "a.tdms"], RIG)
    with pytest.raises(DataError, match="channel force is over Frequency"):
        import_sources([lvm(tmp_path / "a.lvm", "Frequency", "Hz", 0.5)], RIG)
    both = tmp_path / "both.tdms"
    both.write_bytes(tdms(both, "s", 1 / RATE_HZ) + spectra)
    assert [c.name for c in draft_rig(both, ImportOptions()).channels] == ["force", "a1"]


def frfs(path: Path, unit: str, step: float) -> Path:
    values = 1 / (40.0**2 - LINES**2 + 2j * LINES)
    write_uff(path, uff_set(values, LINES * step, 4))
    # The label of the abscissa is the first of the four lines of axes.
    lines = path.read_bytes().split(b"\n")
    place = next(k for k, line in enumerate(lines) if line.startswith(b"        18"))
    lines[place] = f"{18:10d}{0:5d}{0:5d}{0:5d} {'Frequency':20s} {unit:20s}".encode()
    path.write_bytes(b"\n".join(lines))
    return path


@pytest.mark.parametrize(("unit", "step"), [("Hz", 1.0), ("kHz", 1e-3), ("rad/s", 2 * np.pi), ("NONE", 1.0)])
def test_frequencies_of_a_universal_file_are_in_the_unit_of_its_label(tmp_path: Path, unit: str, step: float) -> None:
    (frf,) = import_sources([frfs(tmp_path / "a.uff", unit, step)], RIG).frfs
    np.testing.assert_allclose(frf.frequency_hz, LINES, rtol=1e-5)


def test_frfs_over_a_speed_are_rejected(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="'rpm' is no unit of frequency"):
        import_sources([frfs(tmp_path / "a.uff", "rpm", 60.0)], RIG)


def test_a_rate_that_contradicts_the_times_is_rejected(tmp_path: Path) -> None:
    content: dict[str, Any] = dict(zip(("force", "a1"), hit(2), strict=True))
    savemat(tmp_path / "a.mat", content | {"t": np.arange(256) / 1000, "fs": RATE_HZ})
    with pytest.raises(DataError, match="times say 1000 Hz, and beside them stands a rate of 2000 Hz"):
        import_sources([tmp_path / "a.mat"], RIG)
    (block,) = import_sources([tmp_path / "a.mat"], RIG, ImportOptions(variables=(("time", "t"),))).blocks
    assert block.rate_hz == 1000


@pytest.mark.parametrize("head", ["% time force a1\n% ms kN g", "ms kN g\ntime force a1", "time force a1\nms kN g"])
def test_a_line_of_units_counts_in_comments_and_above_the_names(tmp_path: Path, head: str) -> None:
    rows = [f"{1e3 * k / RATE_HZ:.3f} {f:.9g} {a:.9g}" for k, (f, a) in enumerate(hit(2).T)]
    (tmp_path / "a.txt").write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")
    (block,) = import_sources([tmp_path / "a.txt"], RIG, ImportOptions()).blocks
    assert (block.rate_hz, block.units) == (RATE_HZ, ("kN", "g"))


def test_a_mark_that_may_be_of_thousands_is_asked_for(tmp_path: Path) -> None:
    cells = ((f"{k / RATE_HZ:.4f}", f"1.{100 + k}", f"{a:.6f}") for k, a in enumerate(hit(1)[0]))
    rows = [f"{t.replace('.', ',')};{f};{a.replace('.', ',')}" for t, f, a in cells]
    (tmp_path / "a.csv").write_text("\n".join(["time [s];force [N];a1 [g]", *rows]) + "\n", encoding="utf-8")
    with pytest.raises(FormatError, match="beside numbers with decimal ',' may be in thousands"):
        import_sources([tmp_path / "a.csv"], RIG)
