"""What the service rejects, besides what the stages below reject."""

from typing import Self

from modallab.core.errors import HttpProblem, ModallabError, split_remedy


class ServiceError(ModallabError):
    """The service rejects the request."""

    code = "service"
    http = HttpProblem(409, "The service rejects the request", "Read the message.")


class NotFoundError(ServiceError):
    """Not found."""

    code = "not-found"
    http = HttpProblem(404, "Not found", "Read the list of such objects.")


class ConflictError(ServiceError):
    """Not possible in the present state; `legal` lists possible states, if there are any."""

    code = "conflict"
    http = HttpProblem(409, "Not possible in the present state", "Read the message, and try again.")


class LeaseHeldError(ConflictError):
    """Another person, or another program of the same operator, holds the lease of the rig."""

    code = "lease-held"
    http = HttpProblem(
        409,
        "The rig is held",
        "Ask the holder to release the lease, or wait. If the holder is absent and no run is active, send "
        "`take_over`; for your own lease send `recover`. An emergency stop needs no lease.",
    )


class LeaseNeededError(ServiceError):
    """Commands to a rig need its lease; the lease in the request is missing, has ended, or belongs to another
    person."""

    code = "lease-needed"
    http = HttpProblem(
        403,
        "The rig's lease is needed",
        "Take the lease of the rig, renew it before it ends, and send its id as `Modallab-Lease`.",
    )


class RoleNeededError(ServiceError):
    """The role or the rigs of the token do not permit the request."""

    code = "role-needed"
    http = HttpProblem(
        403,
        "The token does not permit this",
        "Each route states its role; a token may be limited to some rigs. An admin can make another token.",
    )


class RigUnavailableError(ServiceError):
    """The rig's process has not opened its bench, or cannot open it."""

    code = "rig-unavailable"
    http = HttpProblem(
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
    http = HttpProblem(
        412, "The object was changed meanwhile", "Read the object again and send the new ETag as `If-Match`."
    )


class PreconditionNeededError(ServiceError):
    """A change must name the revision to change."""

    code = "precondition-needed"
    http = HttpProblem(428, "A change needs If-Match", "Send the ETag of the version that you read as `If-Match`.")


class IdempotencyError(ServiceError):
    """The idempotency key was used for another request."""

    code = "idempotency-key"
    http = HttpProblem(
        422, "The key was used for another request", "Make a new `Idempotency-Key` for every new request."
    )


class MediaTypeError(ServiceError):
    """The type of the body is not accepted."""

    code = "media-type"
    http = HttpProblem(
        415, "The body's type is not accepted", "Send JSON, with the header `Content-Type: application/json`."
    )


class RunEndedError(ServiceError):
    """The run was aborted or failed. Its acknowledged blocks are kept."""

    code = "run-ended"
