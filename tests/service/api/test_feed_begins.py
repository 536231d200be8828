"""What is reported while a feed begins reaches those who follow it."""

import asyncio
from pathlib import Path

import pytest

from modallab.service.api import events
from modallab.service.api.events import EventFeed
from modallab.service.records.event_log import EventLog, EventTopic
from modallab.storage.store import Store


def test_an_event_before_the_first_look_is_not_lost(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # Long enough for all that comes before the first look, as on a machine that has much to do.
    monkeypatch.setattr(events, "LOOK_S", 1.0)
    with Store(tmp_path / "data") as store:
        first, second = asyncio.run(_followed(EventLog(store.catalogue.engine)))
    assert first.startswith(b"id: 1\n")
    assert second.startswith(b"id: 2\n")


async def _followed(log: EventLog) -> list[bytes]:
    log.append("state", EventTopic(), {"n": 1})
    feed = EventFeed(log)
    feed.open()
    listening = feed.listen(0, EventTopic())
    await anext(listening)
    first = await anext(listening)
    second = asyncio.ensure_future(anext(listening))
    await asyncio.sleep(0.2)
    log.append("state", EventTopic(), {"n": 2})
    try:
        return [first, await asyncio.wait_for(second, 10.0)]
    finally:
        feed.close()
