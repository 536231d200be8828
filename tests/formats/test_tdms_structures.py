"""Legal structures of TDMS files: all are read alike, and what is none of the test is left out by name."""

from pathlib import Path

import numpy as np
import pytest
from exchange_records import RATE_HZ, hit
from exchange_rigs import beam_rig
from tdms_files import BIG, INTERLEAVED, META, NEW, RAW, channel, segment

from modallab.core.errors import DataError, FormatError
from modallab.formats.importer import draft_rig, import_sources
from modallab.formats.options import ImportOptions

RIG = beam_rig()
ROWS = dict(zip((c.name for c in RIG.channels), hit(4), strict=True))
STEP = {"wf_increment": 1 / RATE_HZ}
SLOW = segment(
    [channel("/'ambient'/'temperature'", np.linspace(12, 13, 60), {"wf_increment": 1.0})],
    np.linspace(12, 13, 60).tobytes(),
)


def plain(group: str = "hit") -> bytes:
    objects = [channel(f"/'{group}'/'{name}'", row, STEP) for name, row in ROWS.items()]
    return segment(objects, b"".join(row.tobytes() for row in ROWS.values()))


def interleaved() -> bytes:
    objects = [channel(f"/'hit'/'{name}'", row, STEP) for name, row in ROWS.items()]
    return segment(objects, np.stack(list(ROWS.values()), axis=1).tobytes(), flags=META | NEW | RAW | INTERLEAVED)


def big_endian() -> bytes:
    objects = [channel(f"/'hit'/'{name}'", row, STEP, order=">") for name, row in ROWS.items()]
    return segment(
        objects, b"".join(row.astype(">f8").tobytes() for row in ROWS.values()), flags=META | NEW | RAW | BIG
    )


def chunked() -> bytes:
    objects = [channel(f"/'hit'/'{name}'", row, STEP, count=64) for name, row in ROWS.items()]
    return segment(objects, b"".join(row[k : k + 64].tobytes() for k in range(0, 256, 64) for row in ROWS.values()))


def empty_with_flag() -> bytes:
    """Properties first, with the flag of raw data and none there."""
    return segment([channel("/", said={"author": "somebody"})]) + plain()


def a_group_for_each_channel() -> bytes:
    return b"".join(
        segment([channel(f"/'module {k}'/'{name}'", row, STEP)], row.tobytes())
        for k, (name, row) in enumerate(ROWS.items())
    )


def continued() -> bytes:
    """A second segment without metadata, which repeats the structure of the first."""
    first = [row[:128].copy() for row in ROWS.values()]
    objects = [channel(f"/'hit'/'{n}'", row, STEP) for n, row in zip(ROWS, first, strict=True)]
    rest = b"".join(row[128:].tobytes() for row in ROWS.values())
    lead = b"TDSm" + np.array([RAW, 4713], "<u4").tobytes() + np.array([len(rest), 0], "<u8").tobytes()
    return segment(objects, b"".join(row.tobytes() for row in first)) + lead + rest


MAKERS = [plain, interleaved, big_endian, chunked, empty_with_flag, a_group_for_each_channel, continued]


@pytest.mark.parametrize("slow", [False, True], ids=["alone", "beside a slow group"])
@pytest.mark.parametrize("make", MAKERS)
def test_every_legal_structure_gives_the_same_record(tmp_path: Path, make, slow: bool) -> None:
    path = tmp_path / "c.tdms"
    path.write_bytes(make() + (SLOW if slow else b""))
    found = import_sources([path], RIG)
    (block,) = found.blocks
    np.testing.assert_array_equal(block.samples, np.stack(list(ROWS.values())))
    assert block.rate_hz == RATE_HZ
    assert ("left out of group ambient: temperature (1 Hz)" in found.provenance.get("notes", "")) == slow


def test_channels_without_a_rate_have_that_of_the_others_and_a_note_says_so(tmp_path: Path) -> None:
    path = tmp_path / "c.tdms"
    objects = [channel(f"/'hit'/'{name}'", row, STEP if name == "force" else {}) for name, row in ROWS.items()]
    path.write_bytes(segment(objects, b"".join(row.tobytes() for row in ROWS.values())))
    found = import_sources([path], RIG)
    assert found.blocks[0].rate_hz == RATE_HZ
    assert "no rate is written of a01, a02, a03: taken at that of the others" in found.provenance["notes"]


def test_a_rig_is_drafted_from_the_fast_group_or_from_the_one_that_is_chosen(tmp_path: Path) -> None:
    path = tmp_path / "c.tdms"
    path.write_bytes(SLOW + plain())
    assert [c.name for c in draft_rig(path).channels] == list(ROWS)
    assert [c.name for c in draft_rig(path, ImportOptions(group="ambient")).channels] == ["temperature"]
    with pytest.raises(DataError, match="has no group 'ambien'"):
        import_sources([path], RIG, ImportOptions(group="ambien"))


def test_one_of_several_tests_in_a_file_is_chosen_by_its_group(tmp_path: Path) -> None:
    path = tmp_path / "c.tdms"
    path.write_bytes(plain("first") + plain("second"))
    assert [b.name for b in import_sources([path], RIG).blocks] == ["first", "second"]
    assert [b.name for b in import_sources([path], RIG, ImportOptions(group="second")).blocks] == ["second"]


def test_whole_numbers_of_any_type_keep_their_value_and_scale(tmp_path: Path) -> None:
    path, scale = tmp_path / "c.tdms", 0.01
    counts = {name: np.round(row / scale + 30000).astype("u2") for name, row in ROWS.items()}
    said = STEP | {"NI_Number_Of_Scales": 1.0, "NI_Scaling_Status": "unscaled", "NI_Scale[0]_Scale_Type": "Linear"}
    said |= {"NI_Scale[0]_Linear_Slope": scale, "NI_Scale[0]_Linear_Y_Intercept": -300.0}
    objects = [channel(f"/'hit'/'{name}'", row, said) for name, row in counts.items()]
    path.write_bytes(segment(objects, b"".join(row.tobytes() for row in counts.values())))
    (block,) = import_sources([path], RIG).blocks
    np.testing.assert_allclose(block.samples * block.scale[:, None], np.stack(list(ROWS.values())), atol=scale)


def test_a_scale_that_nobody_knows_is_no_scale_of_one(tmp_path: Path) -> None:
    path = tmp_path / "c.tdms"
    said = STEP | {"NI_Scaling_Status": "unscaled", "NI_Scale[0]_Scale_Type": "Sine", "NI_Number_Of_Scales": 1.0}
    objects = [channel(f"/'hit'/'{name}'", row, said) for name, row in ROWS.items()]
    path.write_bytes(segment(objects, b"".join(row.tobytes() for row in ROWS.values())))
    with pytest.raises(DataError, match="scaled by Sine, which is not known"):
        import_sources([path], RIG)


def test_a_file_that_was_never_finished_says_so(tmp_path: Path) -> None:
    path, content = tmp_path / "c.tdms", bytearray(plain())
    content[12:20] = b"\xff" * 8
    path.write_bytes(content)
    with pytest.raises(FormatError, match="never finished"):
        import_sources([path], RIG)


def test_the_user_says_which_channel_is_which(tmp_path: Path) -> None:
    (tmp_path / "x.tdms").write_bytes(plain())
    turned = {"force": "a01", "a01": "force"}
    options = ImportOptions(variables=tuple(turned.items()))
    (as_named,), (as_said,) = (import_sources([tmp_path / "x.tdms"], RIG, o).blocks for o in (ImportOptions(), options))
    np.testing.assert_array_equal(as_said.samples[[1, 0]], as_named.samples[[0, 1]])
