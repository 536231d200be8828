"""Campaigns and runs that are archived, or deleted with a grace time: until it ends nothing recorded is touched."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Literal, TypedDict

from sqlalchemy import Connection, Engine, Select, delete, insert, select, update

from modallab.service.errors import ConflictError, NotFoundError
from modallab.service.records import audit
from modallab.storage.engine import read_transaction, write_transaction
from modallab.storage.recorder import utc_now
from modallab.storage.records import ENDED
from modallab.storage.service_tables import CAMPAIGN_RUNS, CAMPAIGNS, QUEUE, SET_ASIDE
from modallab.storage.tables import RUNS

Kind = Literal["campaign", "run"]
_WORD = {"archive": "archived", "delete": "deleted"}
_LOST = ("purging", "purged")


@dataclass(frozen=True, slots=True)
class ArchiveEntry:
    """How something was set aside.

    Attributes:
        state: `archived` or `deleted`; once the grace time has ended `purging`, then `purged`.
        operator: name of the operator.
        utc: when.
        purge_utc: when the grace time ends; "" for what is archived.
    """

    state: str
    operator: str
    utc: str
    purge_utc: str


class ArchiveState(TypedDict, total=False):
    """What a view says of it."""

    archived_utc: str
    deleted_utc: str
    purge_utc: str


def archive_state(aside: ArchiveEntry | None) -> ArchiveState:
    """For a view."""
    if aside is None:
        return {}
    if aside.state == "archived":
        return {"archived_utc": aside.utc}
    return {"deleted_utc": aside.utc, "purge_utc": aside.purge_utc}


class ArchivedRecords:
    """What is set aside. A run of a campaign that is, is so with it."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine

    def archive(self, kind: Kind, name: str, operator: str) -> None:
        """Leave it out of lists, and of what is made of a campaign unless it is named.

        Raises:
            NotFoundError: there is no such thing.
            ConflictError: it goes on, or is deleted.
        """
        self._put(kind, name, "archive", operator, "")

    def delete(self, kind: Kind, name: str, operator: str, grace: timedelta) -> None:
        """Leave it out everywhere, and have its samples deleted when the grace time has ended.

        Raises:
            NotFoundError: there is no such thing.
            ConflictError: it goes on, waits in a queue, or another run continues it.
        """
        until = (datetime.now(UTC) + grace).isoformat(timespec="milliseconds")
        self._put(kind, name, "delete", operator, until)

    def restore(self, kind: Kind, name: str, operator: str) -> None:
        """Have it back where it was.

        Raises:
            NotFoundError: there is no such thing.
            ConflictError: its samples are deleted by now.
        """
        with write_transaction(self._engine) as connection:
            campaign = _campaign_of(connection, kind, name)
            found = archive_entry(connection, kind, name)
            if found is None:
                return
            if found.state in _LOST:
                raise ConflictError(
                    f"its grace time ended at {found.purge_utc}", where=name, remedy="restore a backup of the folder"
                )
            connection.execute(delete(SET_ASIDE).where(SET_ASIDE.c.kind == kind, SET_ASIDE.c.id == name))
            _mark_changed(connection, campaign)
            audit.add_audit_note(connection, operator, f"restore-{kind}", name, {})

    def state_of_run(self, run: str, campaign: str) -> ArchiveEntry | None:
        """How a run was set aside, by itself or with its campaign; None if it was not."""
        with read_transaction(self._engine) as connection:
            return archive_entry(connection, "run", run) or archive_entry(connection, "campaign", campaign)

    def state_of_campaign(self, campaign: str) -> ArchiveEntry | None:
        """How a campaign was set aside; None if it was not."""
        with read_transaction(self._engine) as connection:
            return archive_entry(connection, "campaign", campaign)

    def require_present(self, campaign: str) -> None:
        """Reject what would add to a campaign that is set aside.

        Raises:
            ConflictError: it is.
        """
        found = self.state_of_campaign(campaign)
        if found is not None:
            raise ConflictError(f"the campaign is {found.state}", where=campaign, remedy="restore it first")

    def expired_entries(self, now: str) -> list[tuple[Kind, str]]:
        """What is to be purged: its grace time has ended by `now`, or it was begun and not finished."""
        ended = SET_ASIDE.c.state.in_(("deleted", "purging")), SET_ASIDE.c.purge_utc <= now
        with read_transaction(self._engine) as connection:
            return [(row.kind, row.id) for row in connection.execute(select(SET_ASIDE).where(*ended))]

    def begin_purge(self, kind: Kind, name: str, now: str) -> bool:
        """Enter that it cannot come back; whether that is so: somebody may have restored it meanwhile."""
        mine = SET_ASIDE.c.kind == kind, SET_ASIDE.c.id == name, SET_ASIDE.c.state.in_(("deleted", "purging"))
        with write_transaction(self._engine) as connection:
            purging = update(SET_ASIDE).where(*mine, SET_ASIDE.c.purge_utc <= now).values(state="purging")
            return connection.execute(purging).rowcount == 1

    def end_purge(self, kind: Kind, name: str) -> None:
        """Enter that its samples are deleted."""
        mine = SET_ASIDE.c.kind == kind, SET_ASIDE.c.id == name, SET_ASIDE.c.state == "purging"
        with write_transaction(self._engine) as connection:
            connection.execute(update(SET_ASIDE).where(*mine).values(state="purged"))

    def _put(self, kind: Kind, name: str, action: str, operator: str, purge_utc: str) -> None:
        row = {"kind": kind, "id": name, "state": _WORD[action], "operator": operator, "utc": utc_now()}
        with write_transaction(self._engine) as connection:
            campaign = _campaign_of(connection, kind, name)
            found = archive_entry(connection, kind, name)
            if found is not None and found.state != "archived" and action == "archive":
                raise ConflictError(f"it is {found.state}", where=name, remedy="restore it first")
            if found is not None and (found.state == _WORD[action] or found.state in _LOST):
                return
            _require_at_rest(connection, kind, name)
            if action == "delete" and kind == "run":
                _require_not_continued(connection, name)
            connection.execute(delete(SET_ASIDE).where(SET_ASIDE.c.kind == kind, SET_ASIDE.c.id == name))
            connection.execute(insert(SET_ASIDE).values(row | {"purge_utc": purge_utc}))
            _mark_changed(connection, campaign)
            audit.add_audit_note(
                connection, operator, f"{action}-{kind}", name, {"until": purge_utc} if purge_utc else {}
            )


def archive_entry(connection: Connection, kind: Kind, name: str) -> ArchiveEntry | None:
    """How a campaign or a run was set aside by itself; None if it was not."""
    return archive_notes(connection, kind, [name]).get(name)


def archive_notes(connection: Connection, kind: Kind, names: Sequence[str]) -> dict[str, ArchiveEntry]:
    """How those of these campaigns or runs were set aside that were, by name."""
    query = select(SET_ASIDE).where(SET_ASIDE.c.kind == kind, SET_ASIDE.c.id.in_(names))
    rows = connection.execute(query).mappings()
    return {row["id"]: ArchiveEntry(row["state"], row["operator"], row["utc"], row["purge_utc"]) for row in rows}


def names_left_out(kind: Kind, *, archived: bool, deleted: bool) -> Select[tuple[str]]:
    """Names of what is left out of a list, unless it was asked for."""
    states = ([] if archived else ["archived"]) + ([] if deleted else ["deleted", *_LOST])
    return select(SET_ASIDE.c.id).where(SET_ASIDE.c.kind == kind, SET_ASIDE.c.state.in_(states))


def restore_campaign_of_run(connection: Connection, campaign: str) -> None:
    """Take a campaign back from the archive, since a run has begun in it: what is recorded now must not be deleted."""
    mine = SET_ASIDE.c.kind == "campaign", SET_ASIDE.c.id == campaign, SET_ASIDE.c.state.not_in(_LOST)
    connection.execute(delete(SET_ASIDE).where(*mine))


def _campaign_of(connection: Connection, kind: Kind, name: str) -> str:
    query = select(CAMPAIGNS.c.id).where(CAMPAIGNS.c.id == name)
    if kind == "run":
        query = select(CAMPAIGN_RUNS.c.campaign).where(CAMPAIGN_RUNS.c.run == name)
    found = connection.scalar(query)
    if found is None:
        where = "the list of campaigns" if kind == "campaign" else "the runs of a campaign"
        raise NotFoundError(f"there is no {kind} {name!r} in a campaign", remedy=f"look at {where}")
    return found


def _require_at_rest(connection: Connection, kind: Kind, name: str) -> None:
    column = CAMPAIGN_RUNS.c.campaign if kind == "campaign" else CAMPAIGN_RUNS.c.run
    joined = select(RUNS.c.id).join(CAMPAIGN_RUNS, CAMPAIGN_RUNS.c.run == RUNS.c.id)
    going_on = connection.scalar(joined.where(column == name, RUNS.c.state.not_in(ENDED)).limit(1))
    if going_on is not None:
        raise ConflictError(f"run {going_on} is active", where=name, remedy="wait for its end, or stop it")
    waits = select(QUEUE.c.id).where(QUEUE.c.campaign == name, QUEUE.c.state.in_(("waiting", "running"))).limit(1)
    item = connection.scalar(waits) if kind == "campaign" else None
    if item is not None:
        raise ConflictError(
            f"item {item} of the queue belongs to this run or campaign", where=name, remedy="skip it first"
        )


def _require_not_continued(connection: Connection, run: str) -> None:
    gone = select(SET_ASIDE.c.id).where(SET_ASIDE.c.kind == "run", SET_ASIDE.c.state != "archived")
    query = select(CAMPAIGN_RUNS.c.run).where(CAMPAIGN_RUNS.c.continues == run, CAMPAIGN_RUNS.c.run.not_in(gone))
    after = connection.scalar(query.limit(1))
    if after is not None:
        raise ConflictError(f"run {after} continues this run", where=run, remedy=f"delete run {after} first")


def _mark_changed(connection: Connection, campaign: str) -> None:
    query = update(CAMPAIGNS).where(CAMPAIGNS.c.id == campaign)
    connection.execute(query.values(revision=CAMPAIGNS.c.revision + 1))
