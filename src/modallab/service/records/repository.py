"""The repository of campaigns: which there are, which runs and jobs belong to each, how each run ended."""

import secrets
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any

from sqlalchemy import Connection, Engine, delete, insert, or_, select, update

from modallab.core.documents.runs import CampaignChange, CampaignRequest, CampaignView
from modallab.jobs import Job
from modallab.service.errors import ChangedError, IdempotencyError, NotFoundError
from modallab.service.records import audit
from modallab.service.records.archive import archive_notes, archive_state, names_left_out, restore_campaign_of_run
from modallab.storage.engine import next_number, read_transaction, write_transaction
from modallab.storage.recorder import utc_now
from modallab.storage.service_tables import CAMPAIGN_JOBS, CAMPAIGN_RUNS, CAMPAIGNS, RUN_KEYS

KEY_LIFE = timedelta(hours=24)
"""For so long a request that is sent again under its key is not done again."""


@dataclass(frozen=True, slots=True)
class RunEntry:
    """What the repository says of a run.

    Attributes:
        run: name of the run.
        campaign: it belongs to.
        rig: id of the rig.
        operator: name of the operator who started it.
        continues: name of the continued run.
        code: of the error it ended with, else "".
    """

    run: str
    campaign: str
    rig: str
    operator: str
    continues: str | None
    code: str = ""


@dataclass(frozen=True, slots=True)
class RunKey:
    """An idempotency key, and the SHA-256 of the request it was sent with."""

    key: str
    request: str


class CampaignRepository:
    """Campaigns with their runs and jobs, in the service's database."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine

    def create(self, new: CampaignRequest, operator: str) -> CampaignView:
        """Enter a campaign, under an id made here.

        Raises:
            StorageError: it could not be kept.
        """
        now = datetime.now(UTC)
        row: dict[str, Any] = {
            "id": f"c{now:%Y%m%dT%H%M%S}-{secrets.token_hex(4)}",
            "name": new.name,
            "note": new.note,
            "rig": new.rig,
            "operator": operator,
            "created_utc": utc_now(),
            "revision": 1,
        }
        with write_transaction(self._engine) as connection:
            connection.execute(insert(CAMPAIGNS).values(row | {"seq": next_number(connection, CAMPAIGNS)}))
            audit.add_audit_note(connection, operator, "create-campaign", row["id"], {"name": new.name, "rig": new.rig})
        return CampaignView(**row)

    def campaign(self, campaign: str) -> CampaignView:
        """One campaign.

        Raises:
            NotFoundError: there is none of this id.
        """
        with read_transaction(self._engine) as connection:
            return _campaign(connection, campaign)

    def campaigns(
        self,
        before: str | None,
        limit: int,
        *,
        rig: str = "",
        text: str = "",
        archived: bool = False,
        deleted: bool = False,
    ) -> list[CampaignView]:
        """Up to `limit` campaigns before the one named `before`, newest first; of a rig, with a text in it.

        Those that are archived or deleted only where they are asked for.
        """
        query = select(CAMPAIGNS.c.id).order_by(CAMPAIGNS.c.seq.desc()).limit(limit)
        query = query.where(CAMPAIGNS.c.id.not_in(names_left_out("campaign", archived=archived, deleted=deleted)))
        if rig:
            query = query.where(CAMPAIGNS.c.rig == rig)
        if text:
            columns = CAMPAIGNS.c.name, CAMPAIGNS.c.note
            query = query.where(or_(*(column.icontains(text, autoescape=True) for column in columns)))
        if before is not None:
            place = select(CAMPAIGNS.c.seq).where(CAMPAIGNS.c.id == before).scalar_subquery()
            query = query.where(CAMPAIGNS.c.seq < place)
        with read_transaction(self._engine) as connection:
            return _campaigns(connection, connection.scalars(query).all())

    def runs(self, campaign: str, *, archived: bool = False, deleted: bool = False) -> tuple[str, ...]:
        """The runs of a campaign, the oldest first; archived or deleted ones only on request.

        Raises:
            NotFoundError: there is no such campaign.
        """
        with read_transaction(self._engine) as connection:
            _campaign(connection, campaign)
            return _runs(connection, campaign, archived=archived, deleted=deleted)

    def change(self, campaign: str, change: CampaignChange, revision: int, operator: str) -> CampaignView:
        """Change a campaign, if it is still at `revision`.

        Raises:
            NotFoundError: there is none of this id.
            ChangedError: it is at another revision.
        """
        values = change.model_dump(exclude_none=True)
        with write_transaction(self._engine) as connection:
            found = _campaign(connection, campaign)
            if found.revision != revision:
                raise ChangedError(
                    f"the campaign is at revision {found.revision}, not {revision}",
                    where=campaign,
                    remedy="read the campaign again, then repeat the change",
                )
            query = update(CAMPAIGNS).where(CAMPAIGNS.c.id == campaign)
            connection.execute(query.values(**values, revision=revision + 1))
            audit.add_audit_note(connection, operator, "change-campaign", campaign, values)
            return _campaign(connection, campaign)

    def add_run(self, entry: RunEntry, plan: dict[str, Any], key: RunKey | None = None) -> None:
        """Enter a run that has begun, with the key it was asked for under.

        Raises:
            StorageError: it could not be kept.
        """
        with write_transaction(self._engine) as connection:
            row = {name: getattr(entry, name) for name in _ENTRY} | {"seq": next_number(connection, CAMPAIGN_RUNS)}
            connection.execute(insert(CAMPAIGN_RUNS).values(row))
            more = update(CAMPAIGNS).where(CAMPAIGNS.c.id == entry.campaign)
            connection.execute(more.values(revision=CAMPAIGNS.c.revision + 1))
            restore_campaign_of_run(connection, entry.campaign)
            audit.add_audit_note(
                connection, entry.operator, "start-run", entry.run, {"campaign": entry.campaign, "plan": plan}
            )
            if key is not None:
                connection.execute(delete(RUN_KEYS).where(RUN_KEYS.c.created_utc < key_limit()))
                kept = {"key": key.key, "request": key.request, "run": entry.run, "created_utc": utc_now()}
                connection.execute(insert(RUN_KEYS).values(kept))

    def run_of(self, key: RunKey) -> str | None:
        """The run that was begun under a key; None if there is none, or it was longer ago than `KEY_LIFE`.

        Raises:
            IdempotencyError: another request was sent with it.
        """
        query = select(RUN_KEYS).where(RUN_KEYS.c.key == key.key, RUN_KEYS.c.created_utc >= key_limit())
        with read_transaction(self._engine) as connection:
            row = connection.execute(query).mappings().one_or_none()
        if row is not None and row["request"] != key.request:
            raise key_of_another()
        return None if row is None else str(row["run"])

    def set_code(self, run: str, code: str) -> None:
        """Keep the code of the error that ended a run.

        Raises:
            StorageError: it could not be kept.
        """
        with write_transaction(self._engine) as connection:
            connection.execute(update(CAMPAIGN_RUNS).where(CAMPAIGN_RUNS.c.run == run).values(code=code))

    def run_entry(self, run: str) -> RunEntry | None:
        """What the repository says of a run; None if it belongs to no campaign."""
        with read_transaction(self._engine) as connection:
            row = connection.execute(select(CAMPAIGN_RUNS).where(CAMPAIGN_RUNS.c.run == run)).mappings().one_or_none()
        return None if row is None else RunEntry(**{name: row[name] for name in _ENTRY})

    def runs_continued(self, run: str) -> tuple[str, ...]:
        """A run with all it continues, the oldest first."""
        found = [run]
        while (entry := self.run_entry(found[0])) is not None and entry.continues and entry.continues not in found:
            found.insert(0, entry.continues)
        return tuple(found)

    def add_job(self, campaign: str, job: Job, operator: str) -> None:
        """Keep that a job is of a campaign, and its newest of this kind; nothing to do if it is that already.

        Raises:
            StorageError: it could not be kept.
        """
        mine = CAMPAIGN_JOBS.c.campaign == campaign, CAMPAIGN_JOBS.c.kind == job.kind
        newest = select(CAMPAIGN_JOBS.c.job).where(*mine).order_by(CAMPAIGN_JOBS.c.n.desc()).limit(1)
        with write_transaction(self._engine) as connection:
            if connection.scalar(newest) == job.id:
                return
            connection.execute(insert(CAMPAIGN_JOBS).values(campaign=campaign, job=job.id, kind=job.kind))
            audit.add_audit_note(
                connection, operator, f"order-{job.kind}", campaign, {"job": job.id, "runs": list(job.inputs)}
            )

    def jobs(self, campaign: str, kind: str | None = None) -> list[str]:
        """Names of the jobs of a campaign, of one kind or of all, the one that was ordered last first."""
        query = select(CAMPAIGN_JOBS.c.job).where(CAMPAIGN_JOBS.c.campaign == campaign)
        if kind is not None:
            query = query.where(CAMPAIGN_JOBS.c.kind == kind)
        with read_transaction(self._engine) as connection:
            return list(dict.fromkeys(connection.scalars(query.order_by(CAMPAIGN_JOBS.c.n.desc()))))

    def campaign_of_job(self, job: str) -> str:
        """The campaign a job was ordered for first, else ""."""
        query = select(CAMPAIGN_JOBS.c.campaign).where(CAMPAIGN_JOBS.c.job == job).limit(1)
        with read_transaction(self._engine) as connection:
            return connection.scalar(query) or ""


def key_limit() -> str:
    """Keys that are older count no more; as `created_utc` is written."""
    return (datetime.now(UTC) - KEY_LIFE).isoformat(timespec="milliseconds")


def key_of_another() -> IdempotencyError:
    """What to raise where a key stands for another request."""
    return IdempotencyError("another request had this key", where="Idempotency-Key", remedy="make a new key")


_ENTRY = ("run", "campaign", "rig", "operator", "continues", "code")


def _campaign(connection: Connection, campaign: str) -> CampaignView:
    found = _campaigns(connection, [campaign])
    if not found:
        raise NotFoundError(f"there is no campaign {campaign!r}", remedy="look at the list of campaigns")
    return found[0]


def _campaigns(connection: Connection, names: Sequence[str]) -> list[CampaignView]:
    """Those of these names that there are, in this order; asked for all at once, since a list is long."""
    query = select(CAMPAIGNS).where(CAMPAIGNS.c.id.in_(names))
    rows = {row["id"]: row for row in connection.execute(query).mappings()}
    asides = archive_notes(connection, "campaign", names)
    recorded = (
        select(CAMPAIGN_RUNS.c.campaign, CAMPAIGN_RUNS.c.run)
        .where(CAMPAIGN_RUNS.c.campaign.in_(names))
        .where(CAMPAIGN_RUNS.c.run.not_in(names_left_out("run", archived=False, deleted=False)))
        .order_by(CAMPAIGN_RUNS.c.seq)
    )
    runs: dict[str, list[str]] = {name: [] for name in names}
    for campaign, run in connection.execute(recorded):
        runs[campaign].append(run)
    return [
        CampaignView.model_validate(
            {
                **{str(column): value for column, value in rows[name].items() if column != "seq"},
                "runs": tuple(runs[name]),
                **archive_state(asides.get(name)),
            }
        )
        for name in names
        if name in rows
    ]


def _runs(connection: Connection, campaign: str, *, archived: bool, deleted: bool) -> tuple[str, ...]:
    query = select(CAMPAIGN_RUNS.c.run).where(
        CAMPAIGN_RUNS.c.campaign == campaign,
        CAMPAIGN_RUNS.c.run.not_in(names_left_out("run", archived=archived, deleted=deleted)),
    )
    return tuple(connection.scalars(query.order_by(CAMPAIGN_RUNS.c.seq)))
