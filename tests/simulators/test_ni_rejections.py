"""What the simulated NI server cannot do it says with a status of the driver: a client knows no other failure."""

from collections.abc import Iterator
from importlib.resources import files
from typing import Any

import grpc
import nidaqmx
import pytest
from ni_server import NiServer
from nidaqmx.constants import READ_ALL_AVAILABLE, AcquisitionType
from nidaqmx.error_codes import DAQmxErrors

from modallab.formats.rig.rig_file import parse_rig

RATE_HZ, COUNT = 2000.0, 500


@pytest.fixture(scope="module")
def options() -> Iterator[Any]:
    rig = parse_rig((files("modallab.cli") / "link_rig.yaml").read_text(encoding="utf-8"), "the demo's rig")
    with NiServer(rig, "6211") as server, grpc.insecure_channel(server.target) as channel:
        yield nidaqmx.GrpcSessionOptions(channel, "")


@pytest.fixture
def task(options: Any) -> Iterator[Any]:
    with nidaqmx.Task(grpc_options=options) as made:
        made.ai_channels.add_ai_voltage_chan("Dev1/ai0")
        made.timing.cfg_samp_clk_timing(RATE_HZ, sample_mode=AcquisitionType.FINITE, samps_per_chan=COUNT)
        yield made


def test_a_measurement_that_the_device_lacks(task: Any) -> None:
    with pytest.raises(nidaqmx.DaqError) as found:
        task.ai_channels.add_ai_thrmcpl_chan("Dev1/ai1")
    assert found.value.error_type is DAQmxErrors.PHYS_CHAN_MEAS_TYPE


def test_a_rate_that_the_bench_cannot_be_sampled_at(task: Any) -> None:
    task.timing.samp_clk_rate = 10.0
    with pytest.raises(nidaqmx.DaqError, match=r"SampClk.Rate\nRequested Value: 10") as found:
        task.start()
    assert found.value.error_type is DAQmxErrors.INVALID_ATTRIBUTE_VALUE
    task.timing.samp_clk_rate = RATE_HZ
    assert len(task.read(COUNT)) == COUNT


@pytest.mark.parametrize("count", [COUNT, READ_ALL_AVAILABLE])
def test_a_reference_trigger_that_never_comes(task: Any, count: int) -> None:
    task.triggers.reference_trigger.cfg_dig_edge_ref_trig("PFI0", 100)
    task.start()
    with pytest.raises(nidaqmx.errors.DaqReadError) as found:
        task.read(count, timeout=0.1)
    assert found.value.error_type is DAQmxErrors.SAMPLES_NOT_YET_AVAILABLE


@pytest.mark.parametrize("attribute", ["ref_clk_src", "sync_pulse_src", "samp_clk_timebase_src", "samp_clk_src"])
def test_a_terminal_of_a_device_that_is_not_there(task: Any, attribute: str) -> None:
    setattr(task.timing, attribute, "/Dev9/10MHzRefClock")
    with pytest.raises(nidaqmx.DaqError, match="/Dev9/10MHzRefClock") as found:
        task.start()
    assert found.value.error_type is DAQmxErrors.INVALID_ROUTING_SOURCE_TERMINAL_NAME_ROUTING


def test_a_function_that_is_not_simulated(task: Any) -> None:
    with pytest.raises(nidaqmx.DaqError, match="Function: SaveTask"):
        task.save("kept")
