"""Files that were cut off or whose bytes were changed: an expected error or a campaign, never anything else."""

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from exchange_records import DATA, campaign, hit, times, write_hit_uff
from exchange_rigs import beam_rig
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from modallab.core.block import Campaign
from modallab.core.errors import ModallabError
from modallab.formats.campaign.campaign_hdf5 import read_campaign, write_campaign
from modallab.formats.importer import import_sources

RIG = beam_rig()
ROWS = np.vstack([times(), hit(4)])


def make_npy(path: Path) -> None:
    with path.open("wb") as target:
        np.save(target, ROWS)


def make_csv(path: Path) -> None:
    np.savetxt(path, ROWS.T, delimiter=";", header="time;force;a01;a02;a03", comments="", fmt="%.7g")


def make_counts(path: Path) -> None:
    path.write_bytes((DATA / "campaign_v1" / "campaign.h5").read_bytes())


def make_native(path: Path) -> None:
    write_campaign(campaign(RIG, provenance={"seed": "1"}), path)


def make_uff(path: Path) -> None:
    write_hit_uff(path, hit(4))


def make_uff_binary(path: Path) -> None:
    write_hit_uff(path, hit(4), binary=True)


MAKERS = [make_npy, make_csv, make_counts, make_native, make_uff, make_uff_binary]


def damaged(data: st.DataObject, whole: bytes) -> bytes:
    content = bytearray(whole)
    # The beginning, where the structure stands, is hit as often as all the rest.
    place = st.one_of(st.integers(0, min(2000, len(whole) - 1)), st.integers(0, len(whole) - 1))
    for _ in range(data.draw(st.integers(0, 3), label="changes")):
        content[data.draw(place)] = data.draw(st.integers(0, 255))
    keep = data.draw(st.one_of(st.just(len(whole)), st.integers(0, len(whole))), label="keep")
    return bytes(content[:keep])


@pytest.mark.parametrize("make", MAKERS)
@settings(max_examples=60, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_damage_raises_nothing_but_expected_errors(
    tmp_path: Path, make: Callable[[Path], None], data: st.DataObject
) -> None:
    path = tmp_path / "record"
    make(path)
    path.write_bytes(damaged(data, path.read_bytes()))
    with suppress(ModallabError):
        import_sources([path], RIG)


def contents(read: Campaign) -> list[object]:
    return [
        (b.name, b.rate_hz, b.samples.tobytes(), b.scale.tobytes(), b.units, b.channels, b.order) for b in read.blocks
    ] + [read.rig, read.provenance]


@pytest.mark.thorough("reads a file that is damaged in hundreds of ways")
@settings(
    max_examples=150, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(data=st.data())
def test_a_campaign_of_version_2_is_read_as_it_was_written_or_rejected(tmp_path: Path, data: st.DataObject) -> None:
    path = tmp_path / "c.h5"
    make_native(path)
    whole = contents(read_campaign(path))
    path.write_bytes(damaged(data, path.read_bytes()))
    with suppress(ModallabError):
        assert contents(read_campaign(path)) == whole
