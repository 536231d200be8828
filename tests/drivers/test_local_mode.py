"""Bursts that stream from this machine: what a death leaves, who brings it to 0 V, what the rig file must say."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from ni_server import NiServer

from modallab.acquisition.procedures.plan_checks import require_possible
from modallab.bench.loader import open_bench, open_output
from modallab.bench.protocol import AcquisitionRequest, Burst
from modallab.core.errors import ConfigurationError, DeviceBusyError
from modallab.core.hardware import Excitation
from modallab.core.plan import SinePlan
from modallab.core.rig import Rig

OUTPUT = "Dev1/ao0"
BURST = Burst(19.7, 1.0, 0.1, 20.0)
WAIVED = Excitation(watchdog_waived="the amplifier's switch is in the operator's hand")
SCRIPT = Path(__file__).parents[2] / "benchmarks" / "kill_shaker.py"

CLIENT = """
import sys
from modallab.bench.loader import open_bench
from modallab.bench.protocol import AcquisitionRequest, Burst
from modallab.core.rig import Rig

rig = Rig.model_validate_json(open(sys.argv[2]).read())
bench = open_bench(sys.argv[1], rig)
bench.configure(AcquisitionRequest("sine", 1000.0))
bench.start()
bench.play(Burst(19.7, 1.0, 0.1, 20.0))
while True:
    bench.read(50, 5.0)
"""


@pytest.fixture(scope="module")
def server(rig: Rig) -> Iterator[NiServer]:
    with NiServer(rig, "6211", "--pace", "--local", virtual=False) as server:
        server.say("preamplifiers sine")
        yield server


@pytest.fixture
def client(server: NiServer, rig: Rig, tmp_path: Path) -> Iterator["subprocess.Popen[bytes]"]:
    (tmp_path / "client.py").write_text(CLIENT)
    (tmp_path / "rig.json").write_text(rig.model_copy(update={"excitation": WAIVED}).model_dump_json())
    # What the client of the test before has left would pass for the start of this one.
    while server.say("levels 0.1")[OUTPUT] != 0.0:
        time.sleep(0.03)
    process = subprocess.Popen([sys.executable, str(tmp_path / "client.py"), server.url, str(tmp_path / "rig.json")])
    began = time.monotonic()
    while server.say("levels 0.1")[OUTPUT] < 0.5:
        assert time.monotonic() - began < 60
        time.sleep(0.03)
    yield process
    process.kill()
    process.wait()


def held(server: NiServer, within_s: float = 10.0) -> bool:
    began = time.monotonic()
    while time.monotonic() - began < within_s:
        volts = np.array(server.say("trace 0.2 5000")["volts"])
        if volts[0] != 0.0 and np.ptp(volts) == 0.0:
            return True
        time.sleep(0.05)
    return False


def bring_to_zero(server: NiServer, rig: Rig) -> None:
    handle = open_output(server.url, rig)
    assert handle is not None
    handle.zero()
    handle.close()
    # The device's own latency, and what `levels` looks back.
    time.sleep(0.02)


def test_a_killed_client_leaves_the_last_value_and_another_process_ends_it(
    server: NiServer, rig: Rig, client: "subprocess.Popen[bytes]"
) -> None:
    client.kill()
    assert held(server)
    bring_to_zero(server, rig)
    assert server.say("levels 0.002")[OUTPUT] == 0.0


def test_a_frozen_client_holds_its_output_and_only_a_reset_gets_through(
    server: NiServer, rig: Rig, client: "subprocess.Popen[bytes]"
) -> None:
    os.kill(client.pid, signal.SIGSTOP)
    assert held(server)
    with pytest.raises(DeviceBusyError, match="-50103"):
        open_bench(server.url, rig.model_copy(update={"excitation": WAIVED}))
    bring_to_zero(server, rig)
    assert server.say("levels 0.002")[OUTPUT] == 0.0


def test_nothing_is_driven_without_a_watchdog_or_a_reason(server: NiServer, rig: Rig) -> None:
    bench = open_bench(server.url, rig)
    plan = SinePlan(frequencies_hz=(20.0,), ramp_s=0.2, settle_s=1.0)
    with pytest.raises(ConfigurationError, match=r"(?s)holds its last value.*watchdog_s.*watchdog_waived"):
        require_possible(plan, rig, bench.info)
    require_possible(plan, rig.model_copy(update={"excitation": WAIVED}), bench.info)
    # To read is another matter, and to drive past the plan's check is not possible either.
    bench.configure(AcquisitionRequest("sine", 1000.0))
    bench.start()
    bench.read(100, 5.0)
    with pytest.raises(ConfigurationError, match="watchdog_waived"):
        bench.play(BURST)
    assert server.say("levels 0.05")[OUTPUT] == 0.0
    bench.close()


def test_a_server_keeps_the_burst_and_asks_for_no_reason(ni_server: NiServer, rig: Rig) -> None:
    bench = open_bench(ni_server.url, rig)
    assert not bench.info.streams_bursts
    bench.close()


def test_a_reason_is_rejected_where_the_device_has_a_watchdog(rig: Rig) -> None:
    with (
        NiServer(rig, "9215", "--pace", "--local", virtual=False) as server,
        pytest.raises(ConfigurationError, match="this device has one"),
    ):
        open_bench(server.url, rig.model_copy(update={"excitation": WAIVED}))


def test_a_watchdog_is_rejected_where_the_device_has_none(server: NiServer, rig: Rig) -> None:
    with pytest.raises(ConfigurationError, match=r"(?s)-200662.*watchdog_waived"):
        open_bench(server.url, rig.model_copy(update={"excitation": Excitation(watchdog_s=0.4)}))


@pytest.mark.parametrize(
    "options",
    [
        pytest.param(("--group",), marks=pytest.mark.thorough("waits for the clock of a device once more")),
        ("--group", "--local", "--freeze"),
    ],
    ids=" ".join,
)
def test_the_death_of_a_whole_process_group_ends_at_0_v(options: tuple[str, ...]) -> None:
    # How soon is a benchmark's matter, on a machine with nothing else to do. Here the watchdog is so far off that it is
    # not what ends the burst, and the supervisor's own record shows that it saw the death, and waited for no time-out.
    command = [sys.executable, str(SCRIPT), "--kills", "1", "--watchdog-s", "20", "--by-whom", *options]
    done = subprocess.run(command, check=False, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "1 of 1 at 0 V by the supervisor, before any other guard" in done.stdout
