"""Whether two tests give the same shapes: MAC by mode, CoMAC by point."""

from itertools import combinations

from modallab.core.digits import share
from modallab.core.errors import DataError
from modallab.core.model import ModalModel
from modallab.reporting.content import Outcome, ReportContent
from modallab.reporting.markup import Markup, join, table, tag
from modallab.reporting.sections.section import paragraph
from modallab.verification.comparison import Comparison, compare

WORDS = (
    "MAC says how alike the shapes of a mode are, 1 being the same up to a factor. CoMAC says it of a point over all "
    "modes: a point far below the others has a sensor that is loose, turned or swapped in one of the tests."
)


def comparison_tables(content: ReportContent) -> Markup | None:
    """Tables for every two tests that share modes and points."""
    there = [(o, o.model) for o in content.outcomes if o.model is not None and o.model.n_modes]
    parts: list[Markup] = []
    for (one, first), (other, second) in combinations(there, 2):
        try:
            parts += _tables(f"{_called(one)} and {_called(other)}", first, compare(first, second))
        except DataError:
            # One test of one sensor, or bands apart: there is nothing to compare.
            continue
    return join([*parts, paragraph(WORDS)]) if parts else None


def _tables(names: str, first: ModalModel, found: Comparison) -> list[Markup]:
    modes = [
        (f"{first.frequency_hz[i]:.4g} Hz", share(float(value)))
        for (i, _), value in zip(found.pairs, found.mac, strict=True)
    ]
    points = [(f"Point {p}", share(float(value))) for p, value in zip(found.points, found.comac, strict=True)]
    by_point = table(f"CoMAC of {names} over {len(found.pairs)} modes", ("point", "CoMAC"), points, (1,))
    return [
        table(f"Do the shapes of {names} agree?", ("mode", "MAC"), modes, (1,)),
        tag("details", tag("summary", f"CoMAC at every point, {names}"), by_point),
    ]


def _called(outcome: Outcome) -> str:
    return f"the {outcome.test} test" if outcome.test else "the FRFs"
