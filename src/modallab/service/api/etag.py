"""ETag, If-Match and If-None-Match."""

from typing import Annotated

from fastapi import Header, Response

from modallab.service.errors import ChangedError, PreconditionNeededError

IfMatch = Annotated[str | None, Header(alias="If-Match", max_length=200, description="ETag of what was read.")]
IfNoneMatch = Annotated[str | None, Header(alias="If-None-Match", max_length=200)]


def revision_of(if_match: str | None) -> int:
    """The revision a change is meant for.

    Raises:
        PreconditionNeededError: the request does not say.
        ChangedError: what it says is no ETag of this kind.
    """
    if if_match is None:
        raise PreconditionNeededError(
            "the change does not say what it changes", where="If-Match", remedy="send the ETag of what you read"
        )
    text = if_match.strip().removeprefix("W/").strip('"')
    if not (text.isascii() and text.isdigit() and len(text) < 10):
        raise ChangedError(f"{if_match!r} is not its ETag", where="If-Match", remedy="read it again")
    return int(text)


def mark(response: Response, tag: object) -> None:
    """Put an ETag on an answer."""
    response.headers["ETag"] = f'"{tag}"'


def unchanged(if_none_match: str | None, tag: object) -> bool:
    """Whether the client has this already."""
    return if_none_match is not None and f'"{tag}"' in if_none_match
