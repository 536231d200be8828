"""Every kind of problem the service answers with: its code, its status, and what it means."""

from dataclasses import dataclass

from modallab.acquisition.monitor.run_states import IllegalTransitionError
from modallab.acquisition.process.trip import TrippedError
from modallab.core.errors import (
    BenchError,
    DataError,
    DeviceBusyError,
    DiskFullError,
    FormatError,
    IdentificationError,
    JobError,
    ModallabError,
    PlanError,
    RigError,
    SafetyError,
    StorageError,
    UnknownJobError,
)
from modallab.service import errors as service


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of problem.

    Attributes:
        code: for programs; the page of the kind is /problems/<code>.
        status: of HTTP.
        title: in a few words.
        meaning: what it says and what to do.
    """

    code: str
    status: int
    title: str
    meaning: str


OF_REQUEST: tuple[Kind, ...] = (
    Kind(
        "not-valid",
        422,
        "The request is not valid",
        "A field is missing, unknown or out of range; `errors` names each.",
    ),
    Kind(
        "not-allowed",
        405,
        "This method does nothing here",
        "The header `Allow` names the methods there are.",
    ),
    Kind(
        "no-page",
        404,
        "There is nothing at this address",
        "Look at /openapi.json for the addresses there are.",
    ),
    Kind(
        "token-needed",
        401,
        "A token is needed",
        "Send the header `Authorization: Bearer TOKEN`, or log in at /api/v1/session. The token stands in "
        "the file the service named when it began.",
    ),
    Kind(
        "foreign-host",
        403,
        "The service is not known by this name",
        "The header `Host` names another host than those the service answers for; see the setting `hosts`.",
    ),
    Kind(
        "foreign-origin",
        403,
        "A page of another site sent this",
        "The header `Origin` is not this service's own.",
    ),
    Kind(
        "too-large",
        413,
        "The body is too large",
        "Send less; the limit is the setting `body_bytes`.",
    ),
    Kind(
        "unexpected",
        500,
        "The service failed",
        "An error nobody expected. It is in the log, under the number in `where`.",
    ),
)

OF_ERROR: dict[type[ModallabError], Kind] = {
    service.NotFoundError: Kind(
        "not-found",
        404,
        "There is no such thing",
        "Look at the list it would be in.",
    ),
    UnknownJobError: Kind(
        "job-unknown",
        404,
        "There is no such job",
        "Look at the list of jobs.",
    ),
    service.LeaseNeededError: Kind(
        "lease-needed",
        403,
        "The rig's lease is needed",
        "Take the lease of the rig, renew it before it is over, and send its id as `Modallab-Lease`.",
    ),
    service.LeaseHeldError: Kind(
        "lease-held",
        409,
        "Someone else holds the rig",
        "Ask the holder to give it back, or wait until it is over; if the holder is gone and no run is on, ask with "
        "`take_over`. An emergency stop needs no lease.",
    ),
    TrippedError: Kind(
        "tripped",
        409,
        "The rig is tripped",
        "It was stopped in an emergency. Look at the bench, then reset the rig.",
    ),
    IllegalTransitionError: Kind(
        "illegal-transition",
        409,
        "The run cannot do this now",
        "`legal` lists the states that may follow.",
    ),
    service.RigUnavailableError: Kind(
        "rig-unavailable",
        503,
        "The rig is not ready",
        "Its process has not opened the bench. Wait, or look at its cables and its address.",
    ),
    service.ConflictError: Kind(
        "conflict",
        409,
        "Not possible as things stand",
        "Look at what it says, and ask again.",
    ),
    service.ChangedError: Kind(
        "changed",
        412,
        "It was changed meanwhile",
        "Read it again and send the new ETag as `If-Match`.",
    ),
    service.PreconditionNeededError: Kind(
        "precondition-needed",
        428,
        "A change needs If-Match",
        "Send the ETag of what you read as `If-Match`.",
    ),
    service.IdempotencyError: Kind(
        "idempotency-key",
        422,
        "The key was used for another request",
        "Make a new `Idempotency-Key` for every new request.",
    ),
    service.ServiceError: Kind(
        "service",
        409,
        "The service cannot do this",
        "Look at what it says.",
    ),
    PlanError: Kind(
        "plan",
        422,
        "The plan is not possible",
        "The rig, its limits or the bench cannot do it; every reason is named.",
    ),
    RigError: Kind(
        "rig",
        422,
        "The rig lacks something",
        "Complete the rig file.",
    ),
    DataError: Kind(
        "data",
        422,
        "The data cannot be used",
        "They hold what no measurement can hold, or not what was asked for.",
    ),
    FormatError: Kind(
        "format",
        422,
        "A file cannot be read",
        "It is cut off, foreign, or of an unknown version.",
    ),
    IdentificationError: Kind(
        "identification",
        422,
        "No model in these data",
        "Look at the FRF and its coherence.",
    ),
    JobError: Kind(
        "job",
        422,
        "The job cannot be ordered",
        "Look at its parameters.",
    ),
    DiskFullError: Kind(
        "disk_full",
        507,
        "The disk is full",
        "Free space; what was acknowledged is kept.",
    ),
    StorageError: Kind(
        "storage",
        500,
        "The data folder cannot be read or written",
        "Look at the disk; what was acknowledged is kept.",
    ),
    DeviceBusyError: Kind(
        "bench-busy",
        409,
        "The device is held by another",
        "Close the other program.",
    ),
    SafetyError: Kind(
        "safety",
        409,
        "Beyond a limit",
        "A limit of the rig was or would have been exceeded; the output is at 0 V.",
    ),
    BenchError: Kind(
        "bench",
        503,
        "The bench failed",
        "A device failed, is absent, or rejected what was asked.",
    ),
    ModallabError: Kind(
        "error",
        500,
        "Not done",
        "Look at what it says.",
    ),
}

KINDS: dict[str, Kind] = {kind.code: kind for kind in (*OF_REQUEST, *OF_ERROR.values())}


def kind_of(error: ModallabError) -> Kind:
    """The kind of an error: that of the nearest class that has one."""
    return next(OF_ERROR[cls] for cls in type(error).__mro__ if cls in OF_ERROR)
