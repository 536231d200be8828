"""Revisions of the rigs: what each was believed to be, since when, and why."""

from sqlalchemy import Engine, Row, insert, select

from modallab.core.documents.rigs import RigRevision
from modallab.core.rig import Rig
from modallab.service.errors import NotFoundError
from modallab.service.records import audit
from modallab.storage import rig_hash
from modallab.storage.engine import read_transaction, write_transaction
from modallab.storage.recorder import utc_now
from modallab.storage.service_tables import RIG_REVISIONS

AT_START = "the rig file that the service was started with"


class RigRevisions:
    """The descriptions a rig has had, numbered from 1; none is ever changed."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine

    def begin_with(self, rig: str, file: Rig) -> Rig:
        """The description that counts when the service starts: a rig file that was changed begins a revision of its
        own; otherwise what was revised since stands.

        Raises:
            StorageError: it cannot be read, or not be kept.
        """
        rows = self._rows(rig)
        of_file = next((row for row in reversed(rows) if row.from_file), None)
        if of_file is not None and Rig.model_validate_json(of_file.description) == file:
            return Rig.model_validate_json(rows[-1].description)
        self._add(rig, file, AT_START, "", from_file=True)
        return file

    def add(self, rig: str, description: Rig, reason: str, operator: str) -> None:
        """Keep another one.

        Raises:
            StorageError: it could not be kept.
        """
        self._add(rig, description, reason, operator, from_file=False)

    def all_revisions(self, rig: str) -> tuple[RigRevision, ...]:
        """All of a rig, the oldest first."""
        return tuple(_revision_view(n, row) for n, row in enumerate(self._rows(rig), 1))

    def description(self, rig: str, number: int) -> Rig:
        """What the rig was believed to be.

        Raises:
            NotFoundError: it has no such revision.
        """
        rows = self._rows(rig)
        if not 1 <= number <= len(rows):
            raise NotFoundError(
                f"the rig has no revision {number}", where=rig, remedy=f"name one from 1 to {len(rows)}"
            )
        return Rig.model_validate_json(rows[number - 1].description)

    def _rows(self, rig: str) -> list[Row[tuple[object, ...]]]:
        query = select(RIG_REVISIONS).where(RIG_REVISIONS.c.rig == rig).order_by(RIG_REVISIONS.c.seq)
        with read_transaction(self._engine) as connection:
            return list(connection.execute(query))

    def _add(self, rig: str, description: Rig, reason: str, operator: str, *, from_file: bool) -> None:
        row = {"rig": rig, "description": description.model_dump_json(), "rig_hash": rig_hash(description)}
        row |= {"from_file": from_file, "reason": reason, "operator": operator, "utc": utc_now()}
        with write_transaction(self._engine) as connection:
            connection.execute(insert(RIG_REVISIONS).values(row))
            if not from_file:
                audit.add_audit_note(
                    connection, operator, "revise-rig", rig, {"reason": reason, "rig_hash": row["rig_hash"]}
                )


def _revision_view(number: int, row: Row[tuple[object, ...]]) -> RigRevision:
    return RigRevision(number=number, rig_hash=row.rig_hash, reason=row.reason, operator=row.operator, utc=row.utc)
