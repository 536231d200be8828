"""Rigs as the service shows them: what stands there, who holds it, whether it may move."""

from typing import Annotated, Literal

from pydantic import Field

from modallab.core.frozen import Frozen, Truth
from modallab.core.rig import Rig

RigState = Literal["starting", "idle", "running", "unavailable"]

Operator = Annotated[str, Field(min_length=1, max_length=80, pattern=r"^[^\x00-\x1f\x7f]+$")]
"""Name of a person, as it stands in the record of who did what."""


class TripReason(Frozen):
    """Reason why a rig must not be driven until it is reset.

    Attributes:
        cause: emergency stop, death, time-out.
        reason: in words.
        utc: date and time.
    """

    cause: str
    reason: str
    utc: str


class LeaseHolder(Frozen):
    """The holder of a rig's lease, and its remaining time.

    Attributes:
        operator: name of the holder.
        fence: number that grows with every holder.
        remaining_s: until it ends, if it is not renewed.
    """

    operator: str
    fence: int
    remaining_s: float


class RigView(Frozen):
    """One rig of this service.

    Attributes:
        id: id, made by the service from the rig's name.
        name: name in the rig file.
        bench: address of the bench.
        rig_hash: SHA-256 of the rig's JSON.
        state: state of the rig's process.
        can_drive: whether the bench has an excitation output; None until it is open.
        run: name of the active run.
        trip: trip of the rig; None if it may be driven.
        lease: lease of the rig; None if it is free.
        error: reason if the rig is unavailable.
    """

    id: str
    name: str
    bench: str
    rig_hash: str
    state: RigState
    can_drive: bool | None = None
    run: str | None = None
    trip: TripReason | None = None
    lease: LeaseHolder | None = None
    error: str = ""


class RigRevision(Frozen):
    """A description of a rig with its start of validity.

    Attributes:
        number: from 1.
        rig_hash: SHA-256 of the description's JSON, as in every run.
        reason: reason of the revision.
        operator: name of the operator; "" for the rig file.
        utc: start of validity.
    """

    number: int
    rig_hash: str
    reason: str
    operator: str
    utc: str


class RigRevisionRequest(Frozen):
    """Request for another description of the bench.

    Attributes:
        description: complete description, with the rig's name.
        reason: reason for the audit record.
    """

    description: Rig
    reason: Annotated[str, Field(max_length=400)] = ""


class LeaseRequest(Frozen):
    """Request for the right to command a rig; renew it within `ttl_s`.

    `take_over` takes the lease from its holder while no run is active, for instance if the holder's program has ended.
    The holder may use it from another place also during a run. `recover` returns the same lease again, for a reloaded
    page.

    Attributes:
        operator: name of the operator, with the service's own token; a user's token implies the name.
        ttl_s: duration without renewal.
        take_over: take the lease from its holder.
        recover: return the lease that is held under the same name.
    """

    operator: Operator | None = None
    ttl_s: Annotated[float, Field(ge=1, le=3600)] = 60.0
    take_over: Truth = False
    recover: Truth = False


class Lease(Frozen):
    """The right to command a rig. Send `id` as the header `Modallab-Lease`.

    Attributes:
        id: value of the header `Modallab-Lease`.
        rig: id of the rig.
        operator: name of the holder.
        fence: number that grows with every holder.
        ttl_s: duration without renewal.
    """

    id: str
    rig: str
    operator: str
    fence: int
    ttl_s: float


class StopReason(Frozen):
    """Reason for a stop or reset of a rig.

    Attributes:
        reason: reason for the audit record.
    """

    reason: Annotated[str, Field(max_length=400)] = ""


class StopRequest(Frozen):
    """An emergency stop, sent as JSON over the WebSocket of live samples or their envelope.

    Attributes:
        kind: of the message.
        rig: the rig's id.
        operator: who asks, where the token does not say it.
        reason: reason.
    """

    kind: Literal["emergency_stop"] = "emergency_stop"
    rig: str
    operator: Operator = "unknown"
    reason: Annotated[str, Field(max_length=400)] = ""


class DeviceView(Frozen):
    """A device that was found, with its address.

    Attributes:
        address: address of the device, as in a rig file.
        what: kind of device.
    """

    address: str
    what: str
