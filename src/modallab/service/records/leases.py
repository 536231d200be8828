"""The right to command a rig: one holder at a time, for a limited time, with a number that grows with every holder."""

import secrets
import time
from typing import Any

from sqlalchemy import Connection, Engine, delete, insert, select, update

from modallab.core.documents.rigs import Lease, LeaseHolder
from modallab.service.errors import LeaseHeldError, LeaseNeededError, NotFoundError
from modallab.service.records import audit
from modallab.service.records.users import UNKNOWN
from modallab.storage.engine import read_transaction, write_transaction
from modallab.storage.service_tables import LEASES

REMEDY = "take the lease of the rig, renew it before it ends, and send its id as Modallab-Lease"


class RigLeases:
    """Leases of one service. Time is the machine's monotonic clock, so that no clock on the wall ends or prolongs one.

    A lease of an earlier start of the service is void: nobody may hold what nobody watched.
    """

    def __init__(self, engine: Engine, boot: str) -> None:
        """`boot` names this start of the service."""
        self._engine = engine
        self._boot = boot

    def take(self, rig: str, operator: str, ttl_s: float, *, take_over: bool = False) -> Lease:
        """Take the lease of a rig; with `take_over` from its holder, whose lease commands nothing from then on.

        Raises:
            LeaseHeldError: someone holds it.
        """
        with write_transaction(self._engine) as connection:
            row = _lease_row(connection, rig)
            holder = row["operator"] if row is not None and self._remaining_s(row) > 0 else None
            if holder is not None and not take_over:
                raise self._rejected(row, rig, operator)
            fence = 1 if row is None else int(row["fence"]) + 1
            connection.execute(delete(LEASES).where(LEASES.c.rig == rig))
            lease = Lease(id=secrets.token_urlsafe(18), rig=rig, operator=operator, fence=fence, ttl_s=ttl_s)
            values = lease.model_dump() | {"boot": self._boot, "expires_s": time.monotonic() + ttl_s}
            connection.execute(insert(LEASES).values(values))
            taken_from = {} if holder is None else {"taken_from": holder}
            audit.add_audit_note(
                connection, operator, "take-lease", rig, {"fence": fence, "ttl_s": ttl_s, **taken_from}
            )
        return lease

    def renew(self, rig: str, lease: str) -> Lease:
        """Restart the time of the lease.

        Raises:
            LeaseNeededError: it is over or not the one.
        """
        with write_transaction(self._engine) as connection:
            row = self._held(_lease_row(connection, rig), rig, lease)
            later = update(LEASES).where(LEASES.c.rig == rig).values(expires_s=time.monotonic() + row["ttl_s"])
            connection.execute(later)
        return _lease_of_row(row)

    def release(self, rig: str, lease: str) -> None:
        """Release the lease.

        Raises:
            LeaseNeededError: it is over or not the one.
        """
        with write_transaction(self._engine) as connection:
            row = self._held(_lease_row(connection, rig), rig, lease)
            # The row stays, for its number must grow.
            connection.execute(update(LEASES).where(LEASES.c.rig == rig).values(expires_s=0.0))
            audit.add_audit_note(connection, row["operator"], "release-lease", rig, {"fence": row["fence"]})

    def require(self, rig: str, lease: str | None) -> Lease:
        """The lease, if `lease` names the one that is held now.

        Raises:
            LeaseNeededError: it does not.
        """
        with read_transaction(self._engine) as connection:
            return _lease_of_row(self._held(_lease_row(connection, rig), rig, lease))

    def owner(self, lease: str) -> str | None:
        """Who took the lease of this id, held or over; None if it is not the last one of a rig."""
        with read_transaction(self._engine) as connection:
            return connection.scalar(select(LEASES.c.operator).where(LEASES.c.id == lease))

    def recover(self, rig: str, operator: str) -> Lease:
        """The lease that `operator` holds, whose program has forgotten its id; its time begins again.

        Raises:
            LeaseHeldError: someone else holds it.
            NotFoundError: nobody does.
        """
        with read_transaction(self._engine) as connection:
            row = _lease_row(connection, rig)
        if row is None or self._remaining_s(row) <= 0:
            raise NotFoundError(f"nobody holds {rig}", where=rig, remedy="take the lease")
        if row["operator"] != operator:
            raise self._rejected(row, rig, operator)
        return self.renew(rig, str(row["id"]))

    def holder(self, rig: str) -> LeaseHolder | None:
        """Who holds the rig; None if nobody does."""
        with read_transaction(self._engine) as connection:
            row = _lease_row(connection, rig)
        if row is None or self._remaining_s(row) <= 0:
            return None
        return LeaseHolder(operator=row["operator"], fence=row["fence"], remaining_s=self._remaining_s(row))

    def _rejected(self, row: Any, rig: str, operator: str) -> LeaseHeldError:
        # Who sends no name is one of many, and no other of them is he.
        if row["operator"] == operator != UNKNOWN:
            return LeaseHeldError(
                f"{operator} holds {rig} already, for {self._remaining_s(row):.1f} s more: the lease is yours",
                where=rig,
                remedy="send recover: true to get the lease again; or release the lease where you took it",
            )
        return LeaseHeldError(
            f"{row['operator']} holds {rig} for {self._remaining_s(row):.1f} s more",
            where=rig,
            remedy="ask the holder to release the lease, or wait; if the holder's program has ended, send "
            "take_over, or for your own lease recover; an emergency stop needs no lease",
        )

    def _remaining_s(self, row: Any) -> float:
        return float(row["expires_s"]) - time.monotonic() if row["boot"] == self._boot else 0.0

    def _held(self, row: Any, rig: str, lease: str | None) -> Any:
        if not lease:
            raise LeaseNeededError(f"commanding {rig} needs its lease, and none was sent", where=rig, remedy=REMEDY)
        if row is None or not secrets.compare_digest(str(row["id"]).encode(), lease.encode()):
            raise LeaseNeededError(f"this is not the present lease of {rig}", where=rig, remedy=REMEDY)
        if self._remaining_s(row) <= 0:
            raise LeaseNeededError(f"the lease of {rig} has ended", where=rig, remedy=REMEDY)
        return row


def _lease_row(connection: Connection, rig: str) -> Any:
    return connection.execute(select(LEASES).where(LEASES.c.rig == rig)).mappings().one_or_none()


def _lease_of_row(row: Any) -> Lease:
    return Lease(**{name: row[name] for name in Lease.model_fields})
