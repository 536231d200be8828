"""A generator while a burst is on: what a hand at the front panel, a slow line or a dead one does."""

import time
from collections.abc import Iterator

import numpy as np
import pytest
from generator_bench import RATE_HZ, Bench, make

from modallab.bench.protocol import Burst
from modallab.core.errors import BenchError, ConfigurationError, DeviceGoneError, OutputLostError
from modallab.core.hardware import Excitation
from modallab_drivers.function_generator.dialects import LANGUAGES
from modallab_drivers.function_generator.generator import Generator, emergency_off

BURST = Burst(50.0, 1.0, 0.2, 3.0)
HALF_S = BURST.ramp_s + BURST.hold_s / 2
"""Of a burst's time: what has brought it down by then, however busy the machine is, was not its own end."""
PANEL = [
    "output OFF", "amplitude 5", "frequency 55", "load 50", "function SQU", "offset 0.5", "burst OFF", "cycles 100000",
]  # fmt: skip


@pytest.fixture(params=["pty", "socket", "hislip"])
def way(request: pytest.FixtureRequest) -> str:
    return request.param


@pytest.fixture
def bench(way: str) -> Iterator[Bench]:
    made = make("keysight-33500", way)
    yield made
    made.port.close()


def holding(bench: Bench) -> tuple[Generator, float]:
    """A generator in the hold of a burst."""
    generator = bench.open()
    began = time.monotonic()
    generator.play(BURST, 0, RATE_HZ)
    bench.pace(generator, began, 0.4)
    return generator, began


def tick_through(generator: Generator, first: int, last: int) -> None:
    for now in range(first, last + 1, 5):
        generator.tick(now)


@pytest.mark.parametrize("dialect", sorted(LANGUAGES))
@pytest.mark.parametrize("change", PANEL)
def test_a_hand_at_the_front_panel_is_noticed_within_a_poll_and_ends_the_burst(
    dialect: str, change: str, monkeypatch: pytest.MonkeyPatch
):
    # How many questions fit into a look is the machine's; here all do, and time is counted in samples.
    monkeypatch.setattr("modallab_drivers.function_generator.instrument.LOOK_S", 10.0)
    bench = make(dialect)
    generator = bench.open()
    generator.play(BURST, 0, RATE_HZ)
    tick_through(generator, 0, 400)
    bench.port.arm_fault(f"front-panel {change}")
    with pytest.raises(OutputLostError, match=f"{change.split()[0]}: .* was set, the generator now reports"):
        tick_through(generator, 400, 600)
    assert not bench.volts(time.monotonic() + 0.01, time.monotonic() + 0.2).any()
    # The settings were set again: the next burst is as it should be.
    generator.play(BURST, 0, RATE_HZ)
    generator.close()
    bench.port.close()


def test_a_generator_that_was_switched_off_and_on_is_noticed_before_the_next_burst(bench: Bench):
    generator = bench.open()
    bench.port.arm_fault("power-cycle")
    with pytest.raises(OutputLostError, match="switched off and on"):
        generator.play(BURST, 0, RATE_HZ)
    generator.play(BURST, 0, RATE_HZ)
    generator.close()


def test_what_was_changed_in_the_last_moment_of_a_block_is_seen_when_its_facts_are_asked(bench: Bench):
    generator, _ = holding(bench)
    assert generator.facts() == {"generator_frequency_hz": 50.0, "generator_amplitude_v": 1.0}
    bench.port.arm_fault("front-panel amplitude 3")
    with pytest.raises(OutputLostError, match="amplitude"):
        generator.facts()


def test_a_late_answer_answers_no_other_question(bench: Bench, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("modallab_drivers.function_generator.line.TIMEOUT_S", 0.6)
    generator, began = holding(bench)
    bench.port.arm_fault("late-answer 0.8")
    with pytest.raises(OutputLostError, match=r"no answer within.*the generator answers again"):
        bench.pace(generator, began, 2.0)
    assert not bench.volts(time.monotonic() + 0.01, time.monotonic() + 0.2).any()
    generator.set("frequency", 33.0)
    generator.close()


def test_a_line_that_dies_in_a_burst_names_the_amplifier(bench: Bench, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("modallab_drivers.function_generator.line.TIMEOUT_S", 0.2)
    generator, began = holding(bench)
    bench.port.arm_fault("dead-line")
    with pytest.raises(DeviceGoneError, match=r"ends by itself only after at most \d\.\d+ s") as raised:
        bench.pace(generator, began, 2.0)
    assert "amplifier off by hand" in raised.value.remedy
    with pytest.raises(DeviceGoneError) as again:
        generator.zero()
    assert "amplifier off by hand" in again.value.remedy


@pytest.mark.parametrize(
    ("fault", "named"),
    [
        ("echo", "echo"),
        ("garbage", "baud"),
        ("cut-off-answers", "line feed|no answer"),
        ("wrong-terminator", "line feed|no answer"),
        ("dead-line", "no answer"),
    ],
)
def test_a_line_that_cannot_be_used_is_named_before_anything_is_driven(
    bench: Bench, way: str, fault: str, named: str, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("modallab_drivers.function_generator.line.TIMEOUT_S", 0.2)
    bench.port.arm_fault(fault)
    if (way, fault) == ("hislip", "wrong-terminator"):
        # There the protocol marks the end of an answer, and what stands at its end is of no matter.
        bench.open().close()
        return
    with pytest.raises(BenchError, match=named):
        bench.open()
    assert not bench.volts(time.monotonic(), time.monotonic() + 0.1).any()


def test_a_generator_that_ignores_off_while_it_holds_an_error_is_brought_down(bench: Bench):
    generator, _ = holding(bench)
    bench.port.arm_fault("stays-on error")
    generator.zero()
    assert not bench.volts(time.monotonic() + 0.01, time.monotonic() + 0.2).any()
    generator.close()


def test_a_generator_that_stays_on_is_at_its_lowest_and_names_the_amplifier(bench: Bench):
    generator, _ = holding(bench)
    bench.port.arm_fault("stays-on always")
    with pytest.raises(DeviceGoneError, match="still") as raised:
        generator.zero()
    assert "amplifier off by hand" in raised.value.remedy
    assert np.abs(bench.volts(time.monotonic() + 0.01, time.monotonic() + 0.2)).max() <= 0.002


def test_an_amplitude_that_is_taken_otherwise_is_rejected(bench: Bench):
    generator = bench.open()
    bench.port.arm_fault("coerced-set-point 0.9")
    began = time.monotonic()
    generator.play(BURST, 0, RATE_HZ)
    with pytest.raises(ConfigurationError, match=r"amplitude: .* was set, the generator reports"):
        bench.pace(generator, began, 1.0)
    assert not bench.volts(time.monotonic() + 0.01, time.monotonic() + 0.2).any()


@pytest.mark.parametrize("dialect", sorted(LANGUAGES))
def test_a_stop_is_a_ramp(dialect: str):
    bench = make(dialect, "socket")
    generator, began = holding(bench)
    first = time.monotonic()
    generator.zero()
    last = time.monotonic()
    assert last - began < HALF_S, "the burst may have begun to end by itself"
    # Against the sine at full level, of one ms and the next: the envelope never falls by 5 % in 1 ms.
    assert largest_step(bench, first - 0.05, last + 0.05) < 0.05
    bench.port.close()


def largest_step(bench: Bench, first_s: float, last_s: float) -> float:
    """Largest jump of the output between two samples 20 us apart, beyond the sine's own slope, as part of the level."""
    volts = bench.volts(first_s, last_s)
    return float(np.abs(np.diff(volts)).max() - 2 * np.pi * BURST.frequency_hz * BURST.amplitude_v / 50e3)


def test_an_emergency_stop_through_a_line_of_its_own_is_a_ramp_too(bench: Bench):
    _, began = holding(bench)
    first = time.monotonic()
    emergency_off(Excitation(kind="generator", output=bench.port.port, dialect="keysight-33500"))
    assert time.monotonic() - began < HALF_S, "the burst may have begun to end by itself"
    assert largest_step(bench, first - 0.05, time.monotonic() + 0.05) < 0.05
    assert not bench.volts(time.monotonic() + 0.01, time.monotonic() + 0.2).any()
