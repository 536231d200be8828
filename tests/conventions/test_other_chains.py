"""What a rig file declares of its channels changes the recordings, and not what is found in them."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from convention import scaled_sensitivity
from twin_campaign import built, link

from modallab.core.block import Campaign
from modallab.core.diagnosis import Diagnosis
from modallab.core.effects import Effect
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.frf.estimate import group_by_point, impact_frf
from modallab.frf.stepped import stepped_frf
from modallab.gap.design.prediction import predict_records
from modallab.gap.diagnosis import diagnose
from modallab.identification import IdentificationOptions
from modallab.pipelines.identify import identify_campaign
from modallab.signals.signals import to_signals_of

LOOKED_FOR = ("added_mass", "polarity", "trigger_delay", "ac_coupling")
MASS = Effect(effect="added_mass", parameters={"mass": 0.05}, place={"x": 0.8})


def changed(channel_candidates: Callable[[dict], dict]) -> Rig:
    believed = link().model_dump()
    return Rig.model_validate({**believed, "channels": [{**c, **channel_candidates(c)} for c in believed["channels"]]})


def motion(fields: Callable[[int], dict]) -> Rig:
    return changed(lambda c: {} if c["quantity"] == "force" else fields(c["index"]))


def sensing(quantity: str, unit: str, factor: float) -> Rig:
    rig = link()
    return motion(
        lambda k: {
            "quantity": quantity,
            "unit": unit,
            "sensitivity_v_per_unit": scaled_sensitivity(rig.channels[k], factor),
        }
    )


def few() -> Rig:
    believed = link().model_dump()
    kept = [c for c in believed["channels"] if c["name"] in ("force", "a03", "a06", "a10")]
    return Rig.model_validate({**believed, "channels": [{**c, "index": k} for k, c in enumerate(kept)]})


CHAINS: dict[str, Callable[[], Rig]] = {
    "delay": lambda: motion(lambda _: {"delay_s": 0.00037}),
    "skew": lambda: motion(lambda k: {"skew_s": 8e-6 * k}),
    "AC corner": lambda: motion(lambda _: {"ac_corner_hz": 0.5}),
    "delay, skew and AC corner, -z": lambda: motion(
        lambda k: {"delay_s": 0.0002, "skew_s": 5e-6 * k, "ac_corner_hz": 0.3, "direction": "-z"}
    ),
    "velocity": lambda: sensing("velocity", "m/s", 100.0),
    "velocity in mm/s": lambda: sensing("velocity", "mm/s", 0.1),
    "displacement": lambda: sensing("displacement", "mm", 10.0),
    "3 of 10 sensors": few,
}
TOGETHER = ("delay, skew and AC corner, -z", "velocity in mm/s", "3 of 10 sensors")


@cache
def campaign(name: str) -> Campaign:
    return built(CHAINS[name](), MASS)


def struck(campaign: Campaign) -> ModalModel:
    return identify_campaign(campaign, IdentificationOptions(band_hz=(3.0, 200.0)), "impact").identified[0].model


@pytest.fixture(scope="module")
def usual() -> Campaign:
    return built(link(), MASS)


@pytest.fixture(scope="module")
def usual_model(usual: Campaign) -> ModalModel:
    return struck(usual)


@pytest.mark.parametrize("name", ["delay", "skew", "AC corner", "delay, skew and AC corner, -z"])
def test_the_frfs_are_those_of_a_plain_chain(usual: Campaign, name: str) -> None:
    a, b = (
        impact_frf(group_by_point(to_signals_of(c.of("impact"), c.rig)), c.rig, (3.0, 200.0))
        for c in (usual, campaign(name))
    )
    off = np.linalg.norm(b.values - a.values, axis=-1) / np.linalg.norm(a.values, axis=-1)
    assert off.max() < 5e-3
    a, b = (
        stepped_frf(to_signals_of([b for b in c.of("sine") if b.level == "high"], c.rig), c.rig)
        for c in (usual, campaign(name))
    )
    # Near a node there is little but noise: against what the point answers elsewhere.
    assert np.abs(b.values - a.values).max() < 1e-3 * np.abs(a.values).max()


AGAIN = pytest.mark.thorough("identifies campaigns written in many ways")


@pytest.mark.parametrize("name", [n if n in TOGETHER else pytest.param(n, marks=AGAIN) for n in CHAINS])
def test_the_modal_model_is_the_same_within_its_sigma(usual_model: ModalModel, name: str) -> None:
    one, two = usual_model, struck(campaign(name))
    assert one.n_modes == two.n_modes == 4
    both = np.hypot(one.frequency_sigma_hz, two.frequency_sigma_hz)
    assert np.all(np.abs(two.frequency_hz - one.frequency_hz) < 5 * both + 1e-5 * one.frequency_hz)
    both = np.hypot(one.damping_sigma, two.damping_sigma)
    assert np.all(np.abs(two.damping_ratio - one.damping_ratio) < 5 * both + 1e-3 * one.damping_ratio)


@cache
def diagnosed(name: str) -> tuple[Campaign, Diagnosis]:
    return campaign(name), diagnose(campaign(name), allowed=lambda n: n in LOOKED_FOR)


# A diagnosis takes seconds: what is asked of all chains above, alone and together, is asked here together.
@pytest.mark.thorough("diagnoses campaigns written in many ways")
@pytest.mark.parametrize("name", TOGETHER)
def test_the_diagnosis_is_the_same(name: str) -> None:
    _, found = diagnosed(name)
    assert (found.verdict, found.where.stage) == ("known", "structure")
    (effect,) = found.effects
    assert effect.effect == "added_mass"
    assert effect.parameters["mass"] == pytest.approx(0.05, rel=0.01)
    assert effect.place.x_m == pytest.approx(0.8, abs=0.005)
    assert found.gap.after < 1.1


@pytest.mark.thorough("diagnoses campaigns written in many ways")
@pytest.mark.parametrize("name", TOGETHER)
def test_a_prediction_reads_as_the_recording_does(name: str) -> None:
    recorded, found = diagnosed(name)
    for record, values in predict_records(found, recorded).items():
        block = next(b for b in recorded.blocks if b.name == record)
        per_unit = np.array([[c.sensitivity(block.test)] for c in recorded.rig.responses])
        read = np.array([block.samples[c.index] * block.scale[c.index] for c in recorded.rig.responses]) / per_unit
        noise = 4 * 0.000313 / per_unit * np.sqrt(block.n_samples)
        off = np.linalg.norm(values - read, axis=1, keepdims=True)
        assert np.all(off < noise + 0.01 * np.linalg.norm(read, axis=1, keepdims=True))
