"""What the gap behaves like if it is in the structure: a force at one place, or one all along the beam."""

from collections.abc import Iterator

from modallab.core.effect import AllAlongBeam, AllChannels
from modallab.gap.model.fit import Fit
from modallab.gap.search.fitting import Bench
from modallab.gap.unknown.fitted import ElementTrial, element
from modallab.gap.unknown.law import PointLawFit, laws
from modallab.gap.unknown.missing_force import PLACES, MissingForce
from modallab.gap.unknown.spare_poles import trials_at_spare_poles

EACH = 2
"""Places at which the same terms are begun from."""
MOST = 6
"""Laws at a place that are fitted in short."""
LEAST = 3
"""Places at which the force leaves least, whatever its law."""
ALONG = (("tension",), ("bedding",), ("tension", "bedding"))
"""Terms of a force all along the beam that are tried together."""
WHOLE = (("gain",), ("delay",), ("low_pass_hz",), ("high_pass_hz",), ("gain", "delay"))
"""The same of an operator on all channels."""


def trials_on_beam(bench: Bench, base: Fit) -> Iterator[ElementTrial]:
    """The elements worth a fit, each with places to begin from."""
    for law in _likely(bench, base):
        names = tuple(law.numbers)
        yield ElementTrial(element(bench, "point_law", (*names, "x")), ((*law.numbers.values(), law.x),))
    yield from trials_at_spare_poles(bench, base)
    yield from forces_along_beam(bench)


def forces_along_beam(bench: Bench) -> Iterator[ElementTrial]:
    """Forces all along the beam."""
    for names in ALONG:
        yield ElementTrial(element(bench, "beam_law", names, AllAlongBeam(), 1 / len(names)))


def operators_on_all_channels(bench: Bench) -> Iterator[ElementTrial]:
    """Operators that act on all accelerometers alike."""
    for names in WHOLE:
        yield ElementTrial(element(bench, "row_filter", names, AllChannels()))


def _likely(bench: Bench, base: Fit) -> list[PointLawFit]:
    """The likeliest laws of a missing force at no more than a few places each, and those where any force leaves least.

    Near the root a force is known so badly that any law describes it: its place must be looked at by itself.
    """
    if not bench.data.impacts:
        return []
    estimator = MissingForce(base, bench.data)
    places = [(missing.left, laws(missing)) for missing in map(estimator.at, PLACES)]
    by_terms: dict[tuple[str, ...], list[PointLawFit]] = {}
    for law in sorted((law for _, found in places for law in found), key=_price):
        by_terms.setdefault(tuple(law.numbers), []).append(law)
    likely = sorted((law for some in by_terms.values() for law in some[:EACH]), key=_price)[:MOST]
    least = sorted(places, key=lambda place: place[0])[:LEAST]
    return list({id(law): law for law in (*likely, *(law for _, found in least for law in found[:EACH]))}.values())


def _price(law: PointLawFit) -> float:
    return law.price
