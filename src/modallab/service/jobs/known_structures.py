"""The newest models of campaigns, ready for use. What that needs takes seconds to import: not before it is used."""

from typing import TYPE_CHECKING

from modallab.core.documents.models import TestModel
from modallab.core.units import Test
from modallab.service.context import Service
from modallab.service.errors import NotFoundError
from modallab.service.jobs.results import models_of_campaign

if TYPE_CHECKING:
    from modallab.modification.known import KnownStructure

KEPT = 8
"""Models that stay ready for use: their samples take longer than what is asked of them."""
_READY: dict[tuple[str, Test | None, tuple[str, ...]], "KnownStructure"] = {}


def known_of_campaign(service: Service, campaign: str, test: Test | None) -> "KnownStructure":
    """The newest model of a test, ready for use; of the first test if none is named.

    Raises:
        NotFoundError: no such campaign, or no model of this test.
        DataError: no driving point, or a point that is not known.
    """
    from modallab.modification.known import KnownStructure

    found = model_of_campaign(service, campaign, test)
    key = (found.job, found.model.test, found.runs)
    if key in _READY:
        return _READY[key]
    known = KnownStructure(found.model, service.store.catalogue.run(found.runs[0]).rig)
    while len(_READY) >= KEPT:
        _READY.pop(next(iter(_READY)))
    return _READY.setdefault(key, known)


def model_of_campaign(service: Service, campaign: str, test: Test | None) -> TestModel:
    """The newest model of a test; of the first test if none is named.

    Raises:
        NotFoundError: no such campaign, or no model of this test.
    """
    there = models_of_campaign(service, campaign).models
    for one in there:
        if test in (None, one.model.test):
            return one
    raise NotFoundError(
        f"campaign {campaign} has no model of {'any' if test is None else 'the ' + test} test",
        where="test",
        remedy=f"there are: {', '.join(str(one.model.test) for one in there) or 'none'}",
    )
