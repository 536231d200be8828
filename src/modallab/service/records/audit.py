"""Who did what, when: kept for good."""

from collections.abc import Mapping
from typing import Any

from sqlalchemy import Connection, Engine, insert, select

from modallab.core.documents.pages import AuditEntry
from modallab.storage.engine import read_transaction, write_transaction
from modallab.storage.recorder import utc_now
from modallab.storage.service_tables import AUDIT


def add_audit_note(connection: Connection, operator: str, action: str, target: str, detail: Mapping[str, Any]) -> None:
    """Enter an action in the transaction that does it, so that neither is kept without the other."""
    row = {"utc": utc_now(), "operator": operator, "action": action, "target": target, "detail": dict(detail)}
    connection.execute(insert(AUDIT).values(row))


def enter_action(engine: Engine, operator: str, action: str, target: str, detail: Mapping[str, Any]) -> None:
    """Enter an action that changes no table of ours.

    Raises:
        StorageError: it could not be kept.
    """
    with write_transaction(engine) as connection:
        add_audit_note(connection, operator, action, target, detail)


def audit_entries(engine: Engine, before: int | None, limit: int) -> list[AuditEntry]:
    """Up to `limit` entries before number `before`, newest first."""
    query = select(AUDIT).order_by(AUDIT.c.seq.desc()).limit(limit)
    if before is not None:
        query = query.where(AUDIT.c.seq < before)
    with read_transaction(engine) as connection:
        return [AuditEntry.model_validate(dict(row)) for row in connection.execute(query).mappings()]
