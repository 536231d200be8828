"""The parameters of a finite-element model, corrected by a campaign's newest model."""

from typing import TYPE_CHECKING

from modallab.core.documents.model_update import MatricesNew, PriorNew, UpdatedView, UpdateNew
from modallab.service.context import Service
from modallab.service.jobs.model_use import known_of_campaign

if TYPE_CHECKING:
    from modallab.formats.fem.matrix_model import MatrixModel
    from modallab.updating.prior import Prior


def updated_parameters(service: Service, campaign: str, new: UpdateNew) -> UpdatedView:
    """What a test says of the parameters of the rig's beam, or of matrices.

    Raises:
        NotFoundError: no such campaign, or no model of this test.
        DataError: no such parameter or mode, matrices that do not belong together, or a point without a node.
    """
    from modallab.pipelines.model_update import update_model
    from modallab.reporting.updated_table import updated_document

    known = known_of_campaign(service, campaign, new.test)
    own = {} if new.matrices is None else new.matrices.parameters
    priors = {name: _prior(prior) for name, prior in {**own, **new.priors}.items()}
    of = None if new.matrices is None else _matrices(new.matrices)
    return updated_document(update_model(known, of, priors, new.held_out))


def _prior(new: PriorNew) -> "Prior":
    from modallab.updating.prior import Prior

    return Prior(new.value, new.sigma, new.relative)


def _matrices(new: MatricesNew) -> "MatrixModel":
    from modallab.formats.fem.matrix_model import MatrixModel

    by = {
        kind: {name: m for name, p in new.parameters.items() if (m := getattr(p, kind)) is not None}
        for kind in ("stiffness", "mass")
    }
    return MatrixModel(new.stiffness, new.mass, new.freedoms, by["stiffness"], by["mass"], new.places, new.points)
