"""Several devices that sample as one: how they are bound, and what the self-test sees if they are not."""

from collections.abc import Iterator

import numpy as np
import pytest
from ni_server import NiServer

from modallab.bench.loader import open_bench
from modallab.bench.protocol import AcquisitionRequest, Burst
from modallab.commissioning.rig_check import CheckResult
from modallab.commissioning.synchronisation_check import check_common_signal, check_synchronisation, delay_between
from modallab.core.errors import ConfigurationError
from modallab.core.hardware import Synchronisation
from modallab.core.rig import Rig

RATE_HZ = 51_200.0
TONE_HZ = 1000.0
RNG = np.random.default_rng(3)
TIMES = np.arange(2 * 51_200) / RATE_HZ


def sine(times):
    return np.sin(2 * np.pi * 1000.0 * times)


def speech(times):
    """Broad-band, the same at any time that is asked for."""
    frequencies = np.random.default_rng(5).uniform(100.0, 9000.0, 200)
    return sum(np.sin(2 * np.pi * f * times + f) for f in frequencies) / 10


@pytest.mark.parametrize("signal", [sine, speech])
@pytest.mark.parametrize("delay_s", [0.0, 28e-9, 5e-6, 7.3 / RATE_HZ])
def test_the_delay_between_two_channels_is_found_within_its_sigma(signal, delay_s: float):
    noise = 1e-4 * RNG.standard_normal((2, len(TIMES)))
    found = delay_between(signal(TIMES) + noise[0], signal(TIMES - delay_s) + noise[1], RATE_HZ)
    assert found is not None
    assert abs(found.seconds - delay_s) < 5 * found.sigma_s + 1e-3 * delay_s
    # A tenth of a degree at 10 kHz differs from none.
    assert found.degrees(found.sigma_s) < 0.02


def test_two_channels_without_a_common_signal_have_no_phase():
    assert delay_between(*RNG.standard_normal((2, len(TIMES))), RATE_HZ) is None


def on(rig: Rig, inputs: list[str], method: str = "auto") -> Rig:
    """The first channels of the rig at these inputs."""
    assert rig.limits is not None
    assert rig.converter is not None
    channels = [
        c.model_copy(update={"input": name, "range_v": 5.0}) for c, name in zip(rig.channels, inputs, strict=False)
    ]
    return rig.model_copy(
        update={
            "channels": tuple(channels),
            "limits": rig.limits.model_copy(update={"drive_v": 1.0, "slew_v_per_s": 1e5}),
            "converter": rig.converter.model_copy(update={"range_v": 5.0}),
            "synchronisation": Synchronisation.model_validate({"method": method}),
        }
    )


def checked(server: NiServer, rig: Rig) -> tuple[list[CheckResult], CheckResult]:
    """What rig check says, and the phase between the first and the last channel, all on one cable."""
    names = (rig.channels[0].name, rig.channels[-1].name)
    bench = open_bench(server.url, rig)
    found = check_synchronisation(bench), check_common_signal(bench, rig, names, 0.5)
    bench.close()
    return found


@pytest.fixture(scope="module")
def cards(rig: Rig) -> Iterator[NiServer]:
    """Two cards of one chassis, every input on one cable."""
    with NiServer(on(rig, CARDS), "4461", "--cables", device="PXI1Slot2,PXI1Slot3") as server:
        yield server


@pytest.fixture(scope="module")
def usb(rig: Rig) -> Iterator[NiServer]:
    """Two devices on USB, every input on one cable."""
    with NiServer(on(rig, USB), "two-4431", "--cables", device="Dev1,Dev2") as server:
        yield server


USB = ["Dev1/ai0", "Dev1/ai1", "Dev2/ai0", "Dev2/ai1"]
CARDS = ["PXI1Slot2/ai0", "PXI1Slot2/ai1", "PXI1Slot3/ai0", "PXI1Slot3/ai1"]
CHASSIS = ["cDAQ1Mod1/ai0", "cDAQ2Mod1/ai0", "cDAQ1Mod1/ai1", "cDAQ2Mod1/ai1"]


@pytest.mark.parametrize("method", ["auto", "reference-clock", "timebase"])
def test_cards_that_can_be_synchronised_agree_within_a_tenth_of_a_degree_at_10_khz(
    cards: NiServer, rig: Rig, method: str
):
    said, phase = checked(cards, on(rig, CARDS, method))
    assert {finding.verdict for finding in said} == {"good"}
    assert phase.verdict == "good", phase.value


def off_ppm(server: NiServer, rig: Rig) -> float:
    """By how much the frequency of a played tone is off in the samples, in millionths."""
    bench = open_bench(server.url, rig)
    rate_hz = bench.configure(AcquisitionRequest("impact", RATE_HZ)).rate_hz
    bench.start()
    bench.play(Burst(TONE_HZ, 0.5, 0.05, 2.0))
    bench.read(round(0.2 * rate_hz), 5.0)
    tone = bench.read(round(1.6 * rate_hz), 5.0).samples[0].astype(np.float64)
    bench.close()
    half = tone.size // 2
    turns = np.exp(-2j * np.pi * TONE_HZ / rate_hz * np.arange(tone.size))
    phases = [np.angle(np.sum(np.hanning(half) * (tone * turns)[k : k + half])) for k in (0, half)]
    return float(1e6 * np.angle(np.exp(1j * (phases[1] - phases[0]))) / (2 * np.pi * TONE_HZ * half / rate_hz))


def test_an_output_runs_by_the_clock_of_the_inputs(cards: NiServer, rig: Rig, monkeypatch: pytest.MonkeyPatch):
    assert abs(off_ppm(cards, on(rig, CARDS, "reference-clock"))) < 0.1
    # Left to itself it runs by the clock of its own card.
    monkeypatch.setattr("modallab_drivers.ni_daqmx.shaker.ShakerOutput.follow", lambda shaker, clock: None)
    assert abs(off_ppm(cards, on(rig, CARDS, "reference-clock"))) > 1.0


@pytest.mark.thorough("starts one more server of devices")
def test_chassis_that_can_be_synchronised_agree_within_a_tenth_of_a_degree_at_10_khz(rig: Rig):
    wanted = on(rig, CHASSIS)
    with NiServer(wanted, "two-chassis", "--cables", device="cDAQ1,cDAQ2") as server:
        said, phase = checked(server, wanted)
    assert {finding.verdict for finding in said} == {"good"}
    assert phase.verdict == "good", phase.value


def test_devices_that_follow_no_common_clock_are_seen_by_their_phase(
    cards: NiServer, rig: Rig, monkeypatch: pytest.MonkeyPatch
):
    # What the driver would do if it left out the sync pulse: the converters begin anywhere in a sample.
    monkeypatch.setattr("modallab_drivers.ni_daqmx.input_task.InputTask.filter_delays_s", lambda task: [0.0] * 2)
    assert checked(cards, on(rig, CARDS, "reference-clock"))[1].verdict == "bad"


def test_devices_that_cannot_be_in_one_task_are_rejected_with_the_reason(usb: NiServer, rig: Rig):
    bench = open_bench(usb.url, on(rig, USB, "one-task"))
    with pytest.raises(ConfigurationError, match=r"Dev1, Dev2 cannot be synchronised.*by one task"):
        check_synchronisation(bench)
    bench.close()


@pytest.mark.parametrize("clock", ["PXIe_Clk100", "PXI_Clk10"])
def test_devices_on_usb_have_no_clock_of_a_backplane(usb: NiServer, rig: Rig, clock: str):
    wanted = on(rig, USB, "reference-clock").model_copy(
        update={"synchronisation": Synchronisation(method="reference-clock", reference_clock=clock)}
    )
    bench = open_bench(usb.url, wanted)
    with pytest.raises(ConfigurationError, match=f"by {clock}: .*-89120"):
        check_synchronisation(bench)
    bench.close()


def test_channels_of_several_tasks_stand_in_the_order_of_the_rig(rig: Rig):
    mixed = on(rig, ["PXI1Slot3/ai0", "PXI1Slot2/ai1", "PXI1Slot3/ai1", "PXI1Slot2/ai0"], "reference-clock")
    with NiServer(mixed, "4461", "--cables", device="PXI1Slot2,PXI1Slot3") as server:
        bench = open_bench(server.url, mixed)
        assert [bench.info.facts[f"input of {c.name}"] for c in mixed.channels] == [c.input for c in mixed.channels]
        said, phase = check_synchronisation(bench), check_common_signal(bench, mixed, ("force", "a03"), 0.5)
        bench.close()
    assert "PXI1Slot3" in said[0].value
    assert phase.verdict == "good", phase.value
