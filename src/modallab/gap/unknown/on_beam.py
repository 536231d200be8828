"""What the gap behaves like if it is in the structure: a force at one place, or one all along the beam."""

from collections.abc import Iterator

from modallab.gap.model.fit import Fit
from modallab.gap.search.fitting import Bench
from modallab.gap.unknown.fitted import Trial, element
from modallab.gap.unknown.law import Law, laws
from modallab.gap.unknown.missing_force import PLACES, MissingForce

EACH = 2
"""Places at which the same terms are begun from."""
MOST = 6
"""Laws at a place that are fitted in short."""
ALONG = (("tension",), ("bedding",), ("tension", "bedding"))
"""Terms of a force all along the beam that are tried together."""
WHOLE = (("gain",), ("delay",), ("low_pass_hz",), ("high_pass_hz",), ("gain", "delay"))
"""The same of an operator on all channels."""


def trials(bench: Bench, base: Fit) -> Iterator[Trial]:
    """The elements worth a fit, each with places to begin from."""
    for law in _likely(bench, base):
        names = tuple(law.numbers)
        yield Trial(element(bench, "point_law", (*names, "x")), ((*law.numbers.values(), law.x),))
    for names in ALONG:
        yield Trial(element(bench, "beam_law", names, (("x", "all"),), 1 / len(names)))


def on_all_rows(bench: Bench) -> Iterator[Trial]:
    """Operators that act on all accelerometers alike."""
    for names in WHOLE:
        yield Trial(element(bench, "row_filter", names, (("channel", "all"),)))


def _likely(bench: Bench, base: Fit) -> list[Law]:
    """The likeliest laws of a missing force, at no more than a few places each."""
    if not bench.data.impacts:
        return []
    missing = MissingForce(base, bench.data)
    found = sorted((law for x in PLACES for law in laws(missing.at(x))), key=lambda law: law.price)
    by_terms: dict[tuple[str, ...], list[Law]] = {}
    for law in found:
        by_terms.setdefault(tuple(law.numbers), []).append(law)
    return sorted((law for some in by_terms.values() for law in some[:EACH]), key=lambda law: law.price)[:MOST]
