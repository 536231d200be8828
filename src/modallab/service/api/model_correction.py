"""A campaign's newest model beside that of another, and a finite-element model that it corrects."""

from typing import TYPE_CHECKING, Annotated

from fastapi import Body, Query

from modallab.core.documents.model_targets import (
    CorrelationView,
    ModePairView,
)
from modallab.core.documents.model_update import MatricesRequest, PriorRequest, UpdatedModelView, UpdateRequest
from modallab.core.units import Test
from modallab.service.api.access import role_needed
from modallab.service.api.problems import documented_responses
from modallab.service.api.request_context import OfTest, ServiceOf
from modallab.service.api.router import make_router
from modallab.service.jobs.results import known_of_campaign

if TYPE_CHECKING:
    from modallab.formats.fem.matrix_model import MatrixModel
    from modallab.updating.result import Prior

router = make_router("model-use")


@router.get("/campaigns/{campaign}/model/correlation", responses=documented_responses(404))
def get_correlation(
    campaign: str,
    other: Annotated[str, Query(description="Campaign of the other model.")],
    service: ServiceOf,
    test: OfTest = None,
    other_test: Annotated[Test | None, Query(description="Test of the other campaign (default: the first).")] = None,
) -> CorrelationView:
    """Pairs of modes of two campaigns' models: MAC, frequencies, damping, COMAC."""
    from modallab.updating.correlation import correlate_models

    one, two = known_of_campaign(service, campaign, test), known_of_campaign(service, other, other_test)
    found = correlate_models(one, two)
    pairs = (
        ModePairView(
            mode=i + 1,
            other=j + 1,
            mac=float(found.mac[i, j]),
            frequency_hz=found.frequency_hz[n],
            frequency_sigma_hz=found.frequency_sigma_hz[n],
            damping_ratio=found.damping_ratio[n],
        )
        for n, (i, j) in enumerate(found.pairs)
    )
    return CorrelationView(
        test=one.model.test,
        other_test=two.model.test,
        points=tuple(point for point, _ in found.freedoms),
        axes=tuple(axis for _, axis in found.freedoms),
        pairs=tuple(pairs),
        mac=found.mac,
        comac=found.comac,
    )


@router.post(
    "/campaigns/{campaign}/model/updates", responses=documented_responses(404), openapi_extra=role_needed("observer")
)
def update_finite_elements(
    campaign: str, new: Annotated[UpdateRequest, Body()], service: ServiceOf
) -> UpdatedModelView:
    """Estimate the parameters of a finite-element model, or of the rig file's beam; nothing is stored."""
    from modallab.pipelines.model_update import update_model
    from modallab.reporting.modification_table import updated_document

    known = known_of_campaign(service, campaign, new.test)
    own = {} if new.matrices is None else new.matrices.parameters
    priors = {name: _prior(prior) for name, prior in {**own, **new.priors}.items()}
    of = None if new.matrices is None else _matrices(new.matrices)
    return updated_document(update_model(known, of, priors, new.held_out))


def _prior(new: PriorRequest) -> "Prior":
    from modallab.updating.result import Prior

    return Prior(new.value, new.sigma, new.relative)


def _matrices(new: MatricesRequest) -> "MatrixModel":
    from modallab.formats.fem.matrix_model import MatrixModel

    by = {
        kind: {name: m for name, p in new.parameters.items() if (m := getattr(p, kind)) is not None}
        for kind in ("stiffness", "mass")
    }
    return MatrixModel(new.stiffness, new.mass, new.freedoms, by["stiffness"], by["mass"], new.places, new.points)
