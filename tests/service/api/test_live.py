"""Live by WebSocket: samples without holes, their envelope, and FRFs that grow with every block."""

import json
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import jsonschema_rs
import numpy as np
import pytest
from lab import RIG, TOKEN, Lab
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

from modallab.core.documents.runs import RunRequest, StopRun
from modallab.core.plan import ImpactPlan
from modallab.core.rig import Rig
from modallab.service.api.asyncapi import event_kinds
from modallab.service.campaigns.run_start import begin_run

IN_REAL_TIME = "sim://cantilever?seed=1&zeta=0.05&bad_hits=0&pace=1&reaction_s=0.1,0.2"
Message = tuple[dict[str, Any], np.ndarray]


@pytest.fixture(scope="module")
def real_lab(tmp_path_factory: pytest.TempPathFactory, link_rig: Rig) -> Iterator[Lab]:
    """As fast as the clock: a bench that gives ten seconds of samples at once leaves nothing to be followed."""
    with Lab(tmp_path_factory.mktemp("real") / "data", link_rig, IN_REAL_TIME) as made:
        made.wait_until_idle()
        yield made


def open_socket(lab: Lab, path: str) -> ClientConnection:
    address = lab.url.replace("http", "ws") + "/api/v1" + path
    return connect(address, additional_headers={"Authorization": f"Bearer {TOKEN}"}, max_size=None)


@contextmanager
def running(lab: Lab, plan: ImpactPlan) -> Iterator[tuple[str, str]]:
    """A run that is on, and the lease; stopped at the end."""
    lease = lab.lease()
    try:
        run = begin_run(lab.service, lab.campaign(), RunRequest(plan=plan), lease.id)
        yield run, lease.id
        if lab.store.catalogue.run(run).state not in ("done", "failed", "aborted"):
            lab.controllers.command(RIG, run, StopRun(), lease.id)
        lab.wait_for_ended(run)
    finally:
        lab.service.leases.release(RIG, lease.id)
        lab.wait_until_idle()


def parse(message: bytes | str) -> Message:
    assert isinstance(message, bytes)
    (length,) = struct.unpack("<I", message[:4])
    about = json.loads(message[4 : 4 + length])
    return about, np.frombuffer(message[4 + length :], about["dtype"]).reshape(about["shape"])


def until_ended(socket: ClientConnection) -> list[Message]:
    found = [parse(socket.recv(60.0))]
    while not found[-1][0]["ended"]:
        found.append(parse(socket.recv(60.0)))
    return found


Followed = tuple[str, list[Message], list[Message]]


@pytest.fixture(scope="module")
def followed(real_lab: Lab) -> Followed:
    """One run, and what came of it by both streams; of two channels the envelope."""
    path = f"rig={RIG}&channel=force&channel=a10&columns_per_s=40"
    with (
        open_socket(real_lab, f"/live?rig={RIG}") as raw,
        open_socket(real_lab, f"/live/envelope?{path}") as envelope,
        running(real_lab, ImpactPlan(points=(10,), hits=1)) as (run, _),
    ):
        real_lab.wait_for_ended(run)
        return run, until_ended(raw), until_ended(envelope)


def test_every_sample_comes_and_blocks_hold_the_same(real_lab: Lab, followed: Followed) -> None:
    run, found, _ = followed
    position = 0
    for about, samples in found:
        assert (about["rig"], about["run"]) == (RIG, run)
        assert about["position"] == position
        assert about["lost"] == 0
        assert samples.shape[0] == len(about["channels"]) == 11
        position += samples.shape[1]
    whole = np.concatenate([samples for _, samples in found], axis=1)
    assert found[0][0]["first_sample"] == 0
    blocks = real_lab.store.blocks(run, rejected=True)
    assert blocks
    for block in blocks:
        here = slice(block.first_sample, block.first_sample + block.n_samples)
        np.testing.assert_array_equal(whole[:, here], block.samples)


def test_what_stands_before_the_arrays_is_as_documented(real_lab: Lab, followed: Followed) -> None:
    schemas = real_lab.app.state.asyncapi()["components"]["schemas"]
    for name, messages in (("SamplesHeader", followed[1]), ("EnvelopeHeader", followed[2])):
        judge = jsonschema_rs.validator_for(schemas[name] | {"components": {"schemas": schemas}})
        assert [error.message for about, _ in messages for error in judge.iter_errors(about)] == []


def test_every_event_is_as_documented(real_lab: Lab, followed: Followed) -> None:
    """Those of a run and of its rig; the stream sends what the list gives."""
    schemas = real_lab.app.state.asyncapi()["components"]["schemas"]
    names = {kind.model_fields["kind"].default: f"EventView_{kind.__name__}" for kind in event_kinds()}
    events = real_lab.service.log.events_after(0, 10_000)
    assert {"state", "rig", "block", "hit_requested", "progress"} <= {event.kind for event in events}
    for event in events:
        judge = jsonschema_rs.validator_for(schemas[names[event.kind]] | {"components": {"schemas": schemas}})
        judge.validate(event.model_dump(mode="json"))


def test_who_comes_back_reads_on_and_hears_what_is_lost(real_lab: Lab) -> None:
    with running(real_lab, ImpactPlan(points=(10,), hits=400)) as (run, _):
        real_lab.wait_for_state(run, "acquiring")
        with open_socket(real_lab, f"/live?run={run}&after=0&channel=a03") as socket:
            first = [parse(socket.recv(30.0)) for _ in range(3)]
        reached = first[-1][0]["position"] + first[-1][1].shape[1]
        with open_socket(real_lab, f"/live?run={run}&after={reached}&channel=a03") as socket:
            about, samples = parse(socket.recv(30.0))
    assert about["position"] - about["lost"] == reached
    assert about["channels"] == ["a03"]
    assert samples.shape[0] == 1


def test_the_channels_are_seen_before_a_run_and_after_it(real_lab: Lab) -> None:
    with open_socket(real_lab, f"/live?rig={RIG}&channel=a03&channel=force&idle=true") as socket:
        before = [parse(socket.recv(30.0)) for _ in range(5)]
        with running(real_lab, ImpactPlan(points=(10,), hits=1)) as (run, _):
            while (found := parse(socket.recv(60.0)))[0]["run"] != run:
                before.append(found)
            while not (found := parse(socket.recv(60.0)))[0]["ended"]:
                assert found[0]["run"] == run
        after = parse(socket.recv(30.0))
    position = before[0][0]["position"]
    for about, samples in before[:-1]:
        assert (about["rig"], about["run"], about["ended"], about["lost"]) == (RIG, "", False, 0)
        assert about["channels"] == ["force", "a03"]
        assert about["position"] == position
        position += samples.shape[1]
    assert before[-1][0]["ended"], "the rig belongs to the run now"
    assert position >= 5 * 100
    assert (after[0]["rig"], after[0]["run"]) == (RIG, "")
    assert len(real_lab.store.catalogue.runs()) == len(
        {e.run for e in real_lab.service.log.events_after(0, 9999)} - {""}
    )


def test_the_envelope_is_that_of_the_samples(followed: Followed) -> None:
    _, samples, columns = followed
    rows = [samples[0][0]["channels"].index(name) for name in ("force", "a10")]
    whole = np.concatenate([values for _, values in samples], axis=1)[rows]
    scale = np.array(samples[0][0]["scale"])[rows, None]
    seen = [(about, values) for about, values in columns if values.ndim == 3]
    assert seen
    for about, values in seen:
        at, width = about["position"], about["width"]
        stretch = whole[:, at : at + width * values.shape[2]].reshape(2, values.shape[2], width) * scale[:, None]
        np.testing.assert_allclose(values[:, 0], stretch.min(axis=2), rtol=1e-6)
        np.testing.assert_allclose(values[:, 1], stretch.max(axis=2), rtol=1e-6)
    assert sum(values.shape[2] for _, values in seen) == whole.shape[1] // seen[0][0]["width"]


def test_an_frf_comes_with_every_block_and_is_that_of_the_blocks_that_count(lab: Lab) -> None:
    with running(lab, ImpactPlan(points=(10, 6), hits=3)) as (run, _), lab.client() as client:
        with open_socket(lab, f"/runs/{run}/frf/live?output=a05&output=a10&high_hz=120") as socket:
            lab.wait_for_ended(run)
            found = [parse(socket.recv(60.0))]
            while sum({about["input_point"]: about["averages"] for about, _ in found}.values()) < 6:
                found.append(parse(socket.recv(60.0)))
        last = {about["input_point"]: (about, values) for about, values in found}
        view = client.get(f"/api/v1/runs/{run}/frf").raise_for_status().json()
    assert view["input_points"] == [10, 6]
    frequency = np.array(view["frequency_hz"])
    band, rows = frequency <= 120, [view["outputs"].index(name) for name in ("a05", "a10")]
    whole = np.array(view["values"]["re"]) + 1j * np.array(view["values"]["im"])
    for n, point in enumerate((10, 6)):
        about, values = last[point]
        axis = about["frequency_hz"]
        np.testing.assert_allclose(axis["first"] + axis["step"] * np.arange(axis["count"]), frequency[band])
        np.testing.assert_allclose(values[0], whole[rows, n][:, band], rtol=1e-5)
        np.testing.assert_allclose(values[1], np.array(view["coherence"])[rows, n][:, band], rtol=1e-5)


def test_a_dropped_block_leaves_the_frf(lab: Lab) -> None:
    with running(lab, ImpactPlan(points=(10,), hits=3)) as (run, lease), lab.client() as client:
        lab.wait_for_ended(run)
        path = f"/api/v1/runs/{run}"
        before = client.get(f"{path}/frf").json()
        n = next(block["n"] for block in client.get(f"{path}/blocks").json()["items"] if block["accepted"])
        headers = {"Modallab-Lease": lease}
        verdict = {"accepted": False, "reason": "someone walked by"}
        client.put(f"{path}/blocks/{n}/verdict", json=verdict, headers=headers).raise_for_status()
        after = client.get(f"{path}/frf").json()
    assert (before["averages"], after["averages"]) == ([3], [2])
    assert before["values"] != after["values"]


def test_a_channel_that_is_not_there_is_said(lab: Lab) -> None:
    with running(lab, ImpactPlan(points=(10,), hits=1)) as (run, _):
        lab.wait_for_ended(run)
        path = f"/runs/{run}/frf/live?output=a77"
        with open_socket(lab, path) as socket, pytest.raises(ConnectionClosed) as closed:
            socket.recv(30.0)
    assert closed.value.rcvd is not None
    assert "a77" in closed.value.rcvd.reason


def test_nobody_looks_without_a_token_or_from_another_site(lab: Lab) -> None:
    address = lab.url.replace("http", "ws") + "/api/v1/live"
    for headers in ({}, {"Authorization": f"Bearer {TOKEN}", "Origin": "https://evil.example"}):
        with pytest.raises((InvalidStatus, ConnectionClosed)), connect(address, additional_headers=headers) as socket:
            socket.recv(5.0)
