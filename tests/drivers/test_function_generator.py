"""The generator driver with the real pyserial, against an instrument behind a pseudo-terminal, in every dialect."""

import threading
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest
from ni_server import NiServer

from modallab.bench.loader import open_bench, open_output
from modallab.bench.protocol import AcquisitionRequest, Burst
from modallab.core.errors import ConfigurationError, DeviceGoneError, OutputLostError
from modallab.core.hardware import Excitation
from modallab.core.rig import Rig
from modallab_drivers.function_generator.dialects import LANGUAGES
from modallab_drivers.function_generator.generator import Generator, open_generator
from modallab_simulators.ni_daqmx_server.lines import OutputLine
from modallab_simulators.scpi_generator import SINE_DIALECTS, PtyGenerator, ScpiGenerator

RATE_HZ = 1000.0
BURST = Burst(20.0, 0.5, 0.2, 1.0)


class Clock:
    """Bench time, which the test lets go on."""

    def __init__(self) -> None:
        self.time_s = 10.0

    def now(self) -> float:
        return self.time_s


@dataclass
class Instrument:
    clock: Clock
    line: OutputLine
    device: ScpiGenerator
    pty: PtyGenerator
    dialect: str

    def rig(self, rig: Rig, dialect: str | None = None) -> Rig:
        return driven(rig, self.pty.port, dialect or self.dialect)


def driven(rig: Rig, port: str, dialect: str) -> Rig:
    return rig.model_copy(update={"excitation": Excitation(kind="generator", output=port, dialect=dialect)})


def instrument_of(dialect: str) -> Instrument:
    clock, line = Clock(), OutputLine()
    device = ScpiGenerator(SINE_DIALECTS[dialect], line, clock)
    return Instrument(clock, line, device, PtyGenerator(device), dialect)


@pytest.fixture(params=sorted(LANGUAGES))
def instrument(request: pytest.FixtureRequest) -> Iterator[Instrument]:
    made = instrument_of(request.param)
    yield made
    made.pty.close()


@pytest.fixture
def keysight() -> Iterator[Instrument]:
    made = instrument_of("keysight-33500")
    yield made
    made.pty.close()


def pace(instrument: Instrument, generator: Generator, first: int, count: int) -> None:
    """Let `count` samples go by, as a bench reads them."""
    now = first
    while now < first + count:
        event = generator.next_event()
        now = first + count if event is None else max(now, min(event, first + count))
        instrument.clock.time_s = 10.0 + now / RATE_HZ
        generator.tick(now)
        if event is not None and now < first + count:
            continue


def test_a_burst_rises_holds_falls_and_ends_at_zero(instrument: Instrument, rig: Rig):
    generator = open_generator(instrument.rig(rig))
    generator.play(BURST, 0, RATE_HZ)
    assert generator.busy
    pace(instrument, generator, 0, 2000)
    assert not generator.busy
    t = 10.0 + np.arange(0, 2.0, 1e-4)
    volts = instrument.line.volts(t)
    hold = volts[(t > 10.3) & (t < 11.1)]
    # Into an open end what is asked for is there, not twice as much.
    assert np.abs(hold).max() == pytest.approx(0.5, rel=1e-3)
    assert np.abs(volts[t < 10.02]).max() < 0.08
    assert np.abs(volts[(t > 10.0) & (t < 10.1)]).max() < 0.3
    assert (volts[t > 10.0 + BURST.duration_s + 0.06] == 0.0).all()
    generator.close()


def test_without_its_driver_a_burst_ends_by_itself(instrument: Instrument, rig: Rig):
    generator = open_generator(instrument.rig(rig))
    generator.play(BURST, 0, RATE_HZ)
    pace(instrument, generator, 0, 500)
    # From here on nobody speaks to it.
    t = 10.5 + np.arange(0, 3.0, 1e-4)
    volts = instrument.line.volts(t)
    assert np.abs(volts[:1000]).max() > 0.4
    assert (volts[t > 10.0 + BURST.duration_s + 1 / 20 + 0.01] == 0.0).all()


def test_zero_switches_it_off_at_once(instrument: Instrument, rig: Rig):
    generator = open_generator(instrument.rig(rig))
    generator.play(BURST, 0, RATE_HZ)
    pace(instrument, generator, 0, 600)
    generator.zero()
    assert (instrument.line.volts(instrument.clock.time_s + np.arange(0.003, 1.0, 1e-3)) == 0.0).all()
    assert generator.next_event() is None


@pytest.mark.parametrize("reported", sorted(LANGUAGES))
def test_another_makers_dialect_is_rejected_naming_the_field(instrument: Instrument, rig: Rig, reported: str):
    if reported == instrument.dialect:
        open_generator(instrument.rig(rig)).close()
        return
    with pytest.raises(ConfigurationError, match=r"excitation\.dialect"):
        open_generator(instrument.rig(rig, reported))
    assert instrument.line.at(instrument.clock.time_s) == 0.0


def test_a_value_that_was_clipped_is_seen_and_the_output_is_off(instrument: Instrument, rig: Rig):
    generator = open_generator(instrument.rig(rig))
    instrument.pty.arm_fault("clipped-set-point 0.2")
    generator.play(BURST, 0, RATE_HZ)
    with pytest.raises(ConfigurationError, match=r"amplitude: .* was set, the generator reports .*0\.2|2\.0+E-01"):
        pace(instrument, generator, 0, 1000)
    assert instrument.line.at(instrument.clock.time_s + 0.01) == 0.0


def test_what_is_out_of_range_is_reported_by_the_error_queue(keysight: Instrument, rig: Rig):
    generator = open_generator(keysight.rig(rig))
    with pytest.raises(ConfigurationError, match="clipped"):
        generator.set("frequency", 1e9)


def test_a_dead_line_and_a_pulled_plug_are_devices_that_are_gone(
    keysight: Instrument, rig: Rig, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("modallab_drivers.function_generator.line.TIMEOUT_S", 0.1)
    generator = open_generator(keysight.rig(rig))
    keysight.pty.arm_fault("dead-line")
    with pytest.raises(DeviceGoneError, match="no answer"):
        generator.set("frequency", 10.0)
    keysight.pty.arm_fault("unplugged")
    with pytest.raises(DeviceGoneError):
        generator.set("frequency", 10.0)
    with pytest.raises(DeviceGoneError, match=r"excitation\.output"):
        open_generator(driven(rig, "/dev/no-such-port", "keysight-33500"))


def test_a_pulled_plug_leaves_nobody_who_reads(keysight: Instrument, rig: Rig):
    """Its thread would read from, and write into, whatever is opened next under the same number."""
    generator = open_generator(keysight.rig(rig))
    keysight.pty.close()
    assert "scpi" not in [thread.name for thread in threading.enumerate()]
    keysight.pty.close()
    with pytest.raises(DeviceGoneError):
        generator.set("frequency", 10.0)


def test_a_limit_above_the_generators_range_is_rejected_naming_the_field(keysight: Instrument, rig: Rig):
    assert rig.limits is not None
    loud = rig.model_copy(update={"limits": rig.limits.model_copy(update={"drive_v": 11.0})})
    with pytest.raises(ConfigurationError, match=r"limits\.drive_v"):
        open_generator(keysight.rig(loud))


@pytest.mark.thorough("starts a server of devices and a generator")
def test_the_generator_drives_the_bench_that_ni_devices_listen_to(rig: Rig):
    with NiServer(rig, "9215", "--generator", "siglent-sdg") as server:
        server.say("preamplifiers sine")
        with_generator = driven(rig, server.generator, "siglent-sdg")
        bench = open_bench(server.url, with_generator)
        assert bench.info.can_drive
        bench.configure(AcquisitionRequest("sine", RATE_HZ))
        bench.start()
        row = rig.force_channel.index
        before = bench.read(500, 1.0).samples[row].std()
        begin = bench.play(Burst(20.0, 0.5, 0.2, 1.0))
        chunk = bench.read(3000, 5.0)
        on = chunk.samples[row, begin - 500 + 300 : begin - 500 + 1100].std()
        assert on > 100 * before
        assert chunk.samples[row, -1000:].std() < 3 * before
        # A second handle ends a burst the first one plays.
        bench.play(Burst(20.0, 0.5, 0.2, 30.0))
        bench.read(1000, 5.0)
        handle = open_output(server.url, with_generator)
        assert handle is not None
        handle.zero()
        handle.close()
        # Its owner finds the output switched off.
        with pytest.raises(OutputLostError, match="output: ON was set, the generator now reports OFF"):
            bench.read(200, 5.0)
        bench.read(200, 5.0)
        assert server.say("levels")["generator"] == 0.0
        bench.close()
