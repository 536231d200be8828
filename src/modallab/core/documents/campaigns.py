"""Campaigns: one session at a bench, its runs and what became of them."""

from typing import Annotated

from pydantic import Field

from modallab.core.frozen import Frozen

Name = Annotated[str, Field(min_length=1, max_length=120, pattern=r"^[^\x00-\x1f\x7f]+$")]
Note = Annotated[str, Field(max_length=4000)]


class CampaignNew(Frozen):
    """A new campaign on a rig of this service.

    Attributes:
        name: for people; need not be unique.
        rig: id of the rig.
        note: for people.
    """

    name: Name
    rig: Annotated[str, Field(min_length=1, max_length=64)]
    note: Note = ""


class CampaignChange(Frozen):
    """What may be changed afterwards; what is left out stays.

    Attributes:
        name: the new one; None: as it was.
        note: the new one; None: as it was.
    """

    name: Name | None = None
    note: Note | None = None


class CampaignView(Frozen):
    """A campaign.

    Attributes:
        id: made by the service.
        name: for people.
        note: for people.
        rig: id of the rig it is on.
        operator: who made it.
        created_utc: when.
        revision: its ETag; grows with every change.
        runs: names of its runs, the oldest first, without those that are archived or deleted.
        archived_utc: when it was archived; "" if it is not.
        deleted_utc: when it was deleted; "" if it is not.
        purge_utc: until when it can be restored; from then on its samples are deleted.
    """

    id: str
    name: str
    note: str
    rig: str
    operator: str
    created_utc: str
    revision: int
    runs: tuple[str, ...] = ()
    archived_utc: str = ""
    deleted_utc: str = ""
    purge_utc: str = ""
