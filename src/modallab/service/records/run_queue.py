"""The queues of runs, in the service's database: they outlive every process."""

import secrets
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

from pydantic import TypeAdapter
from sqlalchemy import Connection, Engine, delete, func, insert, select, update

from modallab.core.documents.queue import QueueItem, QueueItemRequest, QueueState
from modallab.core.plan import Plan
from modallab.service.errors import ConflictError, NotFoundError
from modallab.service.records import audit
from modallab.storage.engine import read_transaction, write_transaction
from modallab.storage.recorder import utc_now
from modallab.storage.service_tables import PAUSED_QUEUES, QUEUE

MOST = 200
"""Items that may wait at one rig."""
OPEN: tuple[QueueState, ...] = ("waiting", "running")
_PLAN: TypeAdapter[Plan] = TypeAdapter(Plan)


class RunQueue:
    """Items by rig, in their order, and which queues are paused."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine

    def add(self, rig: str, new: QueueItemRequest, estimated_s: float, operator: str) -> QueueItem:
        """Queue a run behind all others of its rig.

        Raises:
            ConflictError: too many wait.
            StorageError: it could not be kept.
        """
        row: dict[str, Any] = {
            "id": f"q{datetime.now(UTC):%Y%m%dT%H%M%S}-{secrets.token_hex(4)}",
            "rig": rig,
            "campaign": new.campaign,
            "plan": new.plan.model_dump_json(),
            "state": "waiting",
            "note": new.note,
            "operator": operator,
            "created_utc": utc_now(),
            "estimated_s": estimated_s,
        }
        with write_transaction(self._engine) as connection:
            if len(_waiting_items(connection, rig)) >= MOST:
                raise ConflictError(f"{MOST} runs wait at {rig}", where=rig, remedy="skip some, or wait")
            last = connection.scalar(select(func.max(QUEUE.c.place)).where(QUEUE.c.rig == rig)) or 0
            connection.execute(insert(QUEUE).values(row | {"place": last + 1}))
            audit.add_audit_note(connection, operator, "queue-run", row["id"], {"campaign": new.campaign, "rig": rig})
            return _item_row(connection, row["id"])

    def item(self, item: str) -> QueueItem:
        """One item.

        Raises:
            NotFoundError: there is none of this id.
        """
        with read_transaction(self._engine) as connection:
            return _item_row(connection, item)

    def open(self, rig: str | None = None) -> list[QueueItem]:
        """What goes on, then what waits, in order; of one rig or of all."""
        query = select(QUEUE).where(QUEUE.c.state.in_(OPEN)).order_by(QUEUE.c.state, QUEUE.c.place)
        with read_transaction(self._engine) as connection:
            rows = connection.execute(query if rig is None else query.where(QUEUE.c.rig == rig)).mappings()
            return [_item_of_row(row) for row in rows]

    def ended(self, rig: str, limit: int) -> list[QueueItem]:
        """Up to `limit` items that have ended, the newest first."""
        query = select(QUEUE).where(QUEUE.c.rig == rig, QUEUE.c.state.not_in(OPEN)).order_by(QUEUE.c.place.desc())
        with read_transaction(self._engine) as connection:
            return [_item_of_row(row) for row in connection.execute(query.limit(limit)).mappings()]

    def reorder(self, rig: str, items: Sequence[str], operator: str) -> None:
        """Set the order of the waiting runs.

        Raises:
            ConflictError: these are not the items that wait.
        """
        with write_transaction(self._engine) as connection:
            waiting = _waiting_items(connection, rig)
            if sorted(items) != sorted(waiting):
                raise ConflictError(
                    f"{len(items)} items, which are not the {len(waiting)} waiting ones",
                    where="items",
                    remedy="read the queue again, and name every waiting item once",
                )
            for item, place in zip(items, sorted(waiting.values()), strict=True):
                connection.execute(update(QUEUE).where(QUEUE.c.id == item).values(place=place))
            audit.add_audit_note(connection, operator, "reorder-queue", rig, {"items": list(items)})

    def take_out(self, rig: str, item: str, reason: str, operator: str) -> QueueItem:
        """Remove a waiting item.

        Raises:
            NotFoundError: the queue has none of this id.
            ConflictError: it has begun, or ended.
        """
        with write_transaction(self._engine) as connection:
            found = _item_row(connection, item)
            if found.rig != rig:
                raise _unknown_item(item)
            if found.state != "waiting":
                raise ConflictError(
                    f"the item is {found.state}", where=item, remedy="an active run can only be stopped"
                )
            _set_state(connection, item, state="skipped", reason=reason)
            audit.add_audit_note(connection, operator, "skip-queued", item, {"reason": reason})
            return _item_row(connection, item)

    def set_state(self, item: str, state: QueueState, *, run: str = "", reason: str = "") -> QueueItem:
        """Enter how an item stands.

        Raises:
            StorageError: it could not be kept.
        """
        with write_transaction(self._engine) as connection:
            _set_state(connection, item, state=state, run=run, reason=reason)
            return _item_row(connection, item)

    def claim(self, item: str) -> bool:
        """Enter that an item is begun; whether it still waited."""
        mine = QUEUE.c.id == item, QUEUE.c.state == "waiting"
        with write_transaction(self._engine) as connection:
            return connection.execute(update(QUEUE).where(*mine).values(state="running")).rowcount == 1

    def paused(self) -> dict[str, str]:
        """Rigs whose queue is paused, each with the reason."""
        with read_transaction(self._engine) as connection:
            return {row.rig: row.reason for row in connection.execute(select(PAUSED_QUEUES))}

    def pause(self, rig: str, reason: str, operator: str) -> None:
        """Have nothing begin until somebody resumes it; the first reason holds."""
        row = {"rig": rig, "reason": reason, "operator": operator, "utc": utc_now()}
        with write_transaction(self._engine) as connection:
            if connection.scalar(select(PAUSED_QUEUES.c.rig).where(PAUSED_QUEUES.c.rig == rig)) is None:
                connection.execute(insert(PAUSED_QUEUES).values(row))
                audit.add_audit_note(connection, operator, "pause-queue", rig, {"reason": reason})

    def resume(self, rig: str, operator: str) -> None:
        """Let it go on."""
        with write_transaction(self._engine) as connection:
            if connection.execute(delete(PAUSED_QUEUES).where(PAUSED_QUEUES.c.rig == rig)).rowcount:
                audit.add_audit_note(connection, operator, "resume-queue", rig, {})


def _set_state(connection: Connection, item: str, **values: str) -> None:
    connection.execute(update(QUEUE).where(QUEUE.c.id == item).values(values))


def _waiting_items(connection: Connection, rig: str) -> dict[str, int]:
    query = select(QUEUE.c.id, QUEUE.c.place).where(QUEUE.c.rig == rig, QUEUE.c.state == "waiting")
    return {row.id: row.place for row in connection.execute(query)}


def _item_row(connection: Connection, item: str) -> QueueItem:
    row = connection.execute(select(QUEUE).where(QUEUE.c.id == item)).mappings().one_or_none()
    if row is None:
        raise _unknown_item(item)
    return _item_of_row(row)


def _item_of_row(row: Mapping[Any, Any]) -> QueueItem:
    plan = _PLAN.validate_json(row["plan"])
    known = {name: row[name] for name in QueueItem.model_fields if name not in ("plan", "drives")}
    return QueueItem(**known, plan=plan, drives=plan.kind != "impact")


def _unknown_item(item: str) -> NotFoundError:
    return NotFoundError(f"there is no item {item!r} in the queue", remedy="read the rig's queue")
