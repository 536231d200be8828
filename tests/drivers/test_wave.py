"""Waves of any shape on an analog output of a device, and what cannot play them."""

from pathlib import Path

import numpy as np
import pytest
from ni_server import NiServer

from modallab.acquisition.procedures.broadband_wave import make_wave, wave_layout
from modallab.acquisition.process.run import record_run
from modallab.bench.capabilities import PlaysWaves
from modallab.bench.loader import open_bench
from modallab.bench.protocol import AcquisitionRequest, Waveform
from modallab.core.errors import ConfigurationError, UnsupportedError
from modallab.core.hardware import Excitation
from modallab.core.plan import BroadbandPlan
from modallab.core.rig import Rig
from modallab.storage import Store

RATE_HZ = 2000.0
PLAN = BroadbandPlan(signal="pseudo-random", levels_v={"low": 0.5}, blocks=3, settle_s=1.0, wait_s=0.5)


def test_a_wave_is_played_as_it_was_computed_and_ends_at_zero(rig: Rig):
    with NiServer(rig, "9215", "--cables") as server:
        bench = open_bench(server.url, rig)
        assert isinstance(bench, PlaysWaves)
        rate_hz = bench.configure(AcquisitionRequest("pseudo-random", RATE_HZ)).rate_hz
        bench.start()
        bench.read(400, 2.0)
        layout = wave_layout(PLAN, 3, PLAN.block_s)
        wave = make_wave(PLAN, "low", 0, layout)
        start = bench.play_wave(wave)
        volts = bench.read(round((layout.end_s + 1.0) * rate_hz), 20.0).samples[0]
        first, count = start - 400 + round(layout.lead_s * rate_hz), round(PLAN.block_s * rate_hz)
        expected = wave.at(layout.lead_s + np.arange(count) / rate_hz)
        lags = range(-60, 61)
        alike = [np.corrcoef(volts[first + lag : first + lag + count], expected)[0, 1] for lag in lags]
        assert max(alike) > 0.99
        assert volts[first : first + count].std() == pytest.approx(0.5, rel=0.05)
        assert np.abs(volts[-500:]).max() < 0.01
        with pytest.raises(ConfigurationError, match="range"):
            bench.play_wave(Waveform(np.array([0.0, 20.0, 0.0]), 5000.0))
        bench.play_wave(wave)
        with pytest.raises(ConfigurationError, match="still on"):
            bench.play_wave(wave)
        bench.zero()
        assert np.abs(bench.read(800, 2.0).samples[0, -400:]).max() < 0.01
        bench.close()


def test_a_broadband_run_records_its_blocks_on_a_device(rig: Rig, tmp_path: Path):
    with NiServer(rig, "9215") as server, Store(tmp_path / "data") as store:
        server.say("preamplifiers sine")
        bench = open_bench(server.url, rig)
        run = record_run(bench, rig, PLAN, store, lambda _: None)
        bench.close()
        blocks = store.blocks(run)
        assert len(blocks) == 3
        assert {b.test for b in blocks} == {"pseudo-random"}
        force = [b.samples[rig.force_channel.index] for b in blocks]
        # The same wave in every block, within what the two clocks differ by.
        assert np.corrcoef(force[0], force[1])[0, 1] > 0.98


def test_a_sine_generator_says_that_it_plays_no_waves(rig: Rig, tmp_path: Path):
    with NiServer(rig, "9215", "--generator", "rigol-dg1000") as server, Store(tmp_path / "data") as store:
        excitation = Excitation(kind="generator", output=server.generator, dialect="rigol-dg1000")
        driven = rig.model_copy(update={"excitation": excitation})
        bench = open_bench(server.url, driven)
        with pytest.raises(UnsupportedError, match="a sine generator plays no pseudo-random drive"):
            record_run(bench, driven, PLAN, store, lambda _: None)
        bench.close()
