"""What the service rejects, besides what the stages below reject."""

from modallab.core.errors import ModallabError


class ServiceError(ModallabError):
    """The service cannot do this now, or not in this way."""

    code = "service"


class NotFoundError(ServiceError):
    """There is no such thing."""

    code = "not-found"


class ConflictError(ServiceError):
    """Not possible as things stand; `legal` says what is, where that is a list."""

    code = "conflict"


class LeaseHeldError(ConflictError):
    """Someone else holds the rig."""

    code = "lease-held"


class LeaseNeededError(ServiceError):
    """Commanding a rig needs its lease, and the one that was sent is none, over, or someone else's by now."""

    code = "lease-needed"


class RigUnavailableError(ServiceError):
    """The rig's process has not opened its bench, or cannot."""

    code = "rig-unavailable"


class ChangedError(ServiceError):
    """The document was changed since it was read."""

    code = "changed"


class PreconditionNeededError(ServiceError):
    """A change must say which revision it changes."""

    code = "precondition-needed"


class IdempotencyError(ServiceError):
    """The idempotency key was used for another request."""

    code = "idempotency-key"


class RunEndedError(ServiceError):
    """The run was stopped short: aborted, or failed. What it had acknowledged is kept."""

    code = "run-ended"
