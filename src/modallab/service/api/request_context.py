"""What a route takes from a request: the service, who asks, which revision, which page of a list."""

import base64
import binascii
from collections.abc import Callable, Sequence
from typing import Annotated, Literal, TypeVar

from fastapi import Depends, Header, Query, Request, Response

from modallab.core.documents.pages import Page
from modallab.core.documents.users import CallerView
from modallab.core.errors import DataError
from modallab.core.units import Test
from modallab.service.context import Service
from modallab.service.errors import ChangedError, PreconditionNeededError
from modallab.service.records.users import UNKNOWN

OPERATOR = "Modallab-Operator"
LEASE = "Modallab-Lease"
NOTES = "Modallab-Notes"
CALLER = "modallab.caller"
"""In the scope of a request whose token or cookie counts."""
_NO_CONTROL = r"^[^\x00-\x1f\x7f]+$"
Item = TypeVar("Item")
OfTest = Annotated[Test | None, Query(description="Test of the model (default: the first).")]
Points = Annotated[list[int] | None, Query(max_length=100, description="Points; repeat for several.")]
Motion = Literal["displacement", "velocity", "acceleration"]


def _service(request: Request) -> Service:
    return request.app.state.service


def caller_of(request: Request) -> CallerView:
    """Who asks.

    Raises:
        KeyError: nobody whom the service knows, where a route is open to all.
    """
    return request.scope[CALLER]


def _operator(
    request: Request,
    response: Response,
    operator: Annotated[
        str | None,
        Header(
            alias=OPERATOR,
            max_length=80,
            pattern=_NO_CONTROL,
            description="Name of the operator for the audit record, with the service's own token.",
        ),
    ] = None,
) -> str:
    name = caller_of(request).name
    if name or operator is not None:
        return name or _text_as_sent(operator or "")
    response.headers[NOTES] = f"no operator is named, and the record says {UNKNOWN}: send {OPERATOR}"
    return UNKNOWN


def _text_as_sent(text: str) -> str:
    # Headers are bytes, read as Latin-1; most programs send UTF-8, browsers Latin-1.
    try:
        return text.encode("latin-1").decode()
    except UnicodeError:
        return text


CallerOf = Annotated[CallerView, Depends(caller_of)]
ServiceOf = Annotated[Service, Depends(_service)]
Operator = Annotated[str, Depends(_operator)]
LeaseId = Annotated[
    str | None, Header(alias=LEASE, max_length=64, description="Id of the rig's lease.", pattern=_NO_CONTROL)
]


IfMatch = Annotated[
    str | None, Header(alias="If-Match", max_length=200, description="ETag of the version that was read.")
]
IfNoneMatch = Annotated[str | None, Header(alias="If-None-Match", max_length=200)]


def revision_of(if_match: str | None) -> int:
    """The revision a change is meant for.

    Raises:
        PreconditionNeededError: the request does not say.
        ChangedError: what it says is no ETag of this kind.
    """
    if if_match is None:
        raise PreconditionNeededError(
            "the change does not name the version to change",
            where="If-Match",
            remedy="send the ETag of the version that you read",
        )
    text = if_match.strip().removeprefix("W/").strip('"')
    if not (text.isascii() and text.isdigit() and len(text) < 10):
        raise ChangedError(f"{if_match!r} is not its ETag", where="If-Match", remedy="read it again")
    return int(text)


def set_etag(response: Response, tag: object) -> None:
    """Put an ETag on an answer."""
    response.headers["ETag"] = f'"{tag}"'


def is_unchanged(if_none_match: str | None, tag: object) -> bool:
    """Whether the client has this already."""
    return if_none_match is not None and f'"{tag}"' in if_none_match


Limit = Annotated[int, Query(ge=1, le=500, description="Largest number of items.")]
Cursor = Annotated[str | None, Query(max_length=200, description="`next` of the previous page.")]


def page_cursor(cursor: str | None) -> str | None:
    """Where a page begins.

    Raises:
        DataError: it is no cursor of ours.
    """
    if cursor is None:
        return None
    try:
        place = base64.urlsafe_b64decode(cursor.encode()).decode()
    except (binascii.Error, UnicodeError, ValueError) as error:
        raise _foreign_cursor(cursor) from error
    if not place.isprintable():
        raise _foreign_cursor(cursor)
    return place


def page_cursor_number(cursor: str | None) -> int | None:
    """As `place_of`, for lists in the order of a number."""
    place = page_cursor(cursor)
    if place is None:
        return None
    if not (place.isascii() and place.isdigit() and len(place) <= 18):
        raise _foreign_cursor(cursor or "")
    return int(place)


def page_of_items(items: Sequence[Item], limit: int, place: Callable[[Item], object]) -> Page[Item]:
    """A page of `items`, of which one more than `limit` was asked for."""
    shown = tuple(items[:limit])
    more = base64.urlsafe_b64encode(str(place(shown[-1])).encode()).decode() if len(items) > limit else None
    return Page(items=shown, next=more)


def _foreign_cursor(cursor: str) -> DataError:
    return DataError(f"{cursor!r} is no cursor", where="cursor", remedy="send `next` of the previous page, unchanged")
