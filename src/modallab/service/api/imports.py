"""Campaigns from files that others wrote: the body is the file."""

import hashlib
import shutil
import tempfile
from pathlib import Path
from typing import Annotated

from fastapi import Query, Request, Response
from fastapi.concurrency import run_in_threadpool

from modallab.core.documents.campaigns import CampaignNew, CampaignView, Name, Note
from modallab.core.errors import DataError
from modallab.core.units import Test
from modallab.formats.arrays.array_map import ArrayMap, parse_map
from modallab.formats.format import Format
from modallab.formats.options import ImportOptions
from modallab.service.api.problems import documented
from modallab.service.api.request_context import CallerOf, Operator, ServiceOf, mark
from modallab.service.api.rigs import state_of
from modallab.service.api.roles import require_rig
from modallab.service.api.router import ONCE, PREFIX, answer_once, make_router
from modallab.service.campaigns.importing import find_reader, import_campaign
from modallab.storage.durable import require_space
from modallab.storage.samples import RESERVE_BYTES

router = make_router("campaigns", files=True)
FILE = "application/octet-stream"
MAP_CHARACTERS = 4000
"""Of a map. It stands in the address, since the body is the file: many servers take no address above 8 kB."""
BODY = {"required": True, "content": {FILE: {"schema": {"type": "string", "format": "binary"}}}}


@router.post(
    "/imports",
    status_code=201,
    dependencies=ONCE,
    response_model=CampaignView,
    responses=documented(404, 409, 507),
    openapi_extra={"requestBody": BODY},
)
async def import_file(
    request: Request,
    service: ServiceOf,
    operator: Operator,
    caller: CallerOf,
    name: Annotated[Name, Query(description="Of the new campaign.")],
    rig: Annotated[str, Query(min_length=1, max_length=64)],
    format_: Annotated[str, Query(alias="format", max_length=16, description="Of the file: hdf5, uff, ...")] = "hdf5",
    note: Annotated[Note, Query(description="Of the new campaign.")] = "",
    test: Annotated[Test, Query(description="What the recordings are of, where the file does not say.")] = "impact",
    rate_hz: Annotated[
        float | None, Query(gt=0, allow_inf_nan=False, description="Where the file has no times.")
    ] = None,
    drive_point: Annotated[int | None, Query(ge=1, lt=2**31, description="Where the file does not say.")] = None,
    volts: Annotated[bool, Query(description="Whether numbers without a unit are volts.")] = False,
    map_: Annotated[
        str, Query(alias="map", max_length=MAP_CHARACTERS, description="Which array of the file is what: a map's YAML.")
    ] = "",
    columns: Annotated[
        str, Query(max_length=2000, description="Of a table, instead of its header: time,force:N,a01:m/s^2.")
    ] = "",
) -> Response:
    """Keep the recordings of a file as runs of a new campaign; it has a rig of its own, or is of the one that is named.

    The body is the file, as it is. What a run of this service has recorded and exported as HDF5 comes back to the bit.
    """
    require_rig(caller, rig)
    controller = await run_in_threadpool(state_of, service, rig)
    reader = find_reader(format_)
    array_map = _map(map_, reader)
    folder = Path(await run_in_threadpool(tempfile.mkdtemp, prefix="modallab-import-", dir=service.folder))
    try:
        file = folder / f"import{reader.endings[0]}"
        digest = await _receive(request, file)
        new = CampaignNew(name=name, rig=rig, note=note)
        options = ImportOptions(
            test=test, rate_hz=rate_hz, drive_point=drive_point, volts=volts, array_map=array_map, columns=columns
        )

        async def answer() -> Response:
            made = await run_in_threadpool(import_campaign, service, file, new, controller.rig, options, operator)
            response = Response(made.model_dump_json(), 201, media_type="application/json")
            response.headers["Location"] = f"{PREFIX}/campaigns/{made.id}"
            mark(response, made.revision)
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
