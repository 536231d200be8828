"""`modallab demo`, whole, as a user runs it; and how fast help is."""

import json
import subprocess
import sys

import numpy as np
import pytest

from modallab.cli import main
from modallab.formats.campaign.campaign_hdf5 import read_campaign

RECORDED = pytest.mark.thorough("records and identifies the demonstration")


@RECORDED
def test_the_demo_leaves_everything_in_one_folder(demo):
    assert {"report.html", "campaign.h5", "models.json", "rig.yaml"} <= {p.name for p in demo.iterdir()}
    assert len(read_campaign(demo / "campaign.h5").blocks) == 47


@RECORDED
def test_both_tests_find_the_bench_that_was_built(demo):
    document = json.loads((demo / "models.json").read_text())
    limits = {"impact": (2e-4, 0.03), "sine": (1e-3, 0.05)}
    for model in document["models"]:
        # The shaker hangs on the beam in its own test.
        of = "bench.sine_" if model["test"] == "sine" else "bench."
        true_f = np.array(json.loads(document["provenance"][f"{of}frequency_hz"]))[:3]
        true_z = np.array(json.loads(document["provenance"][f"{of}damping_ratio"]))[:3]
        f, z = np.array(model["frequency_hz"])[:3], np.array(model["damping_ratio"])[:3]
        assert np.all(np.abs(f / true_f - 1) < limits[model["test"]][0])
        assert np.all(np.abs(z / true_z - 1) < limits[model["test"]][1])
        assert np.min(model["frac"]) > 0.99
        assert model["half_power"][0] > 4 * true_z[0]


@RECORDED
def test_the_demos_campaign_is_identified_again_alike(demo, tmp_path):
    assert main(["identify", str(demo), "--json", str(tmp_path / "m.json")]) == 0
    first = json.loads((demo / "models.json").read_text())["models"][0]
    again = json.loads((tmp_path / "m.json").read_text())["models"][0]
    assert again["frequency_hz"] == pytest.approx(first["frequency_hz"], rel=1e-12)


def test_help_imports_nothing_heavy():
    code = "import sys; from modallab.cli import main\ntry: main(['--help'])\nexcept SystemExit: pass\n"
    code += (
        "print([m for m in ('numpy', 'scipy', 'matplotlib', 'pydantic', 'h5py') if m in sys.modules], file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "COMMAND" in done.stdout
    assert done.stderr.strip() == "[]"
