"""However a lab writes down one and the same recording, every number that follows is the same to rounding."""

from pathlib import Path

import numpy as np
import pytest
from convention import SAME
from modallab.gap.diagnose import diagnose

from modallab.core.block import Campaign
from modallab.core.diagnosis import Diagnosis
from modallab.frf.estimate import group_by_point, impact_frf
from modallab.frf.stepped import stepped_frf
from modallab.gap.design.prediction import predict
from modallab.identification.options import Options
from modallab.pipelines.identify import Identified, identify_campaign
from modallab.signals.conversion import unit_per_si
from modallab.signals.full_scale import overloaded
from modallab.signals.signals import to_signals, to_signals_of

BAND = (3.0, 400.0)


def allowed(name: str) -> bool:
    return name in ("added_mass", "sensor_mass", "gain_error", "polarity", "force_gain")


def models(campaign: Campaign) -> list[Identified]:
    return list(identify_campaign(campaign, Options(band_hz=None)).identified)


def by_name(outputs: tuple[str, ...], values: np.ndarray) -> np.ndarray:
    """Rows in the order of the channels' names."""
    return values[np.argsort(outputs)]


@pytest.fixture(scope="module")
def diagnosed(heavy: Campaign) -> Diagnosis:
    return diagnose(heavy, allowed=allowed)


@pytest.fixture(scope="module")
def identified(heavy: Campaign) -> list[Identified]:
    return models(heavy)


@pytest.mark.parametrize("name", SAME)
def test_signals_and_frfs(heavy: Campaign, name: str) -> None:
    other = SAME[name](heavy)
    for one, two in ((heavy.blocks[0], other.blocks[0]), (heavy.blocks[-1], other.blocks[-1])):
        a, b = to_signals(one, heavy.rig), to_signals(two, other.rig)
        np.testing.assert_allclose(b.force, a.force, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(by_name(b.outputs, b.responses), by_name(a.outputs, a.responses), rtol=1e-9)
        assert sorted(overloaded(two, other.rig)) == sorted(overloaded(one, heavy.rig))
    for test, frf in (
        ("impact", lambda s, rig: impact_frf(group_by_point(s), rig, BAND)),
        ("sine", lambda s, rig: stepped_frf([x for x in s if x.block.level == "high"], rig)),
    ):
        a = frf(to_signals_of(heavy.of(test), heavy.rig), heavy.rig)
        b = frf(to_signals_of(other.of(test), other.rig), other.rig)
        np.testing.assert_allclose(by_name(b.outputs, b.values), by_name(a.outputs, a.values), rtol=1e-7)


@pytest.mark.parametrize("name", SAME)
def test_the_modal_model_and_its_verification(heavy: Campaign, identified: list[Identified], name: str) -> None:
    found = models(SAME[name](heavy))
    assert [f.source for f in found] == [f.source for f in identified] == ["impact", "sine"]
    for a, b in zip(identified, found, strict=True):
        one, two = a.model, b.model
        np.testing.assert_allclose(two.frequency_hz, one.frequency_hz, rtol=1e-7)
        np.testing.assert_allclose(two.damping_ratio, one.damping_ratio, rtol=1e-4)
        constants = np.moveaxis(one.modal_constants, 1, 0)
        scale = np.abs(constants).max()
        np.testing.assert_allclose(
            by_name(two.outputs, np.moveaxis(two.modal_constants, 1, 0)), by_name(one.outputs, constants),
            atol=1e-5 * scale,
        )  # fmt: skip
        assert a.verification is not None
        assert b.verification is not None
        np.testing.assert_allclose(
            by_name(two.outputs, b.verification.frac), by_name(one.outputs, a.verification.frac), atol=1e-6
        )


@pytest.mark.parametrize("name", SAME)
def test_the_diagnosis(heavy: Campaign, diagnosed: Diagnosis, name: str) -> None:
    found = diagnose(SAME[name](heavy), allowed=allowed)
    assert (found.verdict, found.where.stage) == (diagnosed.verdict, diagnosed.where.stage) == ("known", "structure")
    assert [e.effect for e in found.effects] == [e.effect for e in diagnosed.effects] == ["added_mass"]
    (one,), (two,) = diagnosed.effects, found.effects
    assert two.parameters == pytest.approx(one.parameters, rel=1e-4)
    assert two.place["x_m"] == pytest.approx(one.place["x_m"], rel=1e-4)
    assert two.probability == pytest.approx(one.probability, abs=1e-3)
    for field in ("before", "after"):
        assert getattr(found.gap, field) == pytest.approx(getattr(diagnosed.gap, field), rel=1e-3)
    assert found.gap.by_channel == pytest.approx(diagnosed.gap.by_channel, rel=2e-3)


@pytest.mark.parametrize("name", SAME)
def test_a_prediction_is_what_each_channel_would_read(heavy: Campaign, diagnosed: Diagnosis, name: str) -> None:
    other = SAME[name](heavy)
    here, there = predict(diagnosed, heavy), predict(diagnosed, other)
    names = [c.name for c in other.rig.responses]
    per_si = unit_per_si(other.rig)[[c.index for c in other.rig.responses], None]
    for record, values in there.items():
        np.testing.assert_allclose(by_name(tuple(names), values / per_si), here[record], rtol=1e-6, atol=1e-9)
    # As recorded in that unit, it is the same motion: positive where the sensor reads positive.
    block = next(b for b in other.blocks if b.test == "impact")
    seen = to_signals(block, other.rig).responses / np.abs(per_si)
    read = there[block.name] / np.abs(per_si)
    together = np.sum(np.sign(per_si) * read * seen * np.abs(per_si) ** 2, axis=1)
    assert np.all(together > 0)


@pytest.mark.parametrize("name", SAME)
def test_an_export_reads_back_as_the_same_signals(heavy: Campaign, tmp_path: Path, name: str) -> None:
    from modallab.formats.campaign.campaign_hdf5 import read_campaign, write_campaign

    other = SAME[name](heavy)
    write_campaign(other, tmp_path / "c.h5")
    back = read_campaign(tmp_path / "c.h5")
    for block, again in zip(other.blocks[::7], back.blocks[::7], strict=True):
        a, b = to_signals(block, other.rig), to_signals(again, back.rig)
        np.testing.assert_allclose(b.force, a.force, rtol=1e-12)
        np.testing.assert_allclose(b.responses, a.responses, rtol=1e-12)
