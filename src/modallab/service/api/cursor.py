"""Lists page by page: a cursor says where the next page begins, and means nothing to the client."""

import base64
import binascii
from collections.abc import Callable, Sequence
from typing import Annotated, TypeVar

from fastapi import Query

from modallab.core.documents.pages import Page
from modallab.core.errors import DataError

Item = TypeVar("Item")

Limit = Annotated[int, Query(ge=1, le=500, description="How many at most.")]
Cursor = Annotated[str | None, Query(max_length=200, description="`next` of the page before.")]


def place_of(cursor: str | None) -> str | None:
    """Where a page begins.

    Raises:
        DataError: it is no cursor of ours.
    """
    if cursor is None:
        return None
    try:
        return base64.urlsafe_b64decode(cursor.encode()).decode()
    except (binascii.Error, UnicodeError, ValueError) as error:
        raise _foreign(cursor) from error


def number_of(cursor: str | None) -> int | None:
    """As `place_of`, for lists in the order of a number."""
    place = place_of(cursor)
    if place is None:
        return None
    if not (place.isascii() and place.isdigit() and len(place) <= 18):
        raise _foreign(cursor or "")
    return int(place)


def page(items: Sequence[Item], limit: int, place: Callable[[Item], object]) -> Page[Item]:
    """A page of `items`, of which one more than `limit` was asked for."""
    shown = tuple(items[:limit])
    more = base64.urlsafe_b64encode(str(place(shown[-1])).encode()).decode() if len(items) > limit else None
    return Page(items=shown, next=more)


def _foreign(cursor: str) -> DataError:
    return DataError(f"{cursor!r} is no cursor", where="cursor", remedy="send `next` of the page before, as it was")
