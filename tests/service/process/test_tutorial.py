"""The tutorial over REST is done as its reader does it: its commands, in a shell, against a service of its own."""

import json
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
from service_process import ServiceProcess

pytestmark = pytest.mark.thorough("does all that the tutorial does, with a diagnosis")

PAGE = Path(__file__).parents[3] / "docs" / "tutorial" / "rest-service.md"
TRUE_HZ = (4.754950, 30.593408, 87.146358)


def commands() -> list[str]:
    """The page's shell blocks, in order."""
    return re.findall(r"^```sh\n(.*?)^```$", PAGE.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)


def test_the_tutorials_commands_do_what_the_page_says(tmp_path: Path) -> None:
    start, *rest = commands()
    assert start == "modallab serve --data lab-data\n"
    # Without a seed in its address the bench is that of the demonstration.
    with ServiceProcess(tmp_path / "lab-data", "--workers", "1") as service:
        script = "set -e\n" + "\n".join(rest)
        script = script.replace("http://127.0.0.1:8001/emergency-stop", service.stop_url)
        script = script.replace("http://127.0.0.1:8000", service.url)
        done = subprocess.run(["bash", "-c", script], cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:] + service.log[-3000:]
        assert done.stdout.count("is done") == 3, done.stdout[-3000:]
        assert service.client.rig(service.rig).trip is not None
        (campaign,) = service.client.campaigns()
        found = service.client.models(campaign.id).models[0]
        np.testing.assert_allclose(found.model.frequency_hz[:3], TRUE_HZ, rtol=1e-4)
    frf = json.loads((tmp_path / "frf.json").read_text())
    assert frf["averages"] == [5, 5, 5]
    assert "[4, 5, 5]" in done.stdout
    assert (tmp_path / "block-0.bin").stat().st_size == 11 * 2048 * 2
    assert "<svg" in (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "<svg" in (tmp_path / "gap.html").read_text(encoding="utf-8")
