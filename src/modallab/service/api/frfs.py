"""FRF and coherence of a run as far as it has come."""

from fastapi import Response

from modallab.core.documents.results import FrfView
from modallab.core.frf import UNIT
from modallab.service.api.etag import IfNoneMatch, mark, unchanged
from modallab.service.api.problems import documented
from modallab.service.api.request_context import ServiceOf
from modallab.service.api.router import make_router
from modallab.service.campaigns.runs import block_records

router = make_router("frf")


@router.get(
    "/runs/{run}/frf", response_model=FrfView, responses={304: {"description": "unchanged"}} | documented(404, 409)
)
def get_frf(run: str, service: ServiceOf, response: Response, if_none_match: IfNoneMatch = None) -> FrfView | Response:
    """Mobility (H1) and coherence of the blocks that count now; the ETag changes with every one of them."""
    counted = [row.n for row in block_records(service, run) if row.note.accepted]
    tag = f"{len(counted)}-{hash(tuple(counted)) & 0xFFFFFFFF:08x}"
    if unchanged(if_none_match, tag):
        return Response(status_code=304, headers={"ETag": f'"{tag}"'})
    # Imported here, since it takes seconds: the service can be asked everything else meanwhile.
    from modallab.service.campaigns.live_frf import live_frf

    frf = live_frf(service.store, run)
    mark(response, tag)
    return FrfView(
        run=run,
        quantity=frf.quantity,
        unit=UNIT[frf.quantity],
        frequency_hz=frf.frequency_hz,
        values=frf.values,
        coherence=frf.coherence,
        outputs=frf.outputs,
        output_points=frf.output_points,
        input_points=frf.input_points,
        averages=frf.averages,
    )
