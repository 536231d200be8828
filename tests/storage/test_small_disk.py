"""A disk that is really full."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path


def test_a_disk_of_6_mb_fills_up_and_every_block_before_is_bit_equal(tmp_path: Path) -> None:
    mount = tmp_path / "disk"
    mount.mkdir()
    unshare = shutil.which("unshare")
    assert unshare is not None, "util-linux is missing"
    # As root of a user namespace of its own, which anybody may make.
    script = Path(__file__).with_name("small_disk_child.py")
    command = [unshare, "--user", "--map-root-user", "--mount", sys.executable, str(script), str(mount)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False, env=dict(os.environ))
    assert done.returncode == 0, done.stderr
    reported = json.loads(done.stdout)
    # 180 224 bytes a block; 1 MB of reserve, the catalogue and its log take the rest.
    assert 10 <= reported["kept"] <= 30
    assert reported["equal"] is True
    assert (reported["code"], reported["again"]) == ("disk_full", "disk_full")
    assert reported["state"] == ["failed", "disk_full"]
    assert list(mount.iterdir()) == []
