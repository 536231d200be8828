"""The twin predicts noise-free records of the bench from their measured force, effect by effect.

The two hold the same physics in different ways, so an error of either shows here: what is left must be far below the
change that the effect makes.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from noiseless_bench import noiseless_rig

from modallab.core.block import Block
from modallab.core.effects import Effect, catalogue, kind_of
from modallab.core.rig import Rig
from modallab.core.units import Test
from modallab.gap.model.forward import predict_record
from modallab.signals.signals import to_signals
from modallab.twin.bench import Twin
from modallab.twin.effect_model import NoChange
from modallab.twin.effects import apply_effect, effect_models
from modallab.twin.structure import MODES, TwinStructure
from modallab_simulators.cantilever.beam import draw_damping
from modallab_simulators.cantilever.trial import LAST_ORDER, SessionOperator, rigidly_clamped


def mounted(rig: Rig) -> Rig:
    """One accelerometer upside down and given in g: what is exchanged with it goes along with both."""
    channels = list(rig.channels)
    own = {"unit": "g", "direction": "-z", "sensitivity_v_per_unit": {"impact": 0.1, "sine": 1.0}}
    channels[3] = channels[3].model_copy(update=own)
    return rig.model_copy(update={"channels": tuple(channels)})


RIG = mounted(rigidly_clamped(noiseless_rig()))
SEED = 5
ORDER = 40
LINES = (6, 33)
"""Beside the first mode, where the start of the sine still rings, and at the second."""

SHARE = 0.01
"""Of the gap an effect opens that may be left."""
LEARNED_SHARE = 0.03
"""The same of what was learned: far below its lowest mode a family gives way by modes beyond as well, of which the twin
here counts none."""


def effect(name: str, place: dict[str, object] | None = None, **parameters: float) -> Effect:
    return Effect(effect=name, parameters=parameters, place=place or {})


EFFECTS = (
    effect("clamp_rotation", {"x": 0.0}, k_rot=2500.0),
    effect("clamp_translation", {"x": 0.0}, k_trans=4e5),
    effect("added_mass", {"x": 0.8}, mass=0.05),
    effect("sensor_mass", {"x": "all"}, mass_each=0.004),
    effect("stiffness_loss", {"x": 0.313}, EI_loss=0.4),
    effect("ground_spring", {"x": 0.55}, k=300.0),
    effect("local_damper", {"x": 0.72}, c=0.6),
    effect("thermal_drift", EI_drift=-0.03),
    effect("gain_error", {"channel": 4}, gain=1.08),
    effect("polarity", {"channel": 7}, sign=-1.0),
    effect("swap", {"channel": (3, 8)}),
    effect("position_error", {"channel": 6}, dx=0.013),
    effect("ac_coupling", {"channel": "all"}, corner_hz=0.8),
    effect("loose_mount", {"channel": 5}, hz=130.0, zeta=0.04),
    effect("force_gain", {"channel": 0}, gain=1.06),
    effect("channel_skew", {"channel": "all"}, seconds_per_channel=2e-5),
    effect("trigger_delay", {"channel": "all"}, seconds=7e-4),
    effect("clock_error", {"channel": "all"}, relative=2e-3),
    effect("hit_position", {"where": "hit"}, dx=0.011),
    effect("stinger_moment", {"x": 0.4}, k_rot=30.0),
    effect("shaker_mass", {"x": 0.4}, mass=0.12),
)

LEARNED = (
    effect("side_modes", {"x": "all"}, twist_hz=171.0, kg=3.0, zeta=0.005),
    effect("side_modes", {"x": "all"}, across_hz=61.0, kg=2.0, zeta=0.004),
    effect("side_modes", {"x": "all"}, alone_hz=47.0, alone_power=1.4, kg=4.0, zeta=0.01),
    effect("beam_law", {"x": "all"}, tension=-9.0),
)
"""What a rig's revisions may carry though it has no name."""


@lru_cache(maxsize=1)
def sound_twin() -> Twin:
    true = SessionOperator(RIG, SEED).truth.true
    assert RIG.beam is not None
    beam = RIG.beam.model_copy(
        update={
            "youngs_modulus_pa": true.youngs_modulus_pa,
            "thickness_m": true.thickness_m,
            "density_kg_m3": true.density_kg_m3,
        }
    )
    return Twin(replace(TwinStructure.of(beam, 0.01), zeta=draw_damping(SEED, MODES, ())))


def records(test: Test, effects: tuple[Effect, ...]) -> list[Block]:
    """A hit, or a sine beside each of two modes, a good way into the campaign."""
    operator = SessionOperator(RIG, SEED, effects, order=ORDER)
    if test == "impact":
        return [next(operator.hits())]
    sines = operator.sines(LINES)
    return [next(sines) for _ in LINES]


def measured(block: Block) -> np.ndarray:
    return to_signals(block, RIG).responses


def predicted(twin: Twin, block: Block) -> np.ndarray:
    return predict_record(twin, RIG, block, LAST_ORDER, 1 / (1 + twin.clock))


@lru_cache(maxsize=2)
def sound(test: Test) -> list[tuple[np.ndarray, np.ndarray]]:
    """What is measured on a bench without effects, and what is predicted."""
    return [(measured(b), predicted(sound_twin(), b)) for b in records(test, ())]


def size(y: np.ndarray) -> float:
    """Rms of what lies below 0.4 of the rate: above, the anti-alias filter cuts what force and response have of it."""
    n = y.shape[1]
    lines = np.fft.rfft(y, axis=1)[:, : round(0.4 * n)]
    return float(np.sqrt(2 * np.mean(np.sum(np.abs(lines) ** 2, axis=1))) / n)


def test_every_effect_the_twin_predicts_is_held_here():
    predicted = {name for name, model in effect_models().items() if not isinstance(model.change, NoChange)}
    # What is stepped in time is held to closed forms in tests/twin/test_nonlinear.py.
    assert {e.effect for e in EFFECTS} == {name for name in predicted if catalogue()[name].linear}


@pytest.mark.parametrize(("test", "tolerance"), [("impact", 2e-3), ("sine", 1e-5)])
def test_a_sound_bench_is_predicted(test: Test, tolerance: float):
    # Forty elements set the fifth mode off by a thousandth of its width; a hit excites it as much as any.
    for y, expected in sound(test):
        assert size(y - expected) < tolerance * size(y)


@pytest.mark.parametrize("test", ["impact", "sine"])
@pytest.mark.parametrize("one", EFFECTS, ids=lambda e: e.effect)
def test_the_gap_an_effect_opens_closes(one: Effect, test: Test):
    twin = apply_effect(sound_twin(), one, RIG)
    gaps: list[float] = []
    for block, (y, expected) in zip(records(test, (one,)), sound(test), strict=True):
        # What is off on a sound bench already is none of the effect's.
        found = measured(block) - (y - expected)
        gap = size(found - predicted(sound_twin(), block))
        assert size(found - predicted(twin, block)) < SHARE * gap + 1e-6 * size(y)
        gaps.append(gap / size(y))
    assert (max(gaps) > 0.01) is (test in kind_of(one.effect).tests)


@pytest.mark.parametrize("test", ["impact", "sine"])
@pytest.mark.parametrize("one", LEARNED, ids=lambda e: f"{e.effect}_{min(e.parameters)}")
def test_the_bench_carries_what_was_learned_as_the_twin_does(one: Effect, test: Test):
    twin = apply_effect(sound_twin(), one, RIG)
    for block, (y, expected) in zip(records(test, (one,)), sound(test), strict=True):
        found = measured(block) - (y - expected)
        gap = size(found - predicted(sound_twin(), block))
        assert gap > 1e-5 * size(y)
        assert size(found - predicted(twin, block)) < LEARNED_SHARE * gap + 1e-6 * size(y)
