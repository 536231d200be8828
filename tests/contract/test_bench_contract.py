"""What every bench must do, whatever is behind it: the docstrings of the bench protocol as tests.

Add another backend to BENCHES in conftest.py, and it must pass all of them. What a bench cannot do at all must be a
typed error, which is held here too.
"""

from collections.abc import Callable

import numpy as np
import pytest

from modallab.bench.loader import open_bench
from modallab.bench.protocol import AcquisitionRequest, Bench, Burst, DeliveredSampling
from modallab.core.errors import BenchError, ConfigurationError, ModallabError, UnsupportedError
from modallab.core.rig import Rig
from modallab.core.units import SI_UNIT, TO_SI

REQUESTS = [AcquisitionRequest("impact", 2000.0), AcquisitionRequest("sine", 1000.0)]
TIMEOUT_S = 10.0


@pytest.fixture(params=REQUESTS, ids=lambda r: r.test)
def delivery(request: pytest.FixtureRequest, bench: Bench) -> DeliveredSampling:
    """What a configured and started bench said it would deliver."""
    delivered = bench.configure(request.param)
    bench.start()
    return delivered


def test_it_is_a_bench_that_says_what_it_is(bench: Bench):
    assert isinstance(bench, Bench)
    info = bench.info
    assert "://" in info.url
    assert info.devices
    assert all(name and isinstance(serial, str) for name, serial in info.devices)
    assert all(isinstance(value, str) for value in info.facts.values())


@pytest.mark.parametrize("request_", REQUESTS, ids=lambda r: r.test)
def test_configure_says_what_will_be_delivered(bench: Bench, rig: Rig, request_: AcquisitionRequest):
    delivery = bench.configure(request_)
    n = len(rig.channels)
    assert delivery.requested_rate_hz == request_.rate_hz
    # A device may not give the requested rate, but it must say so, and be near.
    assert delivery.actual_rate_hz == pytest.approx(request_.rate_hz, rel=0.7)
    assert delivery.rate_hz > 0
    assert delivery.scale.shape == (n,)
    assert (delivery.scale > 0).all()
    assert len(delivery.units) == n
    for unit, channel in zip(delivery.units, rig.channels, strict=True):
        assert unit in TO_SI["voltage"] or unit in TO_SI[channel.quantity]
        assert SI_UNIT[channel.quantity]
    assert delivery.dtype.kind in "if"


def test_the_sample_count_begins_at_zero_and_has_no_gap(bench: Bench, rig: Rig, delivery: DeliveredSampling):
    expected = 0
    for count in (1, 100, 512, 3, 250):
        chunk = bench.read(count, TIMEOUT_S)
        assert chunk.first_sample == expected
        assert chunk.samples.shape == (len(rig.channels), count)
        assert chunk.samples.dtype == delivery.dtype
        assert chunk.overload.shape == (len(rig.channels),)
        assert chunk.overload.dtype == np.bool_
        expected += count


def test_what_was_delivered_is_not_written_over(bench: Bench, delivery: DeliveredSampling):
    first = bench.read(500, TIMEOUT_S).samples
    kept = first.copy()
    bench.read(700, TIMEOUT_S)
    np.testing.assert_array_equal(first, kept)
    assert delivery.scale.size == len(first)


def test_the_scale_turns_samples_into_what_the_units_say(bench: Bench, rig: Rig, delivery: DeliveredSampling):
    samples = bench.read(512, TIMEOUT_S).samples * delivery.scale[:, None]
    for row, unit, channel in zip(samples, delivery.units, rig.channels, strict=True):
        if unit in TO_SI["voltage"]:
            limit = (channel.range_v or 10.0) / TO_SI["voltage"][unit]
            assert np.abs(row).max() <= limit * (1 + 1e-9)


def test_counting_starts_again_after_stop_and_start(bench: Bench, delivery: DeliveredSampling):
    bench.read(300, TIMEOUT_S)
    bench.stop()
    bench.start()
    assert bench.read(10, TIMEOUT_S).first_sample == 0
    assert delivery.rate_hz > 0


def test_it_can_be_configured_for_another_test_after_stop(bench: Bench):
    for request in (*REQUESTS, *REQUESTS):
        delivery = bench.configure(request)
        bench.start()
        assert delivery.requested_rate_hz == request.rate_hz
        assert bench.read(64, TIMEOUT_S).samples.shape[1] == 64
        bench.stop()


def test_zero_stop_and_close_are_legal_in_every_state(bench: Bench):
    def end_all() -> None:
        bench.zero()
        bench.stop()
        bench.stop()
        bench.zero()

    end_all()
    bench.configure(REQUESTS[0])
    end_all()
    bench.configure(REQUESTS[0])
    bench.start()
    end_all()
    bench.configure(REQUESTS[0])
    bench.start()
    bench.close()
    bench.close()
    end_all()


@pytest.mark.parametrize(
    "call",
    [
        lambda b: b.read(10, TIMEOUT_S),
        lambda b: b.play(Burst(20.0, 0.1, 0.1, 0.1)),
        lambda b: b.start(),
    ],
    ids=["read", "play", "start"],
)
def test_the_wrong_order_is_a_typed_error(bench: Bench, call: Callable[[Bench], object]):
    with pytest.raises(ConfigurationError) as caught:
        call(bench)
    assert caught.value.remedy


def test_configuring_or_starting_while_it_runs_is_rejected(bench: Bench, delivery: DeliveredSampling):
    with pytest.raises(BenchError):
        bench.configure(REQUESTS[0])
    with pytest.raises(BenchError):
        bench.start()
    assert bench.read(10, TIMEOUT_S).first_sample == 0
    assert delivery.rate_hz > 0


def test_reading_after_stop_and_after_close_is_rejected(bench: Bench, delivery: DeliveredSampling):
    bench.stop()
    with pytest.raises(BenchError):
        bench.read(10, TIMEOUT_S)
    bench.close()
    with pytest.raises(BenchError):
        bench.read(10, TIMEOUT_S)
    with pytest.raises(BenchError):
        bench.configure(AcquisitionRequest("impact", delivery.rate_hz))


@pytest.mark.parametrize("count", [0, -5])
def test_a_read_of_nothing_is_rejected(bench: Bench, delivery: DeliveredSampling, count: int):
    with pytest.raises(ConfigurationError):
        bench.read(count, TIMEOUT_S)
    assert delivery.rate_hz > 0


@pytest.mark.parametrize("rate_hz", [0.0, -1.0, float("nan"), float("inf"), 1e12])
def test_an_impossible_rate_is_rejected(bench: Bench, rate_hz: float):
    with pytest.raises(ConfigurationError):
        bench.configure(AcquisitionRequest("impact", rate_hz))


def test_a_prompt_for_a_hit_disturbs_no_count(bench: Bench, rig: Rig, delivery: DeliveredSampling):
    bench.read(100, TIMEOUT_S)
    bench.prompt_hit(rig.points[-1].id)
    assert bench.read(100, TIMEOUT_S).first_sample == 100
    assert delivery.rate_hz > 0


def test_a_bench_that_drives_plays_a_burst_that_ends_by_itself(bench: Bench, rig: Rig):
    delivery = bench.configure(AcquisitionRequest("sine", 1000.0))
    bench.start()
    row, scale = rig.force_channel.index, delivery.scale[rig.force_channel.index]
    before = (bench.read(200, TIMEOUT_S).samples[row] * scale).std()
    burst = Burst(20.0, 0.5, 0.1, 1.0)
    if not bench.info.can_drive:
        assert_output_rejected(bench, burst)
        return
    begin = bench.play(burst)
    assert begin >= 200
    count = begin - 200 + round((burst.duration_s + 1.0) * delivery.rate_hz)
    chunk = bench.read(count, TIMEOUT_S + count / delivery.rate_hz)
    force = chunk.samples[row] * scale
    rise, fall = begin - 200, begin - 200 + round(burst.duration_s * delivery.rate_hz)
    margin = round(0.1 * delivery.rate_hz)
    during = force[rise + margin : fall - margin].std()
    assert during > 20 * before
    assert force[fall + margin :].std() < 0.1 * during


def assert_output_rejected(bench: Bench, burst: Burst) -> None:
    """A bench without an output says so, and goes on reading."""
    with pytest.raises(UnsupportedError) as caught:
        bench.play(burst)
    assert caught.value.remedy
    before = bench.read(1, TIMEOUT_S).first_sample
    assert bench.read(1, TIMEOUT_S).first_sample == before + 1


@pytest.mark.parametrize("end", ["zero", "stop"])
def test_zero_and_stop_end_a_burst(bench: Bench, rig: Rig, end: str):
    delivery = bench.configure(AcquisitionRequest("sine", 1000.0))
    bench.start()
    if not bench.info.can_drive:
        assert_output_rejected(bench, Burst(20.0, 0.5, 0.1, 30.0))
        return
    bench.play(Burst(20.0, 0.5, 0.1, 30.0))
    row = rig.force_channel.index
    driven = bench.read(1000, TIMEOUT_S).samples[row, 500:].std()
    if end == "zero":
        bench.zero()
    else:
        bench.stop()
        bench.start()
    settle = round(0.2 * delivery.rate_hz)
    assert bench.read(1000, TIMEOUT_S).samples[row, settle:].std() < 0.1 * driven


def test_errors_of_the_rig_are_typed_too(bench: Bench, delivery: DeliveredSampling):
    with pytest.raises(ModallabError):
        bench.prompt_hit(10_000)
    assert delivery.rate_hz > 0


def test_an_unknown_scheme_is_rejected_with_those_that_exist(rig: Rig):
    with pytest.raises(ConfigurationError, match="sim://"):
        open_bench("nowhere://bench", rig)
