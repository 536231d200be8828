"""Live samples by WebSocket: what the bench delivers, whole in each frame."""

import json
import struct

import numpy as np
import pytest
from lab import RIG, TOKEN, Lab
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from modallab.core.documents.runs import RunNew, Stop
from modallab.core.plan import ImpactPlan
from modallab.service.campaigns.begin import begin


def test_frames_come_while_a_run_is_on(lab: Lab) -> None:
    lease = lab.lease()
    address = lab.url.replace("http", "ws") + "/api/v1/live"
    try:
        with connect(address, additional_headers={"Authorization": f"Bearer {TOKEN}"}) as socket:
            run = begin(lab.service, lab.campaign(), RunNew(plan=ImpactPlan(points=(10,), hits=50)), lease.id)
            frames = [_parse(socket.recv(30.0)) for _ in range(3)]
            lab.wait_for_state(run, "acquiring")
            lab.controllers.command(RIG, run, Stop(), lease.id)
            lab.wait_for_state(run, "done")
    finally:
        lab.service.leases.release(RIG, lease.id)
        lab.wait_until_idle()
    firsts = [about["first_sample"] for about, _ in frames]
    assert firsts == sorted(set(firsts))
    for about, samples in frames:
        assert (about["rig"], about["run"]) == (RIG, run)
        assert samples.shape[0] == len(about["channels"]) == len(about["scale"]) == 11
        assert samples.dtype == np.int16
        assert samples.std() > 0


def test_nobody_looks_without_a_token_or_from_another_site(lab: Lab) -> None:
    address = lab.url.replace("http", "ws") + "/api/v1/live"
    for headers in ({}, {"Authorization": f"Bearer {TOKEN}", "Origin": "https://evil.example"}):
        with pytest.raises((InvalidStatus, ConnectionClosed)), connect(address, additional_headers=headers) as socket:
            socket.recv(5.0)


def _parse(message: bytes | str) -> tuple[dict, np.ndarray]:
    assert isinstance(message, bytes)
    (length,) = struct.unpack("<I", message[:4])
    about = json.loads(message[4 : 4 + length])
    return about, np.frombuffer(message[4 + length :], about["dtype"]).reshape(about["shape"])
