"""The latch of the emergency stop: once tripped, nothing is armed until somebody resets it.

It is a file in the data folder, so that it survives every process and the machine's restart. It belongs to the bench's
address, since it is the output there that was stopped. It is no safety-rated stop.
"""

import hashlib
import json
import os
import secrets
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal, cast

from modallab.core.errors import HttpProblem, SafetyError, StorageError
from modallab.core.frozen import Frozen

FOLDER = "trips"

Cause = Literal["emergency stop", "time-out", "death", "unreadable"]

RENAMED = {"silence": "time-out"}
"""Cause in latches that earlier versions wrote -> its name today."""


class TrippedError(SafetyError):
    """The rig is tripped: nothing is armed, and an active run has been ended."""

    code = "tripped"
    http = HttpProblem(
        409, "The rig is tripped", "An emergency stop or a guard tripped the rig. Check the bench, then reset the rig."
    )


class Trip(Frozen):
    """What tripped a rig.

    Attributes:
        url: of the bench.
        cause: an emergency stop, a time-out or the death of the rig's process, or a latch that cannot be read.
        what: notice in words.
        utc: date and time.
    """

    url: str
    cause: Cause
    what: str
    utc: str


class TripLatch:
    """The latch of one bench in one data folder. Any process may trip it, look at it, or reset it."""

    def __init__(self, data_folder: Path, url: str) -> None:
        # Options of an address, such as a seed or a certificate, make no other output of it.
        place = url.partition("?")[0]
        self._url = place
        self._path = data_folder / FOLDER / f"{hashlib.sha256(place.encode()).hexdigest()[:16]}.json"

    @property
    def is_tripped(self) -> bool:
        """Whether it is; cheap enough to be asked all the time."""
        return self._path.exists()

    def trip(self, cause: Cause, what: str) -> None:
        """Trip it; the first cause stays.

        Raises:
            StorageError: it cannot be written.
        """
        if self.is_tripped:
            return
        trip = Trip(url=self._url, cause=cause, what=what, utc=datetime.now(UTC).isoformat(timespec="milliseconds"))
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            # Whole or not at all: whoever looks meanwhile must not find half a latch.
            draft = self._path.with_suffix(f".{secrets.token_hex(4)}")
            with draft.open("w", encoding="utf-8") as file:
                file.write(trip.model_dump_json())
                file.flush()
                os.fsync(file.fileno())
            draft.replace(self._path)
        except OSError as error:
            # On a full disk an empty file may still find room, and one that cannot be read is a tripped latch.
            with suppress(OSError):
                self._path.touch()
            raise StorageError(
                f"the trip could not be written: {error.strerror}", where=str(self._path), remedy="look at the disk"
            ) from error

    def read(self) -> Trip | None:
        """What tripped it; None if nothing did."""
        try:
            return _parse_trip(self._path.read_text(encoding="utf-8"))
        except FileNotFoundError:
            return None
        except (OSError, ValueError):
            return Trip(url=self._url, cause="unreadable", what=f"{self._path} cannot be read", utc="")

    def reset(self) -> Trip | None:
        """Let the rig be armed again; returns what had tripped it."""
        trip = self.read()
        self._path.unlink(missing_ok=True)
        return trip

    def require_reset(self) -> None:
        """Raise while it is tripped.

        Raises:
            TrippedError: with what tripped it, and when.
        """
        trip = self.read()
        if trip is not None:
            raise TrippedError(
                f"the rig was tripped by {trip.cause} at {trip.utc or 'an unknown time'}: {trip.what}",
                where=self._url,
                remedy="check the bench, then reset the rig: modallab rig reset RIG.yaml --data FOLDER",
            )


def _parse_trip(text: str) -> Trip:
    content = json.loads(text)
    if isinstance(content, dict):
        fields = cast("dict[str, object]", content)
        content = {**fields, "cause": RENAMED.get(str(fields.get("cause")), fields.get("cause"))}
    return Trip.model_validate(content)
