"""H1, H2 and Hv asked of an identification: what a noisy force does to modal constants, and where there is no H2."""

from dataclasses import replace
from pathlib import Path

import drives
import modal_bench as bench
import numpy as np
import pytest
from twin_campaign import built, link

from modallab.cli import main
from modallab.core.block import Campaign
from modallab.core.errors import DataError, IdentificationError
from modallab.core.model import ModalModel
from modallab.core.units import FrfEstimator
from modallab.formats.campaign.campaign_hdf5 import write_campaign
from modallab.identification.options import IdentificationOptions
from modallab.pipelines.identify import identify_campaign
from modallab.verification.verify import frac

NOISE = 0.4
BAND = (3.0, 75.0)


def random_campaign(seconds: float = 66.0) -> Campaign:
    """White force to 90 Hz on the closed-form bench, whose force channel holds noise of `NOISE` times its rms."""
    rng = np.random.default_rng(2)
    n, count = 1024, round(seconds)
    system = bench.modes(rng)
    force = drives.signal.sosfilt(
        drives.signal.butter(6, 90.0, fs=drives.RATE, output="sos"), rng.standard_normal(n * (count + 1))
    )
    answer = bench.respond(system, force, drives.POINT, drives.RATE)
    both = np.vstack([force, answer])
    both[0] += NOISE * drives.signal.sosfilt(
        drives.signal.butter(6, 90.0, fs=drives.RATE, output="sos"), rng.standard_normal(both.shape[1])
    )
    blocks = []
    for k in range(count):
        cut = slice((k + 1) * n, (k + 2) * n)
        block = bench.block(f"random_{k}", "random", k, drives.RATE, both[:, cut], drives.POINT)
        blocks.append(replace(block, first_sample=k * n))
    return Campaign(bench.rig(drives.POINT), tuple(blocks), source="noisy")


def constant(model: ModalModel) -> float:
    """That of the second mode at the driving point, over the closed form's."""
    true = bench.modes(np.random.default_rng(2)).phi[1, drives.POINT - 1] ** 2
    return float(np.abs(model.modal_constants[1, drives.POINT - 1, 0]) / true)


@pytest.mark.thorough("records minutes of a random force")
def test_noise_on_a_random_force_lowers_the_modal_constants_of_h1_and_not_of_h2() -> None:
    campaign, power = random_campaign(), 1 + NOISE**2
    kinds: tuple[FrfEstimator, ...] = ("H1", "Hv", "H2")
    h1, hv, h2 = (
        constant(identify_campaign(campaign, IdentificationOptions(band_hz=BAND, frf=kind)).identified[0].model)
        for kind in kinds
    )
    assert h2 == pytest.approx(1.0, abs=0.05)
    assert hv / h2 == pytest.approx(power**-0.5, abs=0.03)
    assert h1 / h2 == pytest.approx(1 / power, abs=0.03)


def test_hits_are_identified_from_h2_of_those_at_each_point() -> None:
    campaign = built(link(), tests=("impact",))
    usual = identify_campaign(campaign, IdentificationOptions()).identified[0]
    found = identify_campaign(campaign, IdentificationOptions(frf="H2")).identified[0]
    assert found.model.test == "impact"
    assert any("H2 of the hits" in note for note in found.model.notes)
    np.testing.assert_allclose(found.model.frequency_hz[:3], usual.model.frequency_hz[:3], rtol=1e-3)
    np.testing.assert_allclose(found.model.damping_ratio[:3], usual.model.damping_ratio[:3], rtol=0.1)
    check = found.verification
    assert check is not None
    assert frac(check.measured.values, check.regenerated.values).min() > 0.99


def test_one_hit_a_point_has_no_h2() -> None:
    campaign = built(link(), tests=("impact",))
    once = replace(campaign, blocks=tuple(b for b in campaign.blocks if b.name.endswith("_0")))
    with pytest.raises(DataError, match="H2 asks for several hits"):
        identify_campaign(once, IdentificationOptions(frf="H2"))


def test_sines_have_no_h2() -> None:
    with pytest.raises(DataError, match="ratio of two fitted amplitudes"):
        identify_campaign(built(link(), tests=("sine",)), IdentificationOptions(frf="Hv"))


def test_an_frf_of_no_known_kind_is_rejected() -> None:
    with pytest.raises(IdentificationError, match="no FRF is called 'H3'"):
        IdentificationOptions(frf="H3")


@pytest.mark.thorough("records minutes of a random force")
def test_the_command_takes_the_kind_of_frf(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, page = tmp_path / "campaign.h5", tmp_path / "report.html"
    write_campaign(built(link(), tests=("impact",)), path)
    assert main(["identify", str(path), "--frf", "H2", "--report", str(page)]) == 0
    assert "H2 of the hits" in " ".join(capsys.readouterr().out.split())
    assert page.exists()
    assert main(["identify", str(path), "--frf", "H2", "--response-only"]) != 0
