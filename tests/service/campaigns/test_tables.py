"""Leases, events, keys and verdicts as rows: what must hold however they are used."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from sqlalchemy import text

from modallab.core.documents.runs import CampaignChange, CampaignRequest
from modallab.core.errors import StorageError
from modallab.service.api.router import IdempotencyKeys, StoredAnswer
from modallab.service.errors import ChangedError, ConflictError, IdempotencyError, LeaseHeldError, LeaseNeededError
from modallab.service.records.audit import enter_action
from modallab.service.records.event_log import EventLog, EventTopic
from modallab.service.records.leases import RigLeases
from modallab.service.records.repository import CampaignRepository
from modallab.storage import Store
from modallab.storage.engine import write_transaction


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    with Store(tmp_path / "data") as opened:
        yield opened


def test_a_lease_is_held_by_one_and_void_after_a_restart(store: Store) -> None:
    leases = RigLeases(store.catalogue.engine, "first start")
    mine = leases.take("link", "Ada", 60.0)
    with pytest.raises(LeaseHeldError, match="Ada"):
        leases.take("link", "Bob", 60.0)
    assert leases.require("link", mine.id).operator == "Ada"
    later = RigLeases(store.catalogue.engine, "second start")
    with pytest.raises(LeaseNeededError):
        later.require("link", mine.id)
    assert later.take("link", "Bob", 60.0).fence == mine.fence + 1


def test_a_lease_ends_by_itself_and_its_holder_learns_it(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    now = [100.0]
    monkeypatch.setattr("time.monotonic", lambda: now[0])
    leases = RigLeases(store.catalogue.engine, "start")
    mine = leases.take("link", "Ada", 10.0)
    now[0] += 9.0
    leases.renew("link", mine.id)
    now[0] += 9.0
    assert leases.holder("link") is not None
    now[0] += 1.5
    with pytest.raises(LeaseNeededError, match="has ended"):
        leases.require("link", mine.id)
    assert leases.holder("link") is None


def test_no_clock_on_the_wall_ends_or_prolongs_a_lease(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    leases = RigLeases(store.catalogue.engine, "start")
    mine = leases.take("link", "Ada", 60.0)
    before = leases.holder("link")
    for step_s in (-3600.0, 3600.0):
        import time

        wall = time.time()
        monkeypatch.setattr("time.time", lambda wall=wall, step_s=step_s: wall + step_s)
        assert leases.require("link", mine.id).fence == mine.fence
        after = leases.holder("link")
        assert before is not None
        assert after is not None
        assert abs(after.remaining_s - before.remaining_s) < 30


def test_events_are_read_on_from_any_number_and_never_changed(store: Store) -> None:
    log = EventLog(store.catalogue.engine)
    for n in range(25):
        log.append("state", EventTopic(run=f"r{n % 2}"), {"n": n})
    seen = log.events_after(0, 10)
    assert [event.content["n"] for event in seen + log.events_after(seen[-1].seq, 100)] == list(range(25))
    assert [event.content["n"] for event in log.events_after(0, 100, EventTopic(run="r1"))] == list(range(1, 25, 2))
    assert log.newest_number() == 25
    enter_action(store.catalogue.engine, "Ada", "look", "link", {})
    for change in ("UPDATE events SET kind = 'other'", "DELETE FROM events", "DELETE FROM audit"):
        with pytest.raises(StorageError, match="never change"):
            _execute(store, change)


def _execute(store: Store, change: str) -> None:
    with write_transaction(store.catalogue.engine) as connection:
        connection.execute(text(change))


def test_events_of_older_programs_are_read_under_todays_kinds(store: Store) -> None:
    log = EventLog(store.catalogue.engine)
    renamed = ("hit_wanted", "hit_refused")
    for kind in (*renamed, "progress"):
        log.append(kind, EventTopic(run="r1"), {"kind": kind, "run": "r1", "point": 3})
    events = log.events_after(0, 10)
    assert [event.kind for event in events] == ["hit_requested", "hit_rejected", "progress"]
    assert [event.content["kind"] for event in events] == [event.kind for event in events]
    assert all(event.content["point"] == 3 for event in events)


def test_events_wait_in_order_while_the_disk_takes_none(store: Store) -> None:
    log = EventLog(store.catalogue.engine)
    log.append("state", EventTopic(), {"n": 0})
    with store.catalogue.engine.begin() as connection:
        connection.execute(text("CREATE TRIGGER full BEFORE INSERT ON events BEGIN SELECT RAISE(ABORT, 'full'); END"))
    for n in (1, 2):
        log.append("state", EventTopic(), {"n": n})
    assert log.waiting == 2
    with store.catalogue.engine.begin() as connection:
        connection.execute(text("DROP TRIGGER full"))
    log.append("state", EventTopic(), {"n": 3})
    assert log.waiting == 0
    assert [event.content["n"] for event in log.events_after(0, 10)] == [0, 1, 2, 3]


def test_a_key_is_for_one_request_and_what_a_dead_process_left_is_done_again(store: Store) -> None:
    keys = IdempotencyKeys(store.catalogue.engine, "one process")
    assert keys.claim("a-key", b"request") is None
    with pytest.raises(ConflictError):
        keys.claim("a-key", b"request")
    assert IdempotencyKeys(store.catalogue.engine, "the next").claim("a-key", b"request") is None
    answer = StoredAnswer(201, {"location": "/there"}, "{}")
    keys.keep("a-key", answer)
    assert keys.claim("a-key", b"request") == answer
    with pytest.raises(IdempotencyError):
        keys.claim("a-key", b"another")


def test_of_two_changes_of_one_revision_one_is_rejected(store: Store) -> None:
    repository = CampaignRepository(store.catalogue.engine)
    made = repository.create(CampaignRequest(name="old", rig="link"), "Ada")
    repository.change(made.id, CampaignChange(name="new"), made.revision, "Ada")
    with pytest.raises(ChangedError):
        repository.change(made.id, CampaignChange(name="newer"), made.revision, "Bob")
    assert repository.campaign(made.id).name == "new"
