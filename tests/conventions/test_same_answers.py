"""However a lab writes down one and the same recording, every number that follows is the same to rounding.

All ways are asked of everything in `benchmarks/conventions.py`; here the slow answers are asked of a few of them.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from convention import SAME

from modallab.core.block import Campaign
from modallab.core.diagnosis import Diagnosis
from modallab.core.effects import Effect
from modallab.formats import read_campaign, write_campaign
from modallab.frf.estimate import group_by_point, impact_frf
from modallab.frf.stepped import stepped_frf
from modallab.gap.design.prediction import predict_records
from modallab.gap.diagnosis import diagnose
from modallab.identification import IdentificationOptions
from modallab.pipelines.identify import IdentifiedTest, identify_campaign
from modallab.signals.conversion import unit_per_si
from modallab.signals.faults.whole_channels import overloaded_channels
from modallab.signals.signals import to_signals, to_signals_of

BAND = (3.0, 400.0)
AGAIN = pytest.mark.thorough("identifies campaigns written in many ways")
FEW_OR_ALL = [*(pytest.param(n, marks=AGAIN) for n in ("drive -z", "physical units kN, mm/s^2")), "all at once"]


def allowed(name: str) -> bool:
    return name in ("added_mass", "polarity", "force_gain")


def modelled(campaign: Campaign) -> IdentifiedTest:
    (found,) = identify_campaign(campaign, IdentificationOptions(), "impact").identified
    return found


def by_name(outputs: tuple[str, ...], values: np.ndarray) -> np.ndarray:
    """Rows in the order of the channels' names."""
    return values[np.argsort(outputs)]


@pytest.fixture(scope="module")
def identified(heavy: Campaign) -> IdentifiedTest:
    return modelled(heavy)


@pytest.fixture(scope="module")
def diagnosed(heavy: Campaign) -> Diagnosis:
    return diagnose(heavy, allowed=allowed)


@pytest.mark.parametrize("name", SAME)
def test_signals_and_overloads(heavy: Campaign, name: str) -> None:
    other = SAME[name](heavy)
    for one, two in zip(heavy.blocks[::5], other.blocks[::5], strict=True):
        a, b = to_signals(one, heavy.rig), to_signals(two, other.rig)
        np.testing.assert_allclose(b.force, a.force, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(by_name(b.outputs, b.responses), by_name(a.outputs, a.responses), rtol=1e-9)
        assert sorted(overloaded_channels(two, other.rig)) == sorted(overloaded_channels(one, heavy.rig))


@pytest.mark.parametrize("name", SAME)
def test_frfs(heavy: Campaign, name: str) -> None:
    other = SAME[name](heavy)
    for c in (heavy, other):
        assert {b.test for b in c.blocks} == {"impact", "sine"}
    a, b = (impact_frf(group_by_point(to_signals_of(c.of("impact"), c.rig)), c.rig, BAND) for c in (heavy, other))
    np.testing.assert_allclose(by_name(b.outputs, b.values), by_name(a.outputs, a.values), rtol=1e-7)
    np.testing.assert_allclose(by_name(b.outputs, b.coherence), by_name(a.outputs, a.coherence), rtol=1e-7)
    a, b = (
        stepped_frf(to_signals_of([b for b in c.of("sine") if b.level == "high"], c.rig), c.rig) for c in (heavy, other)
    )
    np.testing.assert_allclose(by_name(b.outputs, b.values), by_name(a.outputs, a.values), rtol=1e-7)


@pytest.mark.parametrize("name", FEW_OR_ALL)
def test_the_modal_model_and_its_verification(heavy: Campaign, identified: IdentifiedTest, name: str) -> None:
    found = modelled(SAME[name](heavy))
    one, two = identified.model, found.model
    np.testing.assert_allclose(two.frequency_hz, one.frequency_hz, rtol=1e-9)
    np.testing.assert_allclose(two.damping_ratio, one.damping_ratio, rtol=1e-7)
    a, b = (by_name(m.outputs, np.moveaxis(m.modal_constants, 1, 0)) for m in (one, two))
    np.testing.assert_allclose(b, a, atol=1e-7 * np.abs(a).max())
    assert identified.verification is not None
    assert found.verification is not None
    a, b = (by_name(i.model.outputs, i.verification.frac) for i in (identified, found) if i.verification is not None)
    np.testing.assert_allclose(b, a, atol=1e-9)


@pytest.mark.thorough("diagnoses campaigns written in many ways")
@pytest.mark.parametrize("name", ["drive -z", "all at once"])
def test_the_diagnosis(heavy: Campaign, diagnosed: Diagnosis, name: str) -> None:
    found = diagnose(SAME[name](heavy), allowed=allowed)
    assert (found.verdict, found.where.stage) == (diagnosed.verdict, diagnosed.where.stage) == ("known", "structure")
    assert [e.effect for e in found.effects] == [e.effect for e in diagnosed.effects] == ["added_mass"]
    (one,), (two,) = diagnosed.effects, found.effects
    assert two.parameters == pytest.approx(one.parameters, rel=1e-5)
    assert two.place.x_m == pytest.approx(one.place.x_m, rel=1e-5)
    assert two.probability == pytest.approx(one.probability, abs=1e-4)
    # Before the effect the model is wrong, and its fit ends where it no longer pays, not at a sharp minimum.
    assert found.gap.by_channel == pytest.approx(diagnosed.gap.by_channel, rel=0.02)
    assert found.gap.after_by_channel == pytest.approx(diagnosed.gap.after_by_channel, rel=1e-3)
    assert found.shrink.closed == pytest.approx(diagnosed.shrink.closed, rel=1e-4)


@pytest.mark.thorough("diagnoses campaigns written in many ways")
def test_a_stored_rig_gives_the_diagnosis_of_the_rig_file(make: Callable[..., Campaign], tmp_path: Path) -> None:
    """A tolerance that no one stated stays unstated when a campaign is written and read again."""
    campaign = make(Effect(effect="gain_error", parameters={"gain": 1.1}, place={"channel": 7}), tests=("impact",))
    write_campaign(campaign, tmp_path / "c.h5")
    one, two = (diagnose(c, allowed=lambda n: n == "gain_error") for c in (campaign, read_campaign(tmp_path / "c.h5")))
    assert two.effects[0].parameters == pytest.approx(one.effects[0].parameters, rel=1e-9)
    assert two.twin.gains == one.twin.gains == {}


@pytest.mark.thorough("diagnoses campaigns written in many ways")
def test_the_force_is_named_by_its_own_row(make: Callable[..., Campaign]) -> None:
    wrong = Effect(effect="force_gain", parameters={"gain": 0.8}, place={"channel": 0})
    other = SAME["rows permuted"](make(wrong, tests=("impact",)))
    found = diagnose(other, allowed=lambda n: n == "force_gain")
    assert found.effects[0].place.model_dump() == {"channel": other.rig.force_channel.index}
    assert found.where.channels == ["force"]


@pytest.mark.thorough("diagnoses campaigns written in many ways")
@pytest.mark.parametrize("name", SAME)
def test_a_prediction_is_what_each_channel_would_read(heavy: Campaign, diagnosed: Diagnosis, name: str) -> None:
    other = SAME[name](heavy)
    here, there = predict_records(diagnosed, heavy), predict_records(diagnosed, other)
    rows = [c.index for c in other.rig.responses]
    names, per_si = tuple(c.name for c in other.rig.responses), unit_per_si(other.rig)[rows, None]
    assert set(there) == set(here)
    for record, values in there.items():
        np.testing.assert_allclose(by_name(names, values / per_si), here[record], rtol=1e-6, atol=1e-9)
    block = other.blocks[0]
    # What the channel did read, in its own unit and direction, without going through signals.
    read = np.array([block.samples[c.index] * block.scale[c.index] for c in other.rig.responses])
    predicted = there[block.name] * [[np.sign(c.sensitivity("impact"))] for c in other.rig.responses]
    if block.units[0] == "V":
        assert np.all(np.sum(read * predicted, axis=1) > 0)
        read /= np.array([[abs(c.sensitivity("impact"))] for c in other.rig.responses])
        assert np.linalg.norm(read - predicted) < 0.05 * np.linalg.norm(read)


@pytest.mark.parametrize("name", SAME)
def test_a_campaign_file_reads_back_as_the_same_signals(heavy: Campaign, tmp_path: Path, name: str) -> None:
    other = SAME[name](heavy)
    write_campaign(other, tmp_path / "c.h5")
    back = read_campaign(tmp_path / "c.h5")
    for block, again in zip(other.blocks[::7], back.blocks[::7], strict=True):
        a, b = to_signals(block, other.rig), to_signals(again, back.rig)
        np.testing.assert_array_equal(b.force, a.force)
        np.testing.assert_array_equal(b.responses, a.responses)
