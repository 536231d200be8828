"""Every status NI devices give is provoked in the simulated server, and handled as the table says."""

import time
from collections.abc import Iterator

import numpy as np
import pytest
from ni_server import NiServer

from modallab.bench.loader import open_bench
from modallab.bench.protocol import AcquisitionRequest, Bench, Burst
from modallab.core.errors import (
    BenchError,
    BenchTimeoutError,
    ConfigurationError,
    DeviceBusyError,
    DeviceGoneError,
    OutputLostError,
    SamplesLostError,
)
from modallab.core.hardware import Excitation
from modallab.core.rig import Rig

SINE = AcquisitionRequest("sine", 1000.0)
BURST = Burst(20.0, 0.5, 0.1, 1.0)


@pytest.fixture
def bench(ni_server: NiServer, rig: Rig) -> Iterator[Bench]:
    opened = open_bench(ni_server.url, rig)
    opened.configure(SINE)
    opened.start()
    yield opened
    opened.close()


def test_not_yet_200284_keeps_what_came_and_the_next_read_goes_on(bench: Bench, ni_server: NiServer):
    whole = bench.read(1000, 1.0).samples
    assert whole.shape[1] == 1000
    ni_server.say("fault partial-read")
    with pytest.raises(BenchTimeoutError, match=r"200 of 400.*-200284"):
        bench.read(400, 1.0)
    ni_server.say("fault time-out")
    with pytest.raises(BenchTimeoutError, match="200 of 400"):
        bench.read(400, 1.0)
    # A smaller read is served from what was kept, and nothing is missing or doubled.
    assert bench.read(150, 1.0).first_sample == 1000
    rest = bench.read(250, 1.0)
    assert rest.first_sample == 1150
    assert rest.samples.shape[1] == 250


@pytest.mark.parametrize("code", [-200279, -200222, -200361, -200278])
def test_lost_samples_end_the_stretch_and_are_never_spliced(bench: Bench, ni_server: NiServer, code: int):
    bench.read(500, 1.0)
    ni_server.say(f"fault status ReadAnalogF64 {code}")
    with pytest.raises(SamplesLostError, match=str(code)) as caught:
        bench.read(500, 1.0)
    assert caught.value.remedy
    with pytest.raises(ConfigurationError, match="lost"):
        bench.read(500, 1.0)
    bench.stop()
    bench.start()
    assert bench.read(500, 1.0).first_sample == 0


def test_a_buffer_that_is_not_read_in_time_overflows(rig: Rig, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("modallab_drivers.ni_daqmx.input_task.BUFFER_S", 0.1)
    with NiServer(rig, "9215", "--cables", "--pace", virtual=False) as server:
        bench = open_bench(server.url, rig)
        bench.configure(AcquisitionRequest("impact", 50_000.0))
        bench.start()
        bench.read(1000, 5.0)
        while server.say("time")["bench_s"] < 3.0:
            time.sleep(0.1)
        with pytest.raises(SamplesLostError, match="-200279"):
            bench.read(1000, 5.0)
        bench.close()


@pytest.mark.parametrize("code", [-201003, -88705, -88709, -88710, -50405])
def test_a_device_that_is_gone_is_said_and_comes_back(bench: Bench, ni_server: NiServer, code: int):
    ni_server.say(f"fault unplugged {code}")
    with pytest.raises(DeviceGoneError, match=str(code)):
        bench.read(100, 1.0)
    # In every state, and without a device, these are legal.
    bench.zero()
    bench.stop()
    with pytest.raises(ConfigurationError):
        bench.read(100, 1.0)
    with pytest.raises(DeviceGoneError):
        bench.configure(SINE)
    ni_server.say("fault plugged")
    bench.configure(SINE)
    bench.start()
    assert bench.read(100, 1.0).first_sample == 0


def test_a_server_that_ends_is_a_device_that_is_gone(rig: Rig):
    with NiServer(rig, "9215") as server:
        bench = open_bench(server.url, rig)
        bench.configure(SINE)
        bench.start()
        bench.read(100, 1.0)
    with pytest.raises(DeviceGoneError):
        bench.read(100, 1.0)
    bench.close()
    with pytest.raises(DeviceGoneError):
        open_bench(server.url, rig)


def test_reserved_50103_is_tried_again_for_a_while_and_the_owner_named(
    ni_server: NiServer, rig: Rig, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("modallab_drivers.ni_daqmx.route.BUSY_WAIT_S", 0.01)
    bench = open_bench(ni_server.url, rig)
    bench.configure(SINE)
    ni_server.say("fault reserved cDAQ1Mod1/ai their_scope")
    with pytest.raises(DeviceBusyError, match=r"-50103.*their_scope"):
        bench.start()
    ni_server.say("fault released cDAQ1Mod1/ai")
    bench.start()
    # One rejection is sat out.
    bench.stop()
    ni_server.say("fault status StartTask -50103")
    bench.start()
    assert bench.read(10, 1.0).first_sample == 0
    bench.close()


@pytest.mark.parametrize("code", [-200077, -200431, -200170, -200220, -200265, -89120, -200452])
def test_a_configuration_that_cannot_be_is_said_once_and_never_tried_again(ni_server: NiServer, rig: Rig, code: int):
    bench = open_bench(ni_server.url, rig)
    ni_server.say(f"fault status CfgSampClkTiming {code} 1")
    with pytest.raises(ConfigurationError, match=str(code)) as caught:
        bench.configure(SINE)
    assert "rate_hz" in str(caught.value)
    # The fault was armed once: had it been tried again, it would have gone well.
    bench.configure(SINE)
    bench.close()


def test_a_dead_handle_200088_is_built_anew(bench: Bench, ni_server: NiServer):
    bench.read(100, 1.0)
    ni_server.say("fault invalid-task")
    with pytest.raises(SamplesLostError, match="-200088"):
        bench.read(100, 1.0)
    bench.stop()
    bench.start()
    assert bench.read(100, 1.0).first_sample == 0


@pytest.mark.parametrize("code", [-200290, -200621, -200018])
def test_an_output_that_runs_dry_is_brought_to_zero(bench: Bench, ni_server: NiServer, code: int):
    bench.play(BURST)
    bench.read(500, 1.0)
    ni_server.say(f"fault status IsTaskDone {code}")
    with pytest.raises(OutputLostError, match=str(code)):
        bench.read(100, 1.0)
    bench.read(200, 1.0)
    assert ni_server.say("levels 0.05")["cDAQ1Mod4/ao0"] == 0.0


def test_a_warning_with_a_read_loses_nothing(bench: Bench, ni_server: NiServer):
    ni_server.say("fault warning")
    assert bench.read(100, 1.0).samples.shape[1] == 100
    assert bench.read(100, 1.0).first_sample == 100


def test_an_unknown_status_keeps_its_number(bench: Bench, ni_server: NiServer):
    ni_server.say("fault status ReadAnalogF64 -209999")
    with pytest.raises(BenchError, match="-209999"):
        bench.read(100, 1.0)


def changed(rig: Rig, index: int, **fields: object) -> Rig:
    channels = list(rig.channels)
    channels[index] = channels[index].model_copy(update=fields)
    return rig.model_copy(update={"channels": tuple(channels)})


def test_what_does_not_fit_is_rejected_before_anything_moves_naming_the_field(ni_server: NiServer, rig: Rig):
    assert rig.limits is not None
    loud = rig.limits.model_copy(update={"drive_v": 12.0})
    bad = {
        r"channels\[2\]\.input: found 'cDAQ1Mod9/ai0'": changed(rig, 2, input="cDAQ1Mod9/ai0"),
        r"channels\[0\]\.range_v: found 20 V": changed(rig, 0, range_v=20.0),
        r"limits\.drive_v: found 12 V": rig.model_copy(update={"limits": loud}),
        r"excitation\.output: found 'cDAQ1Mod4/ao9'": rig.model_copy(
            update={"excitation": Excitation(output="cDAQ1Mod4/ao9")}
        ),
        r"excitation\.dialect: missing": rig.model_copy(
            update={"excitation": Excitation(kind="generator", output="COM3")}
        ),
        r"excitation\.heartbeat_line": rig.model_copy(update={"excitation": Excitation(heartbeat_line="cDAQ1Mod5/x")}),
    }
    for said, wrong in bad.items():
        with pytest.raises(ConfigurationError, match=said):
            open_bench(ni_server.url, wrong)
    with pytest.raises(
        ConfigurationError, match=r"no device 'cDAQ7'.*rig file field bench|rig file field bench.*cDAQ7"
    ):
        open_bench(ni_server.url.replace("cDAQ1", "cDAQ7"), rig)
    bench = open_bench(ni_server.url, changed(rig, 1, coupling="IEPE"))
    with pytest.raises(ConfigurationError, match=r"channels\[1\]\.input.*-200431"):
        bench.configure(SINE)
    bench.close()


def test_the_burst_must_keep_the_rigs_limits(bench: Bench):
    for burst, field in (
        (Burst(20.0, 6.0, 0.1, 1.0), r"limits\.drive_v"),
        (Burst(400.0, 4.0, 0.1, 1.0), r"limits\.slew_v_per_s"),
        (Burst(20.0, 0.5, 0.1, 61.0), r"limits\.max_burst_s"),
        (Burst(600.0, 0.5, 0.1, 1.0), "frequency_hz"),
        (Burst(20.0, np.nan, 0.1, 1.0), "amplitude_v"),
    ):
        with pytest.raises(ConfigurationError, match=field):
            bench.play(burst)
