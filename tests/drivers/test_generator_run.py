"""A sine test on a generator: no block is kept of a burst that somebody interfered with."""

from pathlib import Path

import pytest
from ni_server import NiServer

from modallab.acquisition.process.prepare_run import Order
from modallab.acquisition.process.run import record_run
from modallab.bench.loader import open_bench
from modallab.core.errors import OutputLostError
from modallab.core.hardware import Excitation
from modallab.core.plan import SinePlan
from modallab.core.rig import Rig
from modallab.storage import Store

PLAN = SinePlan(
    frequencies_hz=(40.0,), levels_v={"low": 0.5}, ramp_s=0.5, settle_s=2.0, wait_s=1.0, settle_timeout_s=2.0
)


def driven_by(rig: Rig, server: NiServer) -> Rig:
    excitation = Excitation(kind="generator", output=server.generator, dialect="rigol-dg1000")
    return rig.model_copy(update={"excitation": excitation})


def test_of_a_burst_that_was_changed_by_hand_no_block_is_kept(rig: Rig, tmp_path: Path):
    with NiServer(rig, "9215", "--generator", "rigol-dg1000") as server, Store(tmp_path / "data") as store:
        server.say("preamplifiers sine")
        driven = driven_by(rig, server)
        bench = open_bench(server.url, driven)
        done: list[str] = []

        def hand() -> Order | None:
            if not done and server.say("levels")["generator"] > 0.45:
                done.append(str(server.say("generator-fault front-panel offset 0.2")))
            return None

        with pytest.raises(OutputLostError, match="offset: 0 was set, the generator now reports 2"):
            record_run(bench, driven, PLAN, store, lambda _: None, hand)
        bench.close()
        assert store.catalogue.blocks(store.catalogue.runs()[-1].id) == ()


def test_a_complete_run_keeps_each_block_with_what_the_generator_said_it_played(rig: Rig, tmp_path: Path):
    plan = PLAN.model_copy(update={"frequencies_hz": (30.0, 40.0)})
    with NiServer(rig, "9215", "--generator", "rigol-dg1000") as server, Store(tmp_path / "data") as store:
        server.say("preamplifiers sine")
        driven = driven_by(rig, server)
        bench = open_bench(server.url, driven)
        run = record_run(bench, driven, plan, store, lambda _: None)
        rows = store.catalogue.blocks(run)
        bench.close()
        assert [(row.note.frequency_hz, row.note.accepted) for row in rows] == [(30.0, True), (40.0, True)]
        for row in rows:
            assert row.note.facts["generator_frequency_hz"] == row.note.frequency_hz
            assert row.note.facts["generator_amplitude_v"] == 0.5
            assert row.note.facts["force_n"] == pytest.approx(0.25, rel=0.02)
