"""Campaigns from files that others wrote: the body is the file."""

import hashlib
import inspect
import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from fastapi import Depends, Query, Request, Response
from fastapi.concurrency import run_in_threadpool
from pydantic import Field, StringConstraints

from modallab.core.documents.runs import CampaignRequest, CampaignView, Name, Note
from modallab.core.errors import DataError
from modallab.core.events import StateChanged
from modallab.core.rig import Rig
from modallab.core.units import Test
from modallab.formats.arrays.array_map import ArrayMap, parse_map
from modallab.formats.asked import ASKED, ImportOption, Kind
from modallab.formats.format import Format, readers
from modallab.service.api.access import require_rig
from modallab.service.api.problems import documented_responses
from modallab.service.api.request_context import CallerOf, Operator, ServiceOf, set_etag
from modallab.service.api.rigs import process_state
from modallab.service.api.router import ONCE, PREFIX, answer_once, make_router
from modallab.service.context import Service
from modallab.service.records.event_log import EventTopic
from modallab.service.records.repository import RunEntry
from modallab.storage.durable import require_space
from modallab.storage.samples import RESERVE_BYTES

router = make_router("campaigns", files=True)
FILE = "application/octet-stream"
MAP_CHARACTERS = 4000
"""Of a map. It stands in the address, since the body is the file: many servers take no address above 8 kB."""
_KINDS: dict[Kind, Any] = {
    "text": Annotated[str, StringConstraints(min_length=1, max_length=2000)],
    "number": Annotated[float, Field(gt=0, allow_inf_nan=False)],
    "count": Annotated[int, Field(ge=1, lt=2**31)],
    "switch": bool,
    "test": Test,
    "map": Annotated[str, StringConstraints(max_length=MAP_CHARACTERS)],
}
BODY = {"required": True, "content": {FILE: {"schema": {"type": "string", "format": "binary"}}}}


def _parameter(name: str, one: ImportOption) -> inspect.Parameter:
    kind = list[_KINDS[one.kind]] if one.several else _KINDS[one.kind]
    # Numbers keep the name that says their unit.
    called = one.called if one.called and one.kind not in ("number", "count") else name
    query = Query(alias=called, description=f"{one.about[0].upper()}{one.about[1:]}.")
    return inspect.Parameter(
        name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=Annotated[kind | None, query]
    )


class _OfQuery:
    """What is said of the file, by field of `ASKED`, or None. FastAPI asks for what the signature holds."""

    __signature__ = inspect.Signature([_parameter(name, one) for name, one in ASKED.items() if not one.frfs])

    def __call__(self, **given: object) -> dict[str, Any]:
        return given


@router.post(
    "/imports",
    status_code=201,
    dependencies=ONCE,
    response_model=CampaignView,
    responses=documented_responses(404, 409, 507),
    openapi_extra={"requestBody": BODY},
)
async def import_file(
    request: Request,
    service: ServiceOf,
    operator: Operator,
    caller: CallerOf,
    name: Annotated[Name, Query(description="Text for the new campaign.")],
    rig: Annotated[str, Query(min_length=1, max_length=64)],
    said: Annotated[dict[str, Any], Depends(_OfQuery())],
    format_: Annotated[
        str, Query(alias="format", max_length=16, description="Format of the file: hdf5, uff, ...")
    ] = "hdf5",
    note: Annotated[Note, Query(description="Text for the new campaign.")] = "",
) -> Response:
    """Keep the recordings of a file as runs of a new campaign; it has a rig of its own, or is of the one that is named.

    The body is the file, as it is. What a run of this service has recorded and exported as HDF5 comes back to the bit.
    """
    require_rig(caller, rig)
    controller = await run_in_threadpool(process_state, service, rig)
    reader = _find_reader(format_)
    said["array_map"] = _map(said.get("array_map") or "", reader)
    folder = Path(await run_in_threadpool(tempfile.mkdtemp, prefix="modallab-import-", dir=service.folder))
    try:
        file = folder / f"import{reader.endings[0]}"
        digest = await _receive(request, file)
        new = CampaignRequest(name=name, rig=rig, note=note)

        async def answer() -> Response:
            made = await run_in_threadpool(_import_campaign, service, file, new, controller.rig, said, operator)
            response = Response(made.model_dump_json(), 201, media_type="application/json")
            response.headers["Location"] = f"{PREFIX}/campaigns/{made.id}"
            set_etag(response, made.revision)
            return response

        return await answer_once(request, request.url.query.encode() + b"\0" + digest, answer)
    finally:
        await run_in_threadpool(shutil.rmtree, folder, ignore_errors=True)


def _map(text: str, reader: Format) -> ArrayMap | None:
    if not text:
        return None
    if "array_map" not in reader.asks:
        raise DataError(f"a file of the format {reader.name} needs no map", where="query, map", remedy="leave it out")
    return parse_map(text, "query, map")


async def _receive(request: Request, file: Path) -> bytes:
    """Keep the body as a file; the SHA-256 of it."""
    require_space(file.parent, 2 * RESERVE_BYTES + int(request.headers.get("content-length", "0") or 0))
    received, digest = 0, hashlib.sha256()
    with file.open("wb") as kept:
        async for piece in request.stream():
            received += len(piece)
            digest.update(piece)
            await run_in_threadpool(kept.write, piece)
    if not received:
        raise DataError("the body is empty", where="body", remedy="send the file as the body")
    return digest.digest()


def _find_reader(name: str) -> Format:
    """The format of this name.

    Raises:
        DataError: there is none, or it is only written; names those that are read.
    """
    found = {known.name: known for known in readers()}
    if name not in found:
        raise DataError(f"{name!r} is no format to read", remedy=f"name one of {', '.join(found)}")
    return found[name]


def _import_campaign(
    service: Service, file: Path, new: CampaignRequest, rig: Rig, said: Mapping[str, Any], operator: str
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
