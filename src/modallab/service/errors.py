"""What the service rejects, besides what the stages below reject."""

from typing import Self

from modallab.core.errors import Http, ModallabError, split_remedy


class ServiceError(ModallabError):
    """The service rejects the request now, or not in this way."""

    code = "service"
    http = Http(409, "The service rejects the request", "Read the message.")


class NotFoundError(ServiceError):
    """Not found."""

    code = "not-found"
    http = Http(404, "Not found", "Read the list of such objects.")


class ConflictError(ServiceError):
    """Not possible in the present state; `legal` says what is, where that is a list."""

    code = "conflict"
    http = Http(409, "Not possible in the present state", "Read the message, and try again.")


class LeaseHeldError(ConflictError):
    """The rig is held, by someone else or by another program of the same operator."""

    code = "lease-held"
    http = Http(
        409,
        "The rig is held",
        "Ask the holder to release the lease, or wait. If the holder is absent and no run is active, send "
        "`take_over`; for your own lease send `recover`. An emergency stop needs no lease.",
    )


class LeaseNeededError(ServiceError):
    """Commanding a rig needs its lease, and the one that was sent is none, over, or someone else's by now."""

    code = "lease-needed"
    http = Http(
        403,
        "The rig's lease is needed",
        "Take the lease of the rig, renew it before it ends, and send its id as `Modallab-Lease`.",
    )


class RoleNeededError(ServiceError):
    """Whoever asks may not do this: the role, or the rigs, that the token is for."""

    code = "role-needed"
    http = Http(
        403,
        "The token does not permit this",
        "Each route states its role; a token may be limited to some rigs. An admin can make another token.",
    )


class RigUnavailableError(ServiceError):
    """The rig's process has not opened its bench, or cannot."""

    code = "rig-unavailable"
    http = Http(
        503,
        "The rig is not ready",
        "The rig's process has not opened the bench. Wait, or check cables and address.",
    )

    @classmethod
    def of(cls, what: str, error: str, where: str) -> Self:
        """Of a bench that could not be opened; `error` is the text of what prevented it. Its remedy is kept."""
        reason, remedy = split_remedy(error)
        return cls(
            f"{what}: {reason}" if reason else what,
            where=where,
            remedy=remedy or "wait until the rig is idle; check its cables and its address",
        )


class ChangedError(ServiceError):
    """The document was changed since it was read."""

    code = "changed"
    http = Http(412, "The object was changed meanwhile", "Read the object again and send the new ETag as `If-Match`.")


class PreconditionNeededError(ServiceError):
    """A change must say which revision it changes."""

    code = "precondition-needed"
    http = Http(428, "A change needs If-Match", "Send the ETag of the version that you read as `If-Match`.")


class IdempotencyError(ServiceError):
    """The idempotency key was used for another request."""

    code = "idempotency-key"
    http = Http(422, "The key was used for another request", "Make a new `Idempotency-Key` for every new request.")


class MediaTypeError(ServiceError):
    """The body is of a type that is not read here."""

    code = "media-type"
    http = Http(415, "The body's type is not accepted", "Send JSON, with the header `Content-Type: application/json`.")


class RunEndedError(ServiceError):
    """The run was stopped short: aborted, or failed. What it had acknowledged is kept."""

    code = "run-ended"
