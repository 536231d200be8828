"""Rigs as the service shows them: what stands there, who holds it, whether it may move."""

from typing import Annotated, Literal

from pydantic import Field

from modallab.core.frozen import Frozen, Truth
from modallab.core.rig import Rig

RigState = Literal["starting", "idle", "running", "unavailable"]

Operator = Annotated[str, Field(min_length=1, max_length=80, pattern=r"^[^\x00-\x1f\x7f]+$")]
"""Name of a person, as it stands in the record of who did what."""


class Trip(Frozen):
    """Why nothing may be driven until someone resets the rig.

    Attributes:
        cause: emergency stop, death, time-out.
        reason: in words.
        utc: when, for people.
    """

    cause: str
    reason: str
    utc: str


class LeaseHolder(Frozen):
    """Who may command the rig, and for how long without renewal.

    Attributes:
        operator: who holds it.
        fence: grows with every holder.
        remaining_s: until it ends, if it is not renewed.
    """

    operator: str
    fence: int
    remaining_s: float


class RigView(Frozen):
    """One rig of this service.

    Attributes:
        id: made by the service from the rig's name.
        name: from the rig file.
        bench: address of the bench.
        rig_hash: SHA-256 of the rig's JSON.
        state: of its process.
        can_drive: whether the bench has an excitation output; None until it is open.
        run: the active run.
        trip: None if it may be driven.
        lease: None if nobody holds it.
        error: why it is unavailable.
    """

    id: str
    name: str
    bench: str
    rig_hash: str
    state: RigState
    can_drive: bool | None = None
    run: str | None = None
    trip: Trip | None = None
    lease: LeaseHolder | None = None
    error: str = ""


class RigRevision(Frozen):
    """What a rig was believed to be from some time on.

    Attributes:
        number: from 1.
        rig_hash: SHA-256 of the description's JSON, as every run on it carries it.
        reason: why it was revised.
        operator: who revised it; "" where it came with the rig file.
        utc: since when.
    """

    number: int
    rig_hash: str
    reason: str
    operator: str
    utc: str


class RigRevisionNew(Frozen):
    """Another description of what stands on the bench.

    Attributes:
        description: all of it, under the name that the rig has.
        reason: kept in the record of who did what.
    """

    description: Rig
    reason: Annotated[str, Field(max_length=400)] = ""


class LeaseNew(Frozen):
    """Ask for the right to command a rig; renew it before `ttl_s` is over.

    With `take_over` it is taken from whoever holds it, as long as no run is on: for when the holder's program is gone.
    Who holds it takes it over also while a run is on, from another place; with `recover` the same lease is given once
    more, for a page that was loaded again.

    Attributes:
        operator: who asks, where the service's own token does not say it; with a user's token it is that user.
        ttl_s: for so long, unless it is renewed.
        take_over: take it from whoever holds it.
        recover: give back the lease that is held under the same name.
    """

    operator: Operator | None = None
    ttl_s: Annotated[float, Field(ge=1, le=3600)] = 60.0
    take_over: Truth = False
    recover: Truth = False


class Lease(Frozen):
    """The right to command a rig. Send `id` as the header `Modallab-Lease`; `fence` grows with every holder.

    Attributes:
        id: send it as the header `Modallab-Lease`.
        rig: id of the rig.
        operator: who holds it.
        fence: grows with every holder.
        ttl_s: until it ends, if it is not renewed.
    """

    id: str
    rig: str
    operator: str
    fence: int
    ttl_s: float


class StopReason(Frozen):
    """Why someone stops or resets a rig.

    Attributes:
        reason: kept in the record of who did what.
    """

    reason: Annotated[str, Field(max_length=400)] = ""


class StopAsked(Frozen):
    """An emergency stop, sent as JSON over the WebSocket of live samples or their envelope.

    Attributes:
        kind: of the message.
        rig: the rig's id.
        operator: who asks, where the token does not say it.
        reason: why.
    """

    kind: Literal["emergency_stop"] = "emergency_stop"
    rig: str
    operator: Operator = "unknown"
    reason: Annotated[str, Field(max_length=400)] = ""


class DeviceView(Frozen):
    """A device that was found, and the address to open it by.

    Attributes:
        address: to open it by, as in a rig file.
        what: it is.
    """

    address: str
    what: str
