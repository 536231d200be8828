"""A bench driven and sensed along -z, in g and lbf, force in the last row: it runs, is checked and identified."""

from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
from convention import LBF, scaled_sensitivity

from modallab.bench.loader import open_bench
from modallab.commissioning.rig_check import check_idle, check_polarity
from modallab.core.block import Campaign
from modallab.core.plan import ImpactPlan
from modallab.core.rig import Rig
from modallab.core.units import STANDARD_GRAVITY
from modallab.formats.rig.rig_file import parse_rig
from modallab.identification import IdentificationOptions
from modallab.pipelines.identify import identify_campaign
from modallab.service.campaigns.live_frf import LiveFrfs
from modallab.service.campaigns.local_session import record_campaign
from modallab.storage import Store

BENCH = "sim://cantilever?seed=1&bad_hits=0&zeta=0.02"


def link_rig() -> Rig:
    return parse_rig((files("modallab.cli") / "link_rig.yaml").read_text(encoding="utf-8"), "link")


def written(rig: Rig, drive: str, against: tuple[str, ...]) -> Rig:
    """The demonstration rig as another lab writes it: g and lbf, the force in the last row."""
    units = {"force": ("lbf", LBF), "acceleration": ("g", STANDARD_GRAVITY)}
    other = {"+z": "-z", "-z": "+z"}[drive]
    channels = []
    for k, c in enumerate((*rig.responses, rig.force_channel)):
        unit, factor = units[c.quantity]
        fields = {"index": k, "unit": unit, "sensitivity_v_per_unit": scaled_sensitivity(c, factor)}
        direction = {} if c.quantity == "force" else {"direction": other if c.name in against else drive}
        channels.append({**c.model_dump(exclude={"direction"}), **fields, **direction})
    return Rig.model_validate({**rig.model_dump(), "drive_direction": drive, "channels": channels})


RIGS = {
    "drive -z": lambda rig: written(rig, "-z", ()),
    "drive -z, some sensors +z": lambda rig: written(rig, "-z", ("a02", "a07")),
    "sensors -z": lambda rig: written(rig, "+z", tuple(c.name for c in rig.responses)),
}


@pytest.mark.parametrize("name", RIGS)
def test_a_consistent_rig_is_good(name: str) -> None:
    rig = RIGS[name](link_rig())
    bench = open_bench(BENCH, rig)
    findings = [*check_idle(bench, rig, 0.5), *check_polarity(bench, rig, lambda _: None)]
    bench.close()
    assert [f for f in findings if f.verdict == "bad"] == []
    assert sum(f.verdict == "good" for f in findings if f.what == "polarity") >= 8


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    return tmp_path_factory.mktemp("usual"), tmp_path_factory.mktemp("other")


@pytest.fixture(scope="module")
def recorded(folders: tuple[Path, Path]) -> list[Campaign]:
    plan = ImpactPlan(points=(10,), hits=2)
    rigs = (link_rig(), written(link_rig(), "-z", ("a02", "a07")))
    return [record_campaign(BENCH, rig, [plan], into, lambda _: None) for rig, into in zip(rigs, folders, strict=True)]


@pytest.mark.thorough("records and identifies on two benches")
def test_hits_trigger_and_count_and_give_the_same_model(recorded: list[Campaign]) -> None:
    assert [len(c.blocks) for c in recorded] == [2, 2]
    one, two = (identify_campaign(c, IdentificationOptions(band_hz=(3.0, 300.0))).identified[0].model for c in recorded)
    np.testing.assert_allclose(two.frequency_hz, one.frequency_hz, rtol=1e-3)
    a, b = (m.modal_constants[:, np.argsort(m.outputs), 0] for m in (one, two))
    assert np.linalg.norm(b - a) < 0.02 * np.linalg.norm(a)


@pytest.mark.thorough("records and identifies on two benches")
def test_the_live_frf_is_the_same(recorded: list[Campaign], folders: tuple[Path, Path]) -> None:
    found = []
    for folder in folders:
        with Store(folder) as store:
            found.append(LiveFrfs(store).frf(store.catalogue.runs()[0].id))
    a, b = (f.values[np.argsort(f.outputs), 0] for f in found)
    assert np.linalg.norm(b - a) < 0.05 * np.linalg.norm(a)
