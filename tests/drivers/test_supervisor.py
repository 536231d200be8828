"""However the acquisition process ends, the output comes to 0 V in a device that outlives its client."""

import os
import signal
import threading
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from ni_server import NiServer

from modallab.acquisition.process.rig_process import RigProcess
from modallab.acquisition.process.trip import Trip, TrippedError
from modallab.bench.loader import open_bench, open_output
from modallab.bench.protocol import AcquisitionRequest, Burst
from modallab.core.errors import DeviceBusyError, ModallabError, OutputLostError, SamplesLostError
from modallab.core.hardware import Excitation
from modallab.core.plan import SinePlan
from modallab.core.rig import Rig

OUTPUT = "cDAQ1Mod4/ao0"
PATIENCE_S = 30.0
WATCHDOG_S = 0.8

OTHERS_S = 10.0
"""What has ended the output by then was not the burst's own end: how soon it was depends on how busy the machine is."""

# One burst of 20 s, with hardly anything before it.
PLAN = SinePlan(frequencies_hz=(19.53125,), ramp_s=0.3, settle_s=19.4, block_s=0.128, wait_s=0.2, settle_timeout_s=0.2)


@pytest.fixture(scope="module")
def paced(rig: Rig):
    with NiServer(rig, "9215", "--pace", virtual=False) as server:
        server.say("preamplifiers sine")
        yield server


def wait_for_volts(server: NiServer, *, on: bool) -> float:
    began = time.monotonic()
    while (server.say("levels 0.02")[OUTPUT] > 0.1) is not on:
        assert time.monotonic() - began < PATIENCE_S
        time.sleep(0.02)
    return time.monotonic() - began


def at_rest(server: NiServer) -> bool:
    """Whether the output is at 0 V now: the device's own latency, and what is looked back at, are waited for."""
    time.sleep(0.04)
    return server.say("levels 0.02")[OUTPUT] == 0.0


def started(server: NiServer, rig: Rig, folder: Path) -> tuple[RigProcess, threading.Thread]:
    process = RigProcess(server.url, rig, folder)
    runner = threading.Thread(target=drain, args=(process,))
    runner.start()
    wait_for_volts(server, on=True)
    return process, runner


def waited_for_trip(process: RigProcess) -> Trip:
    began = time.monotonic()
    while (trip := process.trip) is None:
        assert time.monotonic() - began < PATIENCE_S, process.view
        time.sleep(0.05)
    return trip


def drain(process: RigProcess, ended_by: list[ModallabError] | None = None) -> None:
    try:
        for _ in process.run(PLAN):
            pass
    except ModallabError as error:
        if ended_by is not None:
            ended_by.append(error)


def test_a_killed_acquisition_process_leaves_0_v_and_its_inputs_free(paced: NiServer, rig: Rig, tmp_path: Path):
    process, runner = started(paced, rig, tmp_path)
    process.process.kill()
    assert wait_for_volts(paced, on=False) < OTHERS_S
    # The death is seen, no missing sign of life waited for. benchmarks/kill_shaker.py measures how soon.
    assert waited_for_trip(process).cause == "death"
    runner.join()
    process.close()
    bench = open_bench(paced.url, rig)
    bench.configure(AcquisitionRequest("sine", 1000.0))
    bench.start()
    assert bench.read(100, 5.0).first_sample == 0
    bench.close()


@pytest.mark.thorough("waits for the clock of a device, and kills what drives it")
def test_a_death_while_it_drove_trips_the_rig(paced: NiServer, rig: Rig, tmp_path: Path):
    process, runner = started(paced, rig, tmp_path)
    process.process.kill()
    wait_for_volts(paced, on=False)
    runner.join()
    process.close()
    with RigProcess(paced.url, rig, tmp_path) as later:
        with pytest.raises(TrippedError, match="died while it drove"):
            list(later.run(PLAN))
        assert at_rest(paced)
        assert later.latch.reset() is not None


@pytest.mark.thorough("waits for the clock of a device, and kills what drives it")
def test_an_acquisition_without_a_sign_of_life_for_a_second_is_brought_to_zero_and_trips_the_rig(
    paced: NiServer, rig: Rig, tmp_path: Path
):
    ended_by: list[ModallabError] = []
    process = RigProcess(paced.url, rig, tmp_path)
    runner = threading.Thread(target=drain, args=(process, ended_by))
    runner.start()
    wait_for_volts(paced, on=True)
    pid = process.process.pid
    assert pid is not None
    os.kill(pid, signal.SIGSTOP)
    try:
        assert wait_for_volts(paced, on=False) < OTHERS_S
        trip = waited_for_trip(process)
        assert trip.cause == "time-out"
    finally:
        os.kill(pid, signal.SIGCONT)
    # When it comes to itself again, it finds the rig tripped, and drives nothing.
    runner.join(PATIENCE_S)
    (error,) = ended_by
    assert isinstance(error, TrippedError)
    with pytest.raises(TrippedError, match="time-out"):
        list(process.run(PLAN))
    assert at_rest(paced)
    process.latch.reset()
    process.close()


def test_a_stop_in_good_order_trips_nothing(paced: NiServer, rig: Rig, tmp_path: Path):
    process, runner = started(paced, rig, tmp_path)
    process.stop()
    runner.join(PATIENCE_S)
    process.close()
    assert process.trip is None
    assert at_rest(paced)


def test_an_emergency_stop_needs_no_answer_from_the_acquisition_process(paced: NiServer, rig: Rig, tmp_path: Path):
    process, runner = started(paced, rig, tmp_path)
    process.emergency_stop()
    assert at_rest(paced)
    runner.join()
    process.close()


@pytest.mark.thorough("waits for the clock of a device, and kills what drives it")
def test_with_the_supervisor_killed_too_the_watchdog_is_left(paced: NiServer, rig: Rig, tmp_path: Path):
    guarded = rig.model_copy(
        update={"excitation": Excitation(watchdog_s=WATCHDOG_S, heartbeat_line="cDAQ1Mod5/port0/line0")}
    )
    process, runner = started(paced, guarded, tmp_path)
    before = paced.say("levels")["cDAQ1Mod5/port0/line0 changes"]
    time.sleep(0.3)
    assert paced.say("levels")["cDAQ1Mod5/port0/line0 changes"] > before + 2
    supervisor = process.supervisor
    assert supervisor is not None
    supervisor.process.kill()
    supervisor.process.join()
    process.process.kill()
    assert wait_for_volts(paced, on=False) < OTHERS_S
    runner.join()
    process.close()
    handle = open_output(paced.url, guarded)
    assert handle is not None
    handle.release()
    handle.close()


@pytest.mark.thorough("waits for the clock of a device, and kills what drives it")
def test_several_who_bring_the_output_to_zero_at_once_do_not_disturb_each_other(ni_server: NiServer, rig: Rig):
    bench = open_bench(ni_server.url, rig)
    bench.configure(AcquisitionRequest("sine", 1000.0))
    bench.start()
    handles = [h for h in (open_output(ni_server.url, rig), open_output(ni_server.url, rig)) if h is not None]
    assert len(handles) == 2
    failed: list[Exception] = []

    def zero_often(zero: Callable[[], None]) -> None:
        try:
            for _ in range(15):
                zero()
        except ModallabError as error:
            failed.append(error)

    threads = [threading.Thread(target=zero_often, args=(z.zero,)) for z in (*handles, bench)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not failed
    # Nobody reset the device: the inputs of the one that reads were not touched.
    bench.play(Burst(20.0, 0.5, 0.1, 1.0))
    assert bench.read(300, 5.0).first_sample == 0
    assert ni_server.say("levels 0.05")[OUTPUT] > 0.4
    for handle in handles:
        handle.close()
    bench.close()


@pytest.mark.thorough("waits for the clock of a device, and kills what drives it")
def test_a_watchdog_that_expired_before_the_burst_wants_a_new_start_and_watches_again(paced: NiServer, rig: Rig):
    guarded = rig.model_copy(update={"excitation": Excitation(watchdog_s=WATCHDOG_S)})
    bench = open_bench(paced.url, guarded)
    bench.configure(AcquisitionRequest("sine", 1000.0))
    bench.start()
    # Nobody reads for so long that it expires.
    time.sleep(1.5 * WATCHDOG_S)
    # From then on nothing goes on the chassis until it is reset, which the next start does.
    with pytest.raises(SamplesLostError, match="the watchdog has expired"):
        bench.play(Burst(20.0, 0.5, 0.1, 20.0))
    bench.start()
    bench.play(Burst(20.0, 0.5, 0.1, 20.0))
    began = time.monotonic()
    while time.monotonic() - began < 0.6 + 1.5 * WATCHDOG_S:
        bench.read(50, 5.0)
    assert paced.say("levels 0.05")[OUTPUT] > 0.4
    # And from here on nobody reads.
    assert wait_for_volts(paced, on=False) < OTHERS_S
    with pytest.raises(OutputLostError, match="the watchdog has expired"):
        bench.read(500, 5.0)
    assert at_rest(paced)
    bench.close()


def test_what_a_killed_client_left_is_rejected_by_name_and_can_be_given_back(ni_server: NiServer, rig: Rig):
    left = open_bench(ni_server.url, rig)
    left.configure(AcquisitionRequest("sine", 1000.0))
    left.start()
    left.play(Burst(20.0, 0.5, 0.1, 30.0))
    left.read(500, 5.0)
    # As if this process had been killed here, another one comes.
    with pytest.raises(DeviceBusyError, match="modallab-cDAQ1Mod4-ao0"):
        open_bench(ni_server.url, rig)
    handle = open_output(ni_server.url, rig)
    assert handle is not None
    handle.release()
    handle.close()
    bench = open_bench(ni_server.url, rig)
    bench.configure(AcquisitionRequest("sine", 1000.0))
    bench.start()
    bench.read(500, 5.0)
    assert ni_server.say("levels 0.05")[OUTPUT] == 0.0
    bench.close()


def test_a_finite_burst_ends_at_zero_by_itself(ni_server: NiServer, rig: Rig):
    bench = open_bench(ni_server.url, rig)
    bench.configure(AcquisitionRequest("sine", 1000.0))
    bench.start()
    bench.play(Burst(19.7, 0.5, 0.1, 0.83))
    bench.read(500, 5.0)
    assert ni_server.say("levels 0.05")[OUTPUT] > 0.4
    bench.read(700, 5.0)
    assert ni_server.say("levels 0.05")[OUTPUT] == 0.0
    bench.close()
