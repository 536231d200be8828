"""Several shakers at once: waves that can be distinguished, one trip for all, a force that is missing by its name."""

from itertools import combinations

import numpy as np
import pytest
from scripted_bench import ScriptedBench
from two_shakers import TIP, two_shakers

from modallab.acquisition.procedures.broadband_checks import match_forces_to_drives, require_waves
from modallab.acquisition.procedures.broadband_wave import blocks_of_wave, make_wave, make_waves, wave_layout
from modallab.acquisition.procedures.plan_checks import require_possible
from modallab.acquisition.process.run import record_run
from modallab.bench.capabilities import DrivesSeveralShakers
from modallab.bench.loader import open_bench
from modallab.bench.protocol import BenchInfo
from modallab.core.errors import PlanError, SafetyError, UnsupportedError
from modallab.core.hardware import Excitation
from modallab.core.plan import BroadbandPlan
from modallab.core.rig import Rig
from modallab.core.units import BROADBAND, Broadband
from modallab.storage import Store
from modallab_simulators.faults import ChannelFault, FaultyBench, Kind

URL = "sim://cantilever?seed=1"
INFO = BenchInfo(URL, (), can_drive=True, real_time=False, facts={})


def plan_of(signal: Broadband, **fields: object) -> BroadbandPlan:
    given = {"signal": signal, "levels_v": {"low": 0.15}, "blocks": 6, "shakers": "all", "settle_s": 2.0}
    return BroadbandPlan.model_validate(given | fields)


@pytest.fixture(scope="module")
def both(link_rig: Rig) -> Rig:
    return two_shakers(link_rig)


@pytest.mark.parametrize("shakers", [2, 3])
@pytest.mark.parametrize("signal", ["pseudo-random", "chirp"])
def test_periodic_waves_of_as_many_rounds_as_shakers_are_orthogonal_at_every_line(
    signal: Broadband, shakers: int
) -> None:
    """Turned in each round, they have the same size and nothing in common."""
    plan = plan_of(signal)
    layout = wave_layout(plan, 2, plan.block_s)
    rounds = [make_waves(plan, "low", number, layout, shakers) for number in range(shakers)]
    first, period = (round(s * rounds[0][0].rate_hz) for s in (layout.lead_s, layout.block_s))
    spectra = np.array([[np.fft.rfft(w.samples[first : first + period])[5:300] for w in waves] for waves in rounds])
    powers = np.einsum("ril,rjl->lij", spectra, spectra.conj())
    own = np.einsum("lii->li", powers).real
    for one, other in combinations(range(shakers), 2):
        np.testing.assert_array_less(np.abs(powers[:, one, other]), 1e-9 * own.max())
        np.testing.assert_allclose(own[:, one], own[:, other], rtol=1e-6)


@pytest.mark.parametrize("signal", ["random", "burst-random"])
def test_random_waves_have_nothing_in_common(signal: Broadband) -> None:
    plan = plan_of(signal, blocks=20)
    one, other = make_waves(plan, "low", 0, wave_layout(plan, 20, plan.block_s), 2)
    assert abs(np.corrcoef(one.samples, other.samples)[0, 1]) < 0.05


@pytest.mark.parametrize("signal", BROADBAND)
def test_the_first_shaker_plays_what_it_plays_alone_in_its_first_wave(signal: Broadband) -> None:
    plan = plan_of(signal)
    layout = wave_layout(plan, 2, plan.block_s)
    alone = make_wave(plan, "low", 0, layout)
    np.testing.assert_array_equal(make_waves(plan, "low", 0, layout, 2)[0].samples, alone.samples)


def test_blocks_are_shared_out_among_the_waves_of_a_periodic_drive() -> None:
    def sizes(plan: BroadbandPlan, most: int, shakers: int) -> list[int]:
        found: list[int] = []
        while sum(found) < plan.blocks:
            found.append(blocks_of_wave(plan, len(found), plan.blocks - sum(found), most, shakers))
        return found

    assert sizes(plan_of("chirp", blocks=7), 20, 3) == [3, 2, 2]
    assert sizes(plan_of("pseudo-random", blocks=20), 4, 2) == [4, 4, 4, 4, 2, 2]
    assert sizes(plan_of("random", blocks=20), 30, 2) == [20]
    assert sizes(plan_of("chirp", blocks=20), 30, 1) == [20]


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"signal": "random", "blocks": 2}, "blocks: 2 cannot separate 2 shakers and the noise; allowed: 3 or more"),
        ({"signal": "chirp", "blocks": 3}, "allowed: 4 or more, two in each of 2 waves"),
        ({"signal": "chirp", "blocks_per_wave": 1}, "blocks_per_wave: 1 of a periodic drive shows no noise"),
        ({"signal": "pseudo-random", "detection_lines": True, "blocks": 8, "blocks_per_wave": 2}, "detection_lines"),
        ({"signal": "random", "levels_v": {"low": 3.0}}, r"levels_v: low, shaker 2 has a peak of .* V"),
    ],
)
def test_what_cannot_tell_the_forces_apart_is_rejected_before_anything_moves(
    both: Rig, fields: dict[str, object], words: str
) -> None:
    with pytest.raises(PlanError, match=words):
        require_possible(BroadbandPlan.model_validate({"shakers": "all"} | fields), both, INFO)


def test_a_wave_too_short_for_two_blocks_and_a_stroke_that_nobody_sees_are_said(both: Rig) -> None:
    assert both.limits is not None
    short = both.model_copy(update={"limits": both.limits.model_copy(update={"max_burst_s": 4.0})})
    with pytest.raises(PlanError, match="a wave of 2 blocks lasts"):
        require_possible(plan_of("chirp"), short, INFO)
    stroke = both.model_copy(update={"limits": both.limits.model_copy(update={"stroke_m": 0.005})})
    require_possible(plan_of("chirp"), stroke, INFO)
    unseen = stroke.model_copy(update={"channels": tuple(c for c in both.channels if c.point != 9)})
    with pytest.raises(PlanError, match="no response at the shaker point 9 measures the stroke"):
        require_possible(plan_of("chirp"), unseen, INFO)


def test_a_bench_of_one_output_and_a_generator_say_that_they_cannot(both: Rig, link_rig: Rig) -> None:
    class OneOutput(ScriptedBench):
        def play_wave(self, wave: object) -> int:
            raise AssertionError(wave)

    bench = OneOutput(link_rig)
    assert not isinstance(bench, DrivesSeveralShakers)
    with pytest.raises(UnsupportedError, match="drives one shaker, and the plan drives 2 at once"):
        require_waves(plan_of("random"), bench, both)
    require_waves(plan_of("random", shakers="first"), bench, both)
    driven = both.model_copy(update={"excitation": Excitation(kind="generator", output="COM3")})
    with pytest.raises(UnsupportedError, match="a sine generator plays no random drive"):
        require_waves(plan_of("random"), open_bench(URL, both), driven)


@pytest.mark.parametrize(("shakers", "driven"), [("all", (4, 9)), ("first", (4,))])
def test_blocks_say_which_points_were_driven(store: Store, both: Rig, shakers: str, driven: tuple[int, ...]) -> None:
    bench = open_bench(URL, both)
    run = record_run(bench, both, plan_of("chirp", shakers=shakers, blocks=4), store, lambda _: None)
    bench.close()
    assert {b.driven_points for b in store.blocks(run)} == {driven}
    waves = {row.note.facts["wave"] for row in store.catalogue.blocks(run)}
    assert waves == ({1.0, 2.0} if shakers == "all" else {1.0})


def test_beyond_a_limit_at_the_second_force_the_run_ends_with_all_outputs_at_zero(store: Store, both: Rig) -> None:
    volts = both.forces[1].sensitivity_v_per_unit
    assert isinstance(volts, dict)
    # What is read of it is two hundred times what there is.
    louder = both.forces[1].model_copy(update={"sensitivity_v_per_unit": {t: v / 200 for t, v in volts.items()}})
    channels = tuple(louder if c.name == TIP else c for c in both.channels)
    bench = open_bench(URL, both)
    believed = both.model_copy(update={"channels": channels})
    with pytest.raises(SafetyError, match=f"beyond the abort limit: {TIP} "):
        record_run(bench, believed, plan_of("random"), store, lambda _: None)
    bench.start()
    samples = bench.read(2000, 1.0).samples[[c.index for c in both.forces]].astype(float)
    assert np.all(samples.std(axis=1) < 3)
    bench.close()


@pytest.mark.parametrize("kind", ["dead", "unplugged", "clipped"])
@pytest.mark.parametrize("signal", ["random", "pseudo-random"])
def test_a_force_channel_that_fails_in_a_wave_is_named_whichever_it_is(
    store: Store, both: Rig, signal: Broadband, kind: Kind
) -> None:
    for channel in both.forces:
        bench = FaultyBench(open_bench(URL, both), ChannelFault(kind, channel.index))
        with pytest.raises(SafetyError, match=f"^{channel.name} "):
            record_run(bench, both, plan_of(signal), store, lambda _: None)
        bench.close()


def test_a_shaker_whose_force_is_not_there_from_the_start_is_named(store: Store, both: Rig) -> None:
    """Its amplifier is off: the channel shows its noise, and follows no drive."""
    bench = FaultyBench(open_bench(URL, both), ChannelFault("unplugged", both.forces[1].index, part=-0.01))
    with pytest.raises(SafetyError, match=TIP):
        record_run(bench, both, plan_of("pseudo-random"), store, lambda _: None)
    bench.close()


@pytest.mark.parametrize("signal", ["random", "burst-random", "pseudo-random"])
def test_force_plugs_that_have_changed_places_are_found_in_the_first_block(
    store: Store, both: Rig, signal: Broadband
) -> None:
    one, other = both.forces
    bench = FaultyBench(open_bench(URL, both), ChannelFault("swapped", one.index, part=-0.01, other=other.index))
    with pytest.raises(
        SafetyError, match=f"{one.name} follows the drive of {other.name}'s shaker, {other.name} follows"
    ):
        record_run(bench, both, plan_of(signal), store, lambda _: None)
    bench.close()
    assert not [row for row in store.catalogue.blocks(store.catalogue.runs()[-1].id) if row.note.accepted]


def test_each_force_follows_its_own_drive_whatever_the_converter_delays() -> None:
    plan = plan_of("pseudo-random")
    layout = wave_layout(plan, 3, plan.block_s)
    waves = make_waves(plan, "low", 1, layout, 3)
    times = layout.lead_s + np.arange(2048) / 2000.0
    mixed = np.eye(3) + 0.4 * (1 - np.eye(3))
    for delay_s in (0.0, 0.004, 0.02):
        forces = mixed @ np.stack([wave.at(times - delay_s) for wave in waves])
        assert match_forces_to_drives(forces, waves, layout.lead_s, 2000.0) == [0, 1, 2]
        assert match_forces_to_drives(forces[[2, 1, 0]], waves, layout.lead_s, 2000.0) == [2, 1, 0]


def test_chirps_are_alike_in_one_wave_and_each_force_is_taken_for_its_own() -> None:
    plan = plan_of("chirp")
    layout = wave_layout(plan, 3, plan.block_s)
    waves = make_waves(plan, "low", 0, layout, 2)
    times = layout.lead_s + np.arange(2048) / 2000.0
    assert match_forces_to_drives(np.stack([w.at(times) for w in waves[::-1]]), waves, layout.lead_s, 2000.0) == [
        0,
        1,
    ]
