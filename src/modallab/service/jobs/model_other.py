"""A campaign's newest model beside another one, which it corrects, and the change that a wanted property needs."""

from math import isfinite
from typing import TYPE_CHECKING

from modallab.core.documents.model_other import (
    BestAbsorberNew,
    BestAbsorberView,
    ChangeForFreeBandNew,
    ChangeForFreeBandView,
    ChangeForFrequencyNew,
    ChangeForFrequencyView,
    ChangesForFreeBandView,
    ChangesForFrequencyView,
    CorrelationView,
    PairView,
)
from modallab.core.documents.model_update import MatricesNew, PriorNew, UpdatedView, UpdateNew
from modallab.core.units import Test
from modallab.service.context import Service
from modallab.service.jobs.model_use import known_of_campaign

if TYPE_CHECKING:
    from modallab.formats.fem.matrix_model import MatrixModel
    from modallab.updating.prior import Prior


def correlation_of(
    service: Service, campaign: str, test: Test | None, other: str, other_test: Test | None
) -> CorrelationView:
    """Which modes of two campaigns' models are the same.

    Raises:
        NotFoundError: no such campaign, or no model of this test.
        DataError: fewer than two common points, no driving point, or no two modes that are alike.
    """
    from modallab.updating.correlation import correlate_models

    one, two = known_of_campaign(service, campaign, test), known_of_campaign(service, other, other_test)
    found = correlate_models(one, two)
    pairs = (
        PairView(
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


def tunings_of(service: Service, campaign: str, new: ChangeForFrequencyNew) -> ChangesForFrequencyView:
    """What brings a mode to a frequency at each of several points.

    Raises:
        NotFoundError: no such campaign, or no model of this test.
        DataError: no such mode, a frequency beyond the band, or a point that the model does not know.
    """
    from modallab.modification.inverse import changes_for_frequency

    known = known_of_campaign(service, campaign, new.test)
    at = new.at or known.sensors
    answers = changes_for_frequency(known, new.mode, new.to_hz, new.by, at)
    return ChangesForFrequencyView(
        test=known.model.test,
        tunings=tuple(
            ChangeForFrequencyView(
                at=a.at[0] if isinstance(a.at, tuple) else a.at,
                size=a.size if a.feasible else None,
                sigma=a.sigma if a.feasible else None,
                hz_sigma=a.hz_sigma if a.feasible else None,
                lowest_hz=a.lowest_hz,
                highest_hz=a.highest_hz,
            )
            for a in answers
        ),
    )


def free_bands_of(service: Service, campaign: str, new: ChangeForFreeBandNew) -> ChangesForFreeBandView:
    """What leaves no mode in a band at each of several points.

    Raises:
        NotFoundError: no such campaign, or no model of this test.
        DataError: edges that do not rise or lie beyond the model's band, or a point that the model does not know.
    """
    from modallab.modification.free_band import changes_for_free_band

    known = known_of_campaign(service, campaign, new.test)
    answers = tuple(
        ChangeForFreeBandView(
            at=a.at[0] if isinstance(a.at, tuple) else a.at,
            size=a.size if a.feasible else None,
            sigma=a.sigma if a.feasible else None,
            up_to=a.up_to if isfinite(a.up_to) else None,
            stays=a.stays or None,
            stays_hz=a.stays_hz if a.stays else None,
        )
        for a in changes_for_free_band(known, (new.low_hz, new.high_hz), new.by, new.at or known.sensors)
    )
    return ChangesForFreeBandView(test=known.model.test, answers=answers)


def absorber_of(service: Service, campaign: str, new: BestAbsorberNew) -> BestAbsorberView:
    """The absorber that leaves the least peak about a mode.

    Raises:
        NotFoundError: no such campaign, or no model of this test.
        DataError: no such mode, or it has a node there.
    """
    from modallab.modification.inverse import best_absorber

    known = known_of_campaign(service, campaign, new.test)
    found = best_absorber(known, new.mode, new.at, new.mass_kg)
    return BestAbsorberView(
        test=known.model.test,
        at=new.at,
        mass_kg=found.absorber.mass,
        frequency_hz=found.absorber.frequency_hz,
        damping_ratio=found.absorber.damping_ratio,
        mass_ratio=found.mass_ratio,
        peak_before=found.before,
        peak_before_sigma=found.before_sigma,
        peak_after=found.after,
        peak_after_sigma=found.after_sigma,
    )


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
