"""A simulated bench as people build it: what is drawn, from what, and that an ideal one stays as it was."""

import numpy as np
import pytest

from modallab.cli.demo import demo_rig
from modallab.core.errors import ConfigurationError
from modallab.core.rig import FORCE_SHARE, Rig, Tolerance
from modallab_simulators.cantilever.address import BenchSettings, parse_address
from modallab_simulators.cantilever.effect_part import DRIFT_S, AlteredBench
from modallab_simulators.cantilever.loads import BeamLoad
from modallab_simulators.cantilever.stream import BenchAtOneRate
from modallab_simulators.cantilever.truth import MOST, NOISE, bench_as_built, draw_truth


@pytest.fixture(scope="module")
def rig() -> Rig:
    return demo_rig().model_copy(update={"tolerance": Tolerance.usual()})


def test_the_address_says_how_well_a_bench_is_built() -> None:
    assert parse_address("sim://cantilever?tolerances=usual").tolerances == "usual"
    assert parse_address("sim://cantilever").tolerances == "none"
    with pytest.raises(ConfigurationError, match="usual"):
        parse_address("sim://cantilever?tolerances=some")


def test_all_is_drawn_within_three_deviations_and_again_by_the_same_seed(rig: Rig) -> None:
    t = rig.tolerance
    one, again, other = (bench_as_built(AlteredBench(), rig, t, seed, None) for seed in (7, 7, 8))
    assert one.chain.gain == again.chain.gain != other.chain.gain
    gains = np.array(list(one.chain.gain.values())) - 1
    assert 0 < np.max(np.abs(gains)) <= MOST * t.sensitivity
    assert abs(one.chain.force_gain - 1) <= MOST * FORCE_SHARE * t.sensitivity
    assert all(abs(dx) <= MOST * t.position_m for dx in one.chain.moved_m.values())
    assert one.chain.moved_m[10] <= 0  # nothing sits beyond the tip
    assert all(NOISE[0] <= f <= NOISE[1] for f in one.chain.noise.values())
    assert all(0 < a.mass <= MOST * t.sensor_mass_kg for a in one.structure.attachments)
    assert len(one.structure.waves) == len(one.structure.mass_waves) == 3
    assert 0 < one.structure.dampers[0].c <= MOST * t.damper_n_s_per_m


def test_a_rig_file_without_tolerances_of_assembly_leaves_an_ideal_one(rig: Rig) -> None:
    bare = bench_as_built(AlteredBench(), rig, Tolerance(sensitivity=0.0), 7, None)
    assert set(bare.chain.gain.values()) == {1.0}
    assert bare.structure.waves == bare.structure.attachments == bare.structure.dampers == ()


def test_waves_of_stiffness_and_mass_move_frequencies_as_the_energy_says(rig: Rig) -> None:
    plain, built = (draw_truth(BenchSettings(seed=3, tolerances=t), rig) for t in ("none", "usual"))
    before, after = (truth.modes("impact").omega(3) for truth in (plain, built))
    assert np.all(np.abs(after / before - 1) < 0.02)
    assert np.all(after != before)


@pytest.mark.parametrize("damper", [0.0, 0.5])
def test_the_beam_goes_on_moving_as_it_did_while_its_stiffness_drifts(rig: Rig, damper: float) -> None:
    # Solvers turn shapes upside down as they please; the motion under way must not follow them.
    tolerance = Tolerance.usual().model_copy(update={"stiffness_drift": 0.01, "damper_n_s_per_m": damper})
    stated = rig.model_copy(update={"tolerance": tolerance})
    settings = parse_address("sim://cantilever?seed=1&tolerances=stated&effect=added_mass,mass=0.05,x=0.8")
    site = BenchAtOneRate(draw_truth(settings, stated), stated, "sine", 1000.0)
    force = BeamLoad(0.31, np.sin(0.2 * np.arange(site.structure.times(0)[1])))
    _, state = site.structure.advance(site.structure.at_rest, [force])
    for share in np.linspace(0.1, 1.0, 10):
        before = site.structure
        after = site.drift_to(share * DRIFT_S)
        assert after is not before
        seen, _ = before.advance(state, [])
        goes_on, _ = after.advance(after.state_from(before, state), [])
        assert np.abs(goes_on - seen)[:, 0].max() < 0.05 * np.abs(seen).max()
