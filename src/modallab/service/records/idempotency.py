"""Requests that carry a key are done once: who asks again gets the first answer again."""

import hashlib
from dataclasses import dataclass

from sqlalchemy import Engine, delete, insert, select, update

from modallab.service.errors import ConflictError, IdempotencyError
from modallab.service.records.database import writing
from modallab.storage.recorder import utc_now
from modallab.storage.service_tables import IDEMPOTENCY


@dataclass(frozen=True, slots=True)
class Answer:
    """What a request was answered with."""

    status: int
    headers: dict[str, str]
    body: str


class Keys:
    """Idempotency keys and the answers kept under them."""

    def __init__(self, engine: Engine, boot: str) -> None:
        """`boot` names the process that answers: what another one left unfinished will not be finished."""
        self._engine = engine
        self._boot = boot

    def claim(self, key: str, request: bytes) -> Answer | None:
        """Claim a key for a request; the answer, if it was answered before.

        Raises:
            IdempotencyError: the key stands for another request.
            ConflictError: the first request is still being answered.
        """
        digest = hashlib.sha256(request).hexdigest()
        row = {"key": key, "request": digest, "boot": self._boot, "headers": {}, "created_utc": utc_now()}
        with writing(self._engine) as connection:
            query = select(IDEMPOTENCY).where(IDEMPOTENCY.c.key == key)
            found = connection.execute(query).mappings().one_or_none()
            if found is None:
                connection.execute(insert(IDEMPOTENCY).values(row))
                return None
            if found["request"] != digest:
                raise IdempotencyError(
                    "this key was sent with another request", where="Idempotency-Key", remedy="make a new key"
                )
            if found["status"] is not None:
                return Answer(found["status"], dict(found["headers"]), found["body"])
            if found["boot"] == self._boot:
                raise ConflictError(
                    "the first request with this key is being answered", where="Idempotency-Key", remedy="ask again"
                )
            connection.execute(update(IDEMPOTENCY).where(IDEMPOTENCY.c.key == key).values(boot=self._boot))
        return None

    def keep(self, key: str, answer: Answer) -> None:
        """Keep the answer for whoever asks again."""
        values = {"status": answer.status, "headers": answer.headers, "body": answer.body}
        with writing(self._engine) as connection:
            connection.execute(update(IDEMPOTENCY).where(IDEMPOTENCY.c.key == key).values(values))

    def forget(self, key: str) -> None:
        """Nothing was done: the same key may be used again."""
        with writing(self._engine) as connection:
            connection.execute(delete(IDEMPOTENCY).where(IDEMPOTENCY.c.key == key))
