"""What the service rejects, besides what the stages below reject."""

from typing import Self

from modallab.core.errors import Http, ModallabError, split_remedy


class ServiceError(ModallabError):
    """The service cannot do this now, or not in this way."""

    code = "service"
    http = Http(409, "The service cannot do this", "Look at what it says.")


class NotFoundError(ServiceError):
    """There is no such thing."""

    code = "not-found"
    http = Http(404, "There is no such thing", "Look at the list it would be in.")


class ConflictError(ServiceError):
    """Not possible as things stand; `legal` says what is, where that is a list."""

    code = "conflict"
    http = Http(409, "Not possible as things stand", "Look at what it says, and ask again.")


class LeaseHeldError(ConflictError):
    """The rig is held, by someone else or by another program of the same operator."""

    code = "lease-held"
    http = Http(
        409,
        "The rig is held",
        "Ask the holder to give it back, or wait. If the holder is gone and no run is on, ask with `take_over`; "
        "if you hold it yourself, with `recover`. An emergency stop needs no lease.",
    )


class LeaseNeededError(ServiceError):
    """Commanding a rig needs its lease, and the one that was sent is none, over, or someone else's by now."""

    code = "lease-needed"
    http = Http(
        403,
        "The rig's lease is needed",
        "Take the lease of the rig, renew it before it is over, and send its id as `Modallab-Lease`.",
    )


class RoleNeededError(ServiceError):
    """Whoever asks may not do this: the role, or the rigs, that the token is for."""

    code = "role-needed"
    http = Http(
        403,
        "The token is not for this",
        "Each route says which role it needs; a token may be for some rigs only. An admin can make another token.",
    )


class RigUnavailableError(ServiceError):
    """The rig's process has not opened its bench, or cannot."""

    code = "rig-unavailable"
    http = Http(
        503,
        "The rig is not ready",
        "Its process has not opened the bench. Wait, or look at its cables and its address.",
    )

    @classmethod
    def of(cls, what: str, error: str, where: str) -> Self:
        """Of a bench that could not be opened; `error` is the text of what prevented it. Its remedy is kept."""
        reason, remedy = split_remedy(error)
        return cls(
            f"{what}: {reason}" if reason else what,
            where=where,
            remedy=remedy or "wait until it is idle; look at its cables and its address",
        )


class ChangedError(ServiceError):
    """The document was changed since it was read."""

    code = "changed"
    http = Http(412, "It was changed meanwhile", "Read it again and send the new ETag as `If-Match`.")


class PreconditionNeededError(ServiceError):
    """A change must say which revision it changes."""

    code = "precondition-needed"
    http = Http(428, "A change needs If-Match", "Send the ETag of what you read as `If-Match`.")


class IdempotencyError(ServiceError):
    """The idempotency key was used for another request."""

    code = "idempotency-key"
    http = Http(422, "The key was used for another request", "Make a new `Idempotency-Key` for every new request.")


class MediaTypeError(ServiceError):
    """The body is of a type that is not read here."""

    code = "media-type"
    http = Http(415, "The body's type cannot be taken", "Send JSON, with the header `Content-Type: application/json`.")


class RunEndedError(ServiceError):
    """The run was stopped short: aborted, or failed. What it had acknowledged is kept."""

    code = "run-ended"
