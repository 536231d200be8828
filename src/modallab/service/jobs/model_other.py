"""The newest model of a campaign beside that of another, and the change that a wanted property needs."""

from math import isfinite

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
from modallab.core.units import Test
from modallab.service.context import Service
from modallab.service.jobs.model_use import known_of_campaign


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
