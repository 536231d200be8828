"""A campaign from a file of a format that others write."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from modallab.core.documents.campaigns import CampaignNew, CampaignView
from modallab.core.errors import DataError
from modallab.core.events import StateChanged
from modallab.core.rig import Rig
from modallab.formats.format import Format, readers
from modallab.service.context import Service
from modallab.service.records.event_log import EventTopic
from modallab.service.records.repository import RunEntry


def find_reader(name: str) -> Format:
    """The format of this name.

    Raises:
        DataError: there is none, or it is only written; names those that are read.
    """
    found = {known.name: known for known in readers()}
    if name not in found:
        raise DataError(f"{name!r} is no format to read", remedy=f"name one of {', '.join(found)}")
    return found[name]


def import_campaign(
    service: Service, file: Path, new: CampaignNew, rig: Rig, said: Mapping[str, Any], operator: str
) -> CampaignView:
    """Keep the recordings of a file as runs of a new campaign.

    Args:
        service: that keeps them.
        file: in any format that can be read.
        new: the campaign.
        rig: they were made on; a file that holds a rig of its own keeps that.
        said: what the file does not say itself, by field of `ASKED`.
        operator: who imports it.

    Raises:
        FormatError, DataError: the file cannot be read, or holds no records.
        StorageError, DiskFullError: they cannot be kept.
    """
    # Imported here: it takes seconds, and the service can be asked everything else meanwhile.
    from modallab.formats.importer import import_recordings
    from modallab.storage.imported import keep_campaign

    found = import_recordings([file], _own_rig(file) or rig, said)
    if not found.blocks:
        raise DataError(f"{file.name} holds no time records", remedy="import FRFs with modallab import and identify")
    runs = keep_campaign(service.store, found, f"file://{file.name}")
    campaign = service.repository.create(new, operator)
    for run in runs:
        record = service.store.catalogue.run(run)
        entry = RunEntry(run, campaign.id, new.rig, operator, None)
        service.repository.add_run(entry, record.plan.model_dump(mode="json"))
        changed = StateChanged(run=run, state=record.state, reason=record.reason)
        service.log.append(changed.kind, EventTopic(new.rig, campaign.id, run), changed.model_dump())
    return service.repository.campaign(campaign.id)


def _own_rig(file: Path) -> Rig | None:
    from modallab.formats.campaign.hdf5_access import is_hdf5, open_hdf5
    from modallab.formats.campaign.hdf5_version_2 import read_rig_text
    from modallab.formats.rig.rig_file import parse_rig

    with file.open("rb") as content:
        if not is_hdf5(content.read(4096)):
            return None
    with open_hdf5(file) as source:
        text = read_rig_text(source, file.name)
    return parse_rig(text, f"{file.name}, rig") if text else None
