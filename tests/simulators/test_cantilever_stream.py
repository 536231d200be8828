"""The stream of counts: noise, quantisation, full scale, and that it does not depend on how it is read."""

import time
from collections.abc import Callable

import numpy as np
import pytest

from modallab.bench.protocol import AcquisitionRequest, Bench, Burst
from modallab.core.errors import BenchTimeoutError, ConfigurationError
from modallab.core.rig import Channel, Converter, Rig
from modallab_simulators.cantilever import open_bench

Running = Callable[..., Bench]


def run(bench: Bench, sizes: list[int]) -> np.ndarray:
    """The same session, read in pieces of the given sizes: a burst, a cut, two hits, at fixed sample counts."""
    calls = {
        500: lambda: bench.prompt_hit(6),
        1300: lambda: bench.play(Burst(31.0, 0.3, 0.1, 2.0)),
        2880: bench.zero,
        3000: lambda: bench.prompt_hit(10),
    }
    pieces, position, turn = [], 0, 0
    while position < 9000:
        if position in calls:
            calls[position]()
        count = min([sizes[turn % len(sizes)], 9000 - position, *(c - position for c in calls if c > position)])
        chunk = bench.read(count, 1.0)
        assert chunk.first_sample == position
        pieces.append(chunk.samples)
        position, turn = position + count, turn + 1
    return np.concatenate(pieces, axis=1)


def test_samples_do_not_depend_on_how_they_are_read(running: Running):
    whole = run(running("seed=11"), [9000])
    for sizes in ([1, 7, 960], [64], [959, 961, 1]):
        np.testing.assert_array_equal(run(running("seed=11"), sizes), whole)


def test_seeds_distinguish_benches_and_starts_too(running: Running):
    bench = running("seed=11")
    first = run(bench, [500])
    bench.stop()
    bench.start()
    assert not np.array_equal(run(bench, [500]), first)
    assert not np.array_equal(run(running("seed=12"), [500]), first)


def test_noise_and_quantisation(running: Running):
    samples = running("seed=1").read(40_000, 1.0).samples
    assert samples.dtype == np.int16
    volts = samples * (10 / 2**15)
    # White noise of 0.3 mV under a count of 0.305 mV, whose own variance is count^2 / 12.
    expected = np.hypot(0.0003, 10 / 2**15 / np.sqrt(12))
    np.testing.assert_allclose(volts.std(axis=1), expected, rtol=0.03)
    assert np.abs(np.corrcoef(volts) - np.eye(11)).max() < 0.03
    lagged = (volts[:, 1:] * volts[:, :-1]).mean(axis=1) / expected**2
    assert np.abs(lagged).max() < 0.03


def test_full_scale_clips_and_is_flagged(running: Running):
    bench = running("seed=1&n_per_v=20", "sine", 1000.0)
    bench.read(500, 1.0)
    bench.play(Burst(20.0, 9.0, 0.1, 2.0))
    chunk = bench.read(2000, 1.0)
    assert chunk.overload[0]
    assert chunk.samples[0].max() == 2**15 - 1
    assert chunk.samples[0].min() == -(2**15)
    bench.read(30_000, 1.0)
    assert not bench.read(100, 1.0).overload[0]


def test_only_the_channel_beyond_its_range_is_flagged(rig: Rig):
    narrow = [c.model_copy(update={"range_v": 0.01}) if c.name == "a10" else c for c in rig.channels]
    bench = open_bench("sim://cantilever", rig.model_copy(update={"channels": tuple(narrow)}))
    delivery = bench.configure(AcquisitionRequest("sine", 1000.0))
    assert delivery.scale[10] == pytest.approx(0.01 / 2**15)
    bench.start()
    bench.play(Burst(20.0, 0.5, 0.1, 2.0))
    assert bench.read(2000, 1.0).overload.tolist() == [False] * 10 + [True]


def test_sensitivity_direction_and_unit_of_a_channel_are_applied(rig: Rig):
    def with_tip(**changes: object) -> np.ndarray:
        tip = Channel.model_validate({**rig.channels[10].model_dump(), **changes})
        other = rig.model_copy(update={"channels": (*rig.channels[:10], tip), "converter": Converter(noise_rms_v=0)})
        bench = open_bench("sim://cantilever?seed=2&bad_hits=0", other)
        bench.configure(AcquisitionRequest("impact", 2000.0))
        bench.start()
        bench.play(Burst(5.0, 5.0, 1.0, 3.0))
        return bench.read(8000, 1.0).samples[10].astype(float)

    plain = with_tip()
    assert np.abs(plain).max() > 500
    np.testing.assert_allclose(with_tip(direction="-z"), -plain, atol=1)
    np.testing.assert_allclose(with_tip(sensitivity_v_per_unit=0.02), 2 * plain, atol=2)
    np.testing.assert_allclose(with_tip(unit="g", sensitivity_v_per_unit=0.0980665), plain, atol=1)
    assert not with_tip(direction="+y").any()


def test_both_tests_have_their_own_sensitivities(running: Running):
    sine, impact = running("seed=2", "sine", 1000.0), running("seed=2", "impact", 1000.0)
    for bench in (sine, impact):
        bench.play(Burst(5.0, 5.0, 1.0, 3.0))
    ratio = sine.read(4000, 1.0).samples.std(axis=1) / impact.read(4000, 1.0).samples.std(axis=1)
    assert ratio[0] == pytest.approx(25, rel=0.01)
    assert ratio[10] == pytest.approx(10, rel=0.01)


@pytest.mark.parametrize(("bits", "dtype"), [(12, np.int16), (16, np.int16), (24, np.int32)])
def test_the_converter_is_the_rigs(rig: Rig, bits: int, dtype: type):
    other = rig.model_copy(update={"converter": Converter(bits=bits, range_v=5.0, noise_rms_v=0.003)})
    plain = tuple(c.model_copy(update={"range_v": None}) for c in rig.channels)
    bench = open_bench("sim://cantilever", other.model_copy(update={"channels": plain}))
    delivery = bench.configure(AcquisitionRequest("impact", 2000.0))
    bench.start()
    samples = bench.read(20_000, 1.0).samples
    assert samples.dtype == delivery.dtype == dtype
    np.testing.assert_allclose(delivery.scale, 5.0 / 2 ** (bits - 1))
    expected = np.hypot(0.003, 5.0 / 2 ** (bits - 1) / np.sqrt(12))
    np.testing.assert_allclose((samples * delivery.scale[:, None]).std(axis=1), expected, rtol=0.03)


def test_paced_reads_take_real_time_and_time_out_without_loss(rig: Rig):
    bench = open_bench("sim://cantilever?pace=1", rig)
    assert bench.info.real_time
    bench.configure(AcquisitionRequest("impact", 2000.0))
    began = time.monotonic()
    bench.start()
    with pytest.raises(BenchTimeoutError, match="nothing is lost"):
        bench.read(2000, 0.01)
    chunk = bench.read(200, 1.0)
    assert chunk.first_sample == 0
    assert time.monotonic() - began >= 0.1


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"model": "unknown"}, "describes no cantilever"),
        ({"mass": 0.001}, "mass_kg"),
        ({"point": None}, "stands at no point"),
        ({"force": "+x"}, "measures along"),
        ({"thickness": 8.0}, "above 1000 Hz"),
        ({"thickness": 1e-7}, "modes below"),
    ],
)
def test_rigs_it_cannot_be_are_rejected(rig: Rig, changes: dict[str, object], says: str):
    beam, channels = rig.beam, list(rig.channels)
    if "mass" in changes:
        channels[3] = channels[3].model_copy(update={"mass_kg": changes["mass"]})
    if "point" in changes:
        channels[3] = channels[3].model_copy(update={"point": None})
    if "force" in changes:
        channels[0] = channels[0].model_copy(update={"direction": changes["force"]})
    if "thickness" in changes:
        beam = beam.model_copy(update={"thickness_m": changes["thickness"]})
    other = {"channels": tuple(channels), "beam": beam, "model": changes.get("model", rig.model)}
    with pytest.raises(ConfigurationError, match=says):
        open_bench("sim://cantilever", rig.model_copy(update=other)).configure(AcquisitionRequest("impact", 2000.0))
