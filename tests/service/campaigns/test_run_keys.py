"""A test that is asked for twice under one key is made once: a shaker must not move again by itself."""

import os
import signal
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager

import pytest
from lab import RIG, Lab
from sqlalchemy import update

from modallab.core.documents.runs import RunRequest
from modallab.core.plan import ImpactPlan
from modallab.service.campaigns.run_start import begin_run
from modallab.service.errors import IdempotencyError
from modallab.storage.engine import write_transaction
from modallab.storage.service_tables import RUN_KEYS

SHORT = RunRequest(plan=ImpactPlan(points=(10,), hits=2))
KEY = "a-key-of-mine"


@contextmanager
def _frozen(lab: Lab) -> Iterator[None]:
    pid = lab.controller.pid or 0
    os.kill(pid, signal.SIGSTOP)
    try:
        yield
    finally:
        os.kill(pid, signal.SIGCONT)


def test_one_key_is_one_run_though_the_first_answer_was_lost(lab: Lab) -> None:
    lease, campaign = lab.lease(), lab.campaign()
    try:
        lab.wait_until_idle()
        with ThreadPoolExecutor(2) as pool:
            with _frozen(lab):
                lost = pool.submit(begin_run, lab.service, campaign, SHORT, lease.id, KEY)
                lab.wait_for(lambda e: e.kind == "rig" and e.content["state"] == "running")
                again = pool.submit(begin_run, lab.service, campaign, SHORT, lease.id, KEY)
            run = lost.result(240)
            assert again.result(240) == run
        lab.wait_for_state(run, "done")
        lab.wait_until_idle()
        # Whoever answers REST requests by now, and whatever it may have forgotten.
        assert begin_run(lab.service, campaign, SHORT, lease.id, KEY) == run
        assert lab.service.repository.campaign(campaign).runs == (run,)
        other = RunRequest(plan=ImpactPlan(points=(10,), hits=3))
        with pytest.raises(IdempotencyError, match="another request"):
            begin_run(lab.service, campaign, other, lease.id, KEY)
    finally:
        lab.service.leases.release(RIG, lease.id)
        lab.wait_until_idle()


def test_a_key_is_forgotten_after_a_day(lab: Lab) -> None:
    lease, campaign = lab.lease(), lab.campaign()
    key = "a-key-of-yesterday"
    try:
        lab.wait_until_idle()
        first = begin_run(lab.service, campaign, SHORT, lease.id, key)
        lab.wait_for_state(first, "done")
        lab.wait_until_idle()
        with write_transaction(lab.service.engine) as connection:
            connection.execute(update(RUN_KEYS).values(created_utc="2026-01-01T00:00:00.000+00:00"))
        second = begin_run(lab.service, campaign, SHORT, lease.id, key)
        assert second != first
        lab.wait_for_state(second, "done")
        assert begin_run(lab.service, campaign, SHORT, lease.id, key) == second
    finally:
        lab.service.leases.release(RIG, lease.id)
        lab.wait_until_idle()
