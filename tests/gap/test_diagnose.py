"""A diagnosis of campaigns whose truth is known."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from twin_campaign import bench

from modallab.core.block import Block, Campaign
from modallab.core.diagnosis import Diagnosis
from modallab.core.effects import Effect
from modallab.core.errors import DataError, PlanError, RigError
from modallab.core.hold_out import MIXED, HoldOut
from modallab.core.progress import report_progress_to
from modallab.core.rig import Rig
from modallab.formats.campaign.campaign_hdf5 import read_campaign, write_campaign
from modallab.gap.conditioning.records import split_held_out
from modallab.gap.design.prediction import predict_records, predicted_campaign
from modallab.gap.diagnosis import diagnose
from modallab.gap.model.forward import predict_record
from modallab.gap.words.verdicts import verdict_sentence
from modallab.signals.signals import to_signals

Make = Callable[..., Campaign]
TIP = Effect(effect="added_mass", parameters={"mass": 0.05}, place={"x": 0.8})


def only(*names: str) -> Callable[[str], bool]:
    """A few candidates, to be quick."""
    return lambda name: name in names


@pytest.fixture(scope="module")
def said() -> list[tuple[float, str]]:
    """What was heard of the progress of `massed`."""
    return []


@pytest.fixture(scope="module")
def massed(make: Make, said: list[tuple[float, str]]) -> Diagnosis:
    with report_progress_to(lambda share, stage: said.append((share, stage))):
        return diagnose(make(TIP), allowed=only("added_mass", "sensor_mass"))


@pytest.fixture(scope="module")
def struck(make: Make) -> Diagnosis:
    return diagnose(make(tests=("impact",)))


def test_a_bench_that_is_its_twin_has_no_gap(make: Make) -> None:
    found = diagnose(make())
    assert found.verdict == "no_gap"
    assert found.effects == []
    assert found.gap.before == pytest.approx(1.0, abs=0.06)
    assert found.twin.youngs_modulus_pa * found.twin.thickness_m**2 / found.twin.density_kg_m3 == pytest.approx(
        2.06e11 * 0.006**2 / 7840.0, rel=1e-4
    )
    assert found.twin.zeta[:3] == pytest.approx((0.006 * np.linspace(0.7, 1.5, 15))[:3], rel=0.01)


def test_a_mass_is_named_with_its_place_and_size(massed: Diagnosis, said: list[tuple[float, str]]) -> None:
    found = massed
    # Whoever waits sees it move.
    assert len({share for share, _ in said}) >= 10
    assert any("round 1: candidates screened" in stage for _, stage in said)
    assert (found.verdict, found.where.stage) == ("known", "structure")
    assert [f.effect for f in found.effects] == ["added_mass"]
    assert found.effects[0].parameters["mass"] == pytest.approx(0.05, rel=0.01)
    assert found.where.x_m == pytest.approx(0.8, abs=0.005)
    assert found.shrink.closed == pytest.approx(1.0, abs=0.01)
    assert "added mass" in verdict_sentence(found)


@pytest.mark.thorough("diagnoses a whole campaign")
def test_the_same_mass_is_unknown_where_its_name_is_withheld(make: Make) -> None:
    found = diagnose(make(TIP, tests=("impact",)), allowed=only("polarity"))
    assert (found.verdict, found.where.stage) == ("unknown", "structure")
    assert found.effects == []


@pytest.mark.thorough("diagnoses a whole campaign")
@pytest.mark.parametrize(("gain", "name"), [(-0.3, "gain_error"), (-1.0, "polarity")])
def test_a_channel_that_reads_against_the_others_is_named_with_its_size(make: Make, gain: float, name: str) -> None:
    wrong = Effect(effect="gain_error", parameters={"gain": gain}, place={"channel": 7})
    found = diagnose(make(wrong, tests=("impact",)), allowed=only("gain_error", "polarity"))
    assert [f.effect for f in found.effects] == [name]
    assert found.where.channels == ["a07"]
    assert next(iter(found.effects[0].parameters.values())) == pytest.approx(gain, rel=1e-3)


@pytest.mark.thorough("diagnoses a whole campaign")
def test_a_channel_that_reads_too_much_is_named(make: Make) -> None:
    wrong = Effect(effect="gain_error", parameters={"gain": 1.1}, place={"channel": 7})
    found = diagnose(make(wrong, tests=("impact",)), allowed=only("gain_error", "polarity"))
    assert [f.effect for f in found.effects] == ["gain_error"]
    assert found.where.channels == ["a07"]
    assert found.effects[0].parameters["gain"] == pytest.approx(1.1, rel=1e-3)
    # Bands stand as a reader expects them: 20-50 before 120-200.
    lower_ends = [float(band.partition("-")[0]) for band in found.gap.by_band]
    assert lower_ends == sorted(lower_ends)
    assert len(lower_ends) > 2
    assert sum(found.gap.by_band.values()) == pytest.approx(1)


@pytest.mark.thorough("diagnoses a whole campaign")
def test_an_unnamed_fault_of_one_channel_is_found_there(make: Make) -> None:
    def late(volts: np.ndarray, _: Block) -> np.ndarray:
        volts[5] = np.roll(volts[5], 3)
        return volts

    found = diagnose(make(spoil=late, tests=("impact",)), allowed=only("polarity"))
    assert found.verdict == "unknown"
    assert (found.where.stage, found.where.channels) == ("sensor", ["a05"])


def test_a_noisy_channel_is_seen_without_a_model(make: Make) -> None:
    rng = np.random.default_rng(3)

    def noisy(volts: np.ndarray, _: Block) -> np.ndarray:
        volts[4] += 0.012 * rng.standard_normal(volts.shape[1])
        return volts

    found = diagnose(make(spoil=noisy))
    assert [f.effect for f in found.effects] == ["noisy_channel"]
    assert found.effects[0].parameters["factor"] == pytest.approx(40, rel=0.06)
    low, high = found.effects[0].interval["factor"]
    assert low < 40 < high
    # All other rows have the noise that is stated, and say that this one would.
    assert high / low < 1.2
    assert found.where.channels == ["a04"]


def test_hum_is_seen_and_taken_out(make: Make) -> None:
    rng = np.random.default_rng(4)

    def hum(volts: np.ndarray, block: Block) -> np.ndarray:
        t = np.arange(volts.shape[1]) / block.rate_hz
        row = 0.02 * (0.5 + 0.1 * np.arange(11))
        return volts + row[:, None] * np.cos(2 * np.pi * 50 * t + rng.uniform(0, 6))

    found = diagnose(make(spoil=hum))
    assert [f.effect for f in found.effects] == ["mains_hum"]
    assert found.effects[0].parameters == pytest.approx({"volts": 0.02, "hz": 50.0}, rel=0.01)
    assert found.gap.after < 1.1 < found.gap.before


def test_flat_tops_are_seen_with_their_level(make: Make) -> None:
    def cut(volts: np.ndarray, _: Block) -> np.ndarray:
        volts[8] = np.clip(volts[8], -0.3, 0.3)
        return volts

    found = diagnose(make(spoil=cut))
    clipped = next(f for f in found.effects if f.effect == "clipping")
    assert clipped.place.level_v == pytest.approx(0.3, rel=0.01)
    assert found.where.channels == ["a08"]


def test_hits_alone_raise_no_alarm(struck: Diagnosis) -> None:
    assert struck.verdict == "no_gap"


def test_hits_alone_are_diagnosed_and_what_they_hide_is_said(struck: Diagnosis) -> None:
    assert any("Only an impact test" in n for n in struck.notes)


def test_a_sine_test_alone_is_diagnosed_and_what_it_hides_is_said(make: Make) -> None:
    sines = diagnose(make(tests=("sine",)))
    assert sines.verdict == "no_gap"
    assert any("Only a sine test" in n for n in sines.notes)


def test_records_without_a_force_are_rejected(make: Make) -> None:
    def dead(volts: np.ndarray, _: Block) -> np.ndarray:
        volts[0] = 0
        return volts

    with pytest.raises(DataError, match="none of"):
        diagnose(make(spoil=dead))


def test_a_rig_without_a_beam_is_rejected(make: Make, rig: Rig) -> None:
    campaign = make()
    bare = rig.model_copy(update={"model": "unknown", "beam": None})
    with pytest.raises(RigError, match="no beam"):
        diagnose(Campaign(bare, campaign.blocks))


@pytest.mark.thorough("diagnoses a whole campaign")
def test_a_diagnosis_predicts_another_campaign(massed: Diagnosis, make: Make, rig: Rig) -> None:
    read = Diagnosis.model_validate_json(massed.model_dump_json())
    other = make(TIP, seed=9)
    predicted = predict_records(read, other)
    assert set(predicted) == {b.name for b in other.blocks}
    for block in other.blocks:
        a = to_signals(block, rig).responses
        assert np.linalg.norm(predicted[block.name] - a) < 0.02 * np.linalg.norm(a) + 0.04 * np.sqrt(a.size)


def test_a_record_is_predicted_to_within_its_noise(make: Make, rig: Rig) -> None:
    campaign = make()
    twin = bench(rig, ())
    for block in (campaign.blocks[0], campaign.blocks[-1]):
        a = to_signals(block, rig).responses
        noise = 0.000313 / rig.responses[0].sensitivity(block.test)
        assert np.std(predict_record(twin, rig, block, 29.0) - a) < 2.5 * noise


def test_rules_say_which_records_no_fit_may_see(make: Make) -> None:
    blocks = make().blocks
    fitted, held = split_held_out(blocks, HoldOut.parse("point:10"))
    assert {b.drive_point for b in held} == {10}
    assert len(fitted) + len(held) == len(blocks)
    assert {b.level for b in split_held_out(blocks, HoldOut.parse("level:high"))[1]} == {"high"}
    mixed = split_held_out(blocks, MIXED)[1]
    assert {b.test for b in mixed} == {"impact", "sine"}
    for wrong in ("point:99", "every other", "last:2"):
        with pytest.raises(PlanError):
            split_held_out(blocks, HoldOut.parse(wrong))


def test_a_prediction_is_a_campaign_too(massed: Diagnosis, make: Make, tmp_path: Path) -> None:
    other = make(TIP, seed=9)
    write_campaign(predicted_campaign(massed, other), tmp_path / "predicted.h5")
    read = read_campaign(tmp_path / "predicted.h5")
    rows = [c.index for c in read.rig.responses]
    block, expected = read.blocks[0], predict_records(massed, other)[read.blocks[0].name]
    assert np.allclose(block.samples[rows] * block.scale[rows, None], expected)
    assert len(read.blocks) == len(other.blocks)
