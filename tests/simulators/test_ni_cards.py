"""Cards of the simulated NI server agree as far as they are wired to, and see IEPE sensors as real ones do."""

from collections.abc import Iterator
from importlib.resources import files
from typing import Any

import grpc
import nidaqmx
import numpy as np
import pytest
from ni_server import NiServer
from nidaqmx.constants import AcquisitionType
from numpy.typing import NDArray

from modallab.core.rig import Rig
from modallab.formats.rig.rig_file import parse_rig

RATE_HZ, UPDATE_HZ, TONE_HZ = 102_400.0, 200_000.0, 10_000.0
COUNT = 40_000
SHARED_DEG = 0.1


def demo_rig() -> Rig:
    return parse_rig((files("modallab.cli") / "link_rig.yaml").read_text(encoding="utf-8"), "the demo's rig")


@pytest.fixture
def options() -> Iterator[Any]:
    with NiServer(demo_rig(), "4461", "--cables") as server, grpc.insecure_channel(server.target) as channel:
        yield nidaqmx.GrpcSessionOptions(channel, "")


def play_tone(task: Any) -> None:
    samples = np.sin(2 * np.pi * TONE_HZ / UPDATE_HZ * np.arange(2000))
    task.ao_channels.add_ao_voltage_chan("PXI1Slot2/ao0", min_val=-1.0, max_val=1.0)
    task.timing.cfg_samp_clk_timing(UPDATE_HZ, sample_mode=AcquisitionType.CONTINUOUS)
    task.write(samples, auto_start=True)


def phase_deg(samples: NDArray[np.float64]) -> float:
    wave = np.hanning(len(samples)) * np.exp(-2j * np.pi * TONE_HZ / RATE_HZ * np.arange(len(samples)))
    return float(np.degrees(np.angle((samples * wave).sum())))


def apart_deg(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    return (phase_deg(one) - phase_deg(other) + 180) % 360 - 180


def two_tasks(options: Any, wired: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """What two cards read of one tone, wired as `wired` says."""
    with (
        nidaqmx.Task(grpc_options=options) as output,
        nidaqmx.Task(grpc_options=options) as first,
        nidaqmx.Task(grpc_options=options) as second,
    ):
        play_tone(output)
        for card, task in (("PXI1Slot2", first), ("PXI1Slot3", second)):
            task.ai_channels.add_ai_voltage_chan(f"{card}/ai0")
            task.timing.cfg_samp_clk_timing(RATE_HZ, sample_mode=AcquisitionType.CONTINUOUS)
            if "clock" in wired:
                task.timing.ref_clk_src = "PXI_Clk10"
        if "pulse" in wired:
            second.timing.sync_pulse_src = "/PXI1Slot2/SyncPulse"
        if "trigger" in wired:
            second.triggers.start_trigger.cfg_dig_edge_start_trig("/PXI1Slot2/ai/StartTrigger")
        second.start()
        first.start()
        return np.array(first.read(COUNT, timeout=60)), np.array(second.read(COUNT, timeout=60))


def test_cards_with_shared_clock_pulse_and_trigger_agree(options: Any) -> None:
    first, second = two_tasks(options, "clock pulse trigger")
    for half in (slice(1000, COUNT // 2), slice(COUNT // 2, COUNT)):
        assert abs(apart_deg(first[half], second[half])) < SHARED_DEG


def test_cards_without_a_shared_clock_drift_apart(options: Any) -> None:
    first, second = two_tasks(options, "trigger")
    early, late = slice(1000, 11_000), slice(30_000, COUNT)
    drift = apart_deg(first[late], second[late]) - apart_deg(first[early], second[early])
    assert abs(drift) > SHARED_DEG


def test_cards_without_a_sync_pulse_begin_anywhere_in_a_sample(options: Any) -> None:
    first, second = two_tasks(options, "clock trigger")
    assert abs(apart_deg(first[1000:], second[1000:])) > SHARED_DEG


def test_cards_in_one_task_agree(options: Any) -> None:
    with nidaqmx.Task(grpc_options=options) as output, nidaqmx.Task(grpc_options=options) as task:
        play_tone(output)
        task.ai_channels.add_ai_voltage_chan("PXI1Slot2/ai0, PXI1Slot6/ai1")
        task.timing.cfg_samp_clk_timing(RATE_HZ, sample_mode=AcquisitionType.CONTINUOUS)
        first, second = np.array(task.read(COUNT, timeout=60))
    assert abs(apart_deg(first[1000:], second[1000:])) < SHARED_DEG


def test_devices_that_share_nothing_cannot_be_in_one_task() -> None:
    with NiServer(demo_rig(), "two-4431", "--cables") as server, grpc.insecure_channel(server.target) as channel:
        options = nidaqmx.GrpcSessionOptions(channel, "")
        with nidaqmx.Task(grpc_options=options) as task, pytest.raises(nidaqmx.DaqError) as caught:
            task.ai_channels.add_ai_voltage_chan("Dev1/ai0, Dev2/ai0")
    assert caught.value.error_code == -200558


def test_two_cards_see_the_same_beam() -> None:
    with NiServer(demo_rig(), "4461") as server, grpc.insecure_channel(server.target) as channel:
        options = nidaqmx.GrpcSessionOptions(channel, "")
        with nidaqmx.Task(grpc_options=options) as first, nidaqmx.Task(grpc_options=options) as second:
            for card, task in (("PXI1Slot2", first), ("PXI1Slot3", second)):
                task.ai_channels.add_ai_voltage_chan(f"{card}/ai0")
                task.timing.cfg_samp_clk_timing(8192.0, sample_mode=AcquisitionType.CONTINUOUS)
                task.start()
            server.say("strike 10")
            force, motion = (np.array(task.read(40_960, timeout=60)) for task in (first, second))
    peak_force, peak_motion = int(np.abs(force).argmax()), int(np.abs(motion).argmax())
    assert abs(peak_force - peak_motion) < 8192


def test_a_cold_iepe_input_settles_and_an_unfed_sensor_gives_nothing() -> None:
    rig = demo_rig()
    channels = tuple(c.model_copy(update={"coupling": "IEPE"}) for c in rig.channels)
    with (
        NiServer(rig.model_copy(update={"channels": channels}), "9234", "--cables") as server,
        grpc.insecure_channel(server.target) as channel,
    ):
        options = nidaqmx.GrpcSessionOptions(channel, "")
        with nidaqmx.Task(grpc_options=options) as task:
            task.ai_channels.add_ai_accel_chan("cDAQ1Mod1/ai0", sensitivity=100.0, current_excit_val=0.002)
            task.ai_channels.add_ai_voltage_chan("cDAQ1Mod1/ai1", min_val=-5.0, max_val=5.0)
            task.timing.cfg_samp_clk_timing(2048.0, sample_mode=AcquisitionType.CONTINUOUS)
            task.start()
            fed, unfed = np.array(task.read(4 * 2048, timeout=60))
    volts = np.abs(fed) * 0.1
    assert volts[:100].max() == pytest.approx(4.9, rel=0.05)
    assert volts[int(3.0 * 2048)] == pytest.approx(6.6e-3, rel=0.1)
    assert np.abs(unfed).max() == 0.0
