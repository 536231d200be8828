"""The log of events: append-only, in one order, so that whoever was away reads on from where he was."""

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from threading import Lock
from typing import Any

from sqlalchemy import Connection, Engine, RowMapping, func, insert, select, text

from modallab.core.documents.pages import EventView
from modallab.core.errors import StorageError
from modallab.storage.engine import read_transaction, write_transaction
from modallab.storage.recorder import utc_now
from modallab.storage.records import ENDED
from modallab.storage.service_tables import EVENTS

RENAMED = {"hit_wanted": "hit_requested", "hit_refused": "hit_rejected"}
"""Kinds of events as older programs wrote them -> as they are called now; what is in the log stays as it is."""

MAX_WAITING = 10_000
"""Events kept in memory while the disk takes none; the oldest go first."""


@dataclass(frozen=True, slots=True)
class EventTopic:
    """What an event is about; "" where it is about none."""

    rig: str = ""
    campaign: str = ""
    run: str = ""


class EventLog:
    """Appends and reads events. A full disk delays them and never stops who reports them."""

    def __init__(self, engine: Engine, written: Callable[[], None] = lambda: None) -> None:
        """`written` is called after events were added; it must not wait."""
        self._engine = engine
        self._written = written
        self._waiting: deque[dict[str, Any]] = deque(maxlen=MAX_WAITING)
        self._adding = Lock()
        self._writing = Lock()

    def append(self, kind: str, topic: EventTopic, content: Mapping[str, Any]) -> None:
        """Add an event; what the disk would not take is added with the next one, in order."""
        self.append_later(kind, topic, content)
        self.flush()

    def append_later(self, kind: str, topic: EventTopic, content: Mapping[str, Any]) -> None:
        """Add an event with the next `flush`: waits for no disk and no database."""
        row = {
            "utc": utc_now(),
            "rig": topic.rig,
            "campaign": topic.campaign,
            "run": topic.run,
            "kind": kind,
            "content": dict(content),
        }
        with self._adding:
            self._waiting.append(row)

    def flush(self) -> None:
        """Try again to write what waits."""
        with self._writing:
            self._write_waiting()

    @property
    def waiting(self) -> int:
        """Events the disk has not taken yet."""
        return len(self._waiting)

    def events_after(self, seq: int, limit: int, topic: EventTopic | None = None) -> list[EventView]:
        """Up to `limit` events after number `seq`, oldest first; with a topic only its own."""
        query = select(EVENTS).where(EVENTS.c.seq > seq).order_by(EVENTS.c.seq).limit(limit)
        for name in ("rig", "campaign", "run"):
            requested = getattr(topic, name) if topic is not None else ""
            if requested:
                query = query.where(EVENTS.c[name] == requested)
        with read_transaction(self._engine) as connection:
            return [_event_view(row) for row in connection.execute(query).mappings()]

    def newest_number(self) -> int:
        """Number of the newest event, 0 if there is none."""
        with read_transaction(self._engine) as connection:
            return connection.scalar(select(func.max(EVENTS.c.seq))) or 0

    def has_ended(self, run: str, seq: int) -> bool:
        """Whether the events up to number `seq` say that a run has ended."""
        mine = EVENTS.c.run == run, EVENTS.c.kind == "state", EVENTS.c.seq <= seq
        query = select(EVENTS.c.content).where(*mine).order_by(EVENTS.c.seq.desc()).limit(1)
        with read_transaction(self._engine) as connection:
            content = connection.scalar(query)
        return run != "" and content is not None and content["state"] in ENDED

    def _write_waiting(self) -> None:
        with self._adding:
            rows = list(self._waiting)
        if not rows:
            return
        try:
            with write_transaction(self._engine) as connection:
                lock_event_numbers(connection)
                connection.execute(insert(EVENTS), rows)
        except StorageError:
            return
        written = {id(row) for row in rows}
        with self._adding:
            while self._waiting and id(self._waiting[0]) in written:
                self._waiting.popleft()
        self._written()


def _event_view(row: RowMapping) -> EventView:
    event = EventView.model_validate(dict(row))
    if event.kind not in RENAMED:
        return event
    kind = RENAMED[event.kind]
    return event.model_copy(update={"kind": kind, "content": event.content | {"kind": kind}})


def lock_event_numbers(connection: Connection) -> None:
    """Numbers must become visible in their order, or a reader would pass by one; SQLite has one writer anyway."""
    if connection.dialect.name == "postgresql":
        connection.execute(text("LOCK TABLE events IN EXCLUSIVE MODE"))
