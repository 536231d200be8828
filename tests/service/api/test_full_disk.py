"""The data folder on a disk of 6 MB: the run fails as it should, what was acknowledged is whole, the service lives."""

import shutil
import subprocess
import zlib
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest
from lab import RIG, Lab

from modallab.core.rig import Rig

API = "/api/v1"
SHORT = {"plan": {"kind": "impact", "points": [10, 6, 3], "hits": 8}}
LONG = {"plan": {"kind": "impact", "points": [10, 6, 3], "hits": 200}}


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A file system of 6 MB."""
    folder = tmp_path / "disk"
    folder.mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=6m", "tmpfs", str(folder)], check=True, capture_output=True)
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=True)


def test_a_full_disk_fails_the_run_and_nothing_else(small_disk: Path, link_rig: Rig) -> None:
    url = "sim://cantilever?seed=1&zeta=0.05&bad_hits=0"
    with Lab(small_disk / "data", link_rig, url) as lab, lab.client() as client:
        lab.wait_until_idle()
        lease = lab.lease()
        mine = {"Modallab-Lease": lease.id}
        runs = f"{API}/campaigns/{lab.campaign()}/runs"
        out_of_band = client.post(runs, json=LONG, headers=mine)
        assert (out_of_band.status_code, out_of_band.json()["code"]) == (507, "disk_full"), out_of_band.text
        begun = client.post(runs, json=SHORT, headers=mine)
        assert begun.status_code == 202, begun.text
        run = begun.json()["id"]
        lab.wait_for(lambda e: e.kind == "block")
        # Somebody else fills the disk while it runs.
        with suppress(OSError):
            (small_disk / "other").write_bytes(bytes(shutil.disk_usage(small_disk).free - 150_000))
        lab.wait_for_ended(run)
        lab.wait_until_idle()
        view = client.get(f"{API}/runs/{run}").json()
        assert (view["state"], view["valid"]) == ("failed", True), view
        assert "full" in view["reason"] or "free" in view["reason"], view
        acknowledged = {
            e.content["n"]: e.content["crc32"] for e in lab.service.log.events_after(0, 5000) if e.kind == "block"
        }
        assert 24 > view["blocks"] >= len(acknowledged) > 0
        for n, crc in acknowledged.items():
            samples = client.get(f"{API}/runs/{run}/blocks/{n}/samples").content
            assert zlib.crc32(samples) == crc
        rejected = client.post(runs, json=SHORT, headers=mine)
        assert (rejected.status_code, rejected.json()["code"]) == (507, "disk_full"), rejected.text
        assert client.get(f"{API}/rigs/{RIG}").json()["trip"] is None
        assert client.get("/health").json()["status"] == "good"
