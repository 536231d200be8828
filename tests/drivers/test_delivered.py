"""A block from a device with a rate of its own: kept as it came, read back at the rate that was asked for."""

from pathlib import Path

import numpy as np
import pytest
from ni_server import NiServer

from modallab.acquisition.process.run import record_run
from modallab.bench.loader import open_bench
from modallab.bench.protocol import AcquisitionRequest
from modallab.core.errors import ConfigurationError, PlanError
from modallab.core.events import OperatorNotice
from modallab.core.plan import SinePlan
from modallab.core.rig import Rig
from modallab.signals.tone_fit import fit_at
from modallab.storage import Store

PLAN = SinePlan(frequencies_hz=(31.25,), ramp_s=0.2, settle_s=2.0, block_s=0.512, wait_s=0.5)


@pytest.fixture(scope="module")
def small(rig: Rig) -> Rig:
    """The rig behind modules of 5 V."""
    assert rig.converter is not None
    channels = tuple(channel.model_copy(update={"range_v": 5.0}) for channel in rig.channels)
    converter = rig.converter.model_copy(update={"range_v": 5.0, "bits": 24})
    return rig.model_copy(update={"channels": channels, "converter": converter})


@pytest.fixture(scope="module")
def server(small: Rig):
    with NiServer(small, "9234") as started:
        started.say("preamplifiers sine")
        yield started


def test_the_device_says_the_rate_it_gives_and_rejects_what_is_far_from_it(server: NiServer, small: Rig):
    bench = open_bench(server.url, small)
    delivery = bench.configure(AcquisitionRequest("sine", 1000.0))
    assert delivery.requested_rate_hz == 1000.0
    assert delivery.actual_rate_hz == pytest.approx(51_200 / 31)
    assert bench.configure(AcquisitionRequest("impact", 2000.0)).actual_rate_hz == pytest.approx(2048.0)
    with pytest.raises(ConfigurationError, match=r"rate_hz: 100 Hz was requested, the device gives 1651\.61 Hz"):
        bench.configure(AcquisitionRequest("impact", 100.0))
    bench.close()


def test_a_block_is_kept_native_and_read_back_delivered(server: NiServer, small: Rig, tmp_path: Path):
    plan = PLAN.model_copy(update={"rate_hz": 2048.0, "delivered_hz": 1000.0})
    bench = open_bench(server.url, small)
    with Store(tmp_path) as store:
        run = record_run(bench, small, plan, store, lambda event: None)
        block = store.blocks(run)[0]
        row = store.catalogue.blocks(run)[0]
    bench.close()
    assert (block.requested_rate_hz, block.actual_rate_hz, block.rate_hz) == (2048.0, 2048.0, 1000.0)
    assert block.samples.shape == (11, 512)
    # The disk holds the device's own samples, with those at both ends that the recut leans on.
    assert row.count > 512 * 2.048 + 80
    force = block.samples[:1] * block.scale[0]
    fit = fit_at(force, 1000.0, 31.25)
    assert np.abs(fit.amplitude[0]) > 50 * fit.residual_rms[0]


def test_native_blocks_have_the_nearest_whole_number_of_samples(server: NiServer, small: Rig, tmp_path: Path):
    bench = open_bench(server.url, small)
    said: list[object] = []
    with Store(tmp_path) as store:
        run = record_run(bench, small, PLAN.model_copy(update={"rate_hz": 2000.0}), store, said.append)
        block = store.blocks(run)[0]
    bench.close()
    notices = [event.what for event in said if isinstance(event, OperatorNotice)]
    assert "the device samples at 2048 Hz; 2000 Hz was requested" in notices
    assert block.n_samples == round(0.512 * 2048)
    assert block.duration_s == block.n_samples / 2048.0


def test_a_delivered_rate_above_the_devices_is_rejected(server: NiServer, small: Rig, tmp_path: Path):
    plan = PLAN.model_copy(update={"rate_hz": 2048.0, "delivered_hz": 4000.0})
    bench = open_bench(server.url, small)
    with Store(tmp_path) as store, pytest.raises(PlanError, match="delivered_hz"):
        record_run(bench, small, plan, store, lambda event: None)
    bench.close()
