"""Blocks of a run: what is kept, whether it counts, its samples and its force."""

from typing import Annotated

import numpy as np
from fastapi import Body, Response
from fastapi.openapi.models import Example

from modallab.core.documents.pages import Page
from modallab.core.documents.runs import BlockForce, BlockVerdict, BlockView
from modallab.service.api.problems import documented_responses
from modallab.service.api.request_context import (
    Cursor,
    LeaseId,
    Limit,
    Operator,
    ServiceOf,
    page_cursor_number,
    page_of_items,
)
from modallab.service.api.router import make_router
from modallab.service.campaigns.runs import (
    block_record,
    block_records,
    block_view,
    judge_block,
    read_samples,
    record_of,
)
from modallab.service.context import Service

router = make_router("blocks")
Judgement = Annotated[
    BlockVerdict, Body(openapi_examples={"reject": Example(value={"accepted": False, "reason": "someone walked by"})})
]
SAMPLES = "application/octet-stream"
SAMPLE_HEADERS = DTYPE, SHAPE, CRC32 = "Modallab-Dtype", "Modallab-Shape", "Modallab-Crc32"


@router.get("/runs/{run}/blocks", responses=documented_responses(404))
def list_blocks(run: str, service: ServiceOf, limit: Limit = 100, cursor: Cursor = None) -> Page[BlockView]:
    """The blocks of a run in the order of time, including rejected ones."""
    after = page_cursor_number(cursor)
    rows = [row for row in block_records(service, run) if after is None or row.n > after]
    return page_of_items([block_view(row) for row in rows[: limit + 1]], limit, lambda block: block.n)


@router.get("/runs/{run}/blocks/{n}", responses=documented_responses(404))
def get_block(run: str, n: int, service: ServiceOf) -> BlockView:
    """One block."""
    return block_view(block_record(service, run, n))


@router.get(
    "/runs/{run}/blocks/{n}/samples",
    response_class=Response,
    responses={200: {"content": {SAMPLES: {"schema": {"type": "string", "format": "binary"}}}}}
    | documented_responses(404),
)
def get_samples(run: str, n: int, service: ServiceOf) -> Response:
    """The samples as the device delivered them: (channels, count), C order, little-endian, with the CRC-32 of these
    bytes."""
    block = block_record(service, run, n)
    samples = read_samples(service, block)
    headers = {
        DTYPE: samples.dtype.str,
        SHAPE: f"{samples.shape[0]},{samples.shape[1]}",
        CRC32: str(block.crc32),
        "ETag": f'"{block.crc32:08x}"',
    }
    return Response(samples.tobytes(), media_type=SAMPLES, headers=headers)


@router.put("/runs/{run}/blocks/{n}/verdict", responses=documented_responses(404, 409, 507))
def put_verdict(
    run: str, n: int, verdict: Judgement, service: ServiceOf, operator: Operator, lease: LeaseId = None
) -> BlockView:
    """Accept or reject a block. Later results use the verdict.

    While the run goes on it needs its rig's lease, and is the same as the commands `accept` and `drop`: a verdict can
    be taken back until the hit was struck again.
    """
    judge_block(service, run, n, verdict, lease, operator)
    return block_view(block_record(service, run, n))


@router.get("/runs/{run}/blocks/{n}/force", responses=documented_responses(404))
def get_force(run: str, n: int, service: ServiceOf) -> BlockForce:
    """The force of a block in N, and its amplitude spectrum."""
    return _force(service, run, n)


def _force(service: Service, run: str, n: int) -> BlockForce:
    # Imported here: it takes seconds, and the service can be asked everything else meanwhile.
    from modallab.signals.signals import to_signals

    record = record_of(service, run)
    block = service.store.block(run, block_record(service, run, n).note.name)
    signals = to_signals(block, record.rig)
    force = signals.force - np.median(signals.force)
    return BlockForce(
        run=run,
        n=n,
        rate_hz=signals.rate_hz,
        force_n=force,
        spectrum_hz=np.arange(force.size // 2 + 1) * signals.rate_hz / force.size,
        spectrum_n_s=np.abs(np.fft.rfft(force)) / signals.rate_hz,
    )
