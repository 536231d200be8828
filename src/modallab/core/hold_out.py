"""Which records no fit may see: those it has never seen say how far the gap shrinks."""

from collections.abc import Callable
from dataclasses import dataclass

from modallab.core.errors import PlanError
from modallab.core.units import TESTS

RULES = "mixed, spread, point:N, level:NAME, test:impact, test:sine, last:SHARE"


@dataclass(frozen=True, slots=True)
class HoldOut:
    """A rule that chooses records; its text is `RULE` or `RULE:VALUE`.

    Attributes:
        rule: `mixed` (one drive point of several, every third sine frequency), `spread` (every third hit at each point
            instead), `point`, `level`, `test`, or `last` of the records in time.
        value: the point's number, the level's or the test's name, or a share of the records; "" for the first two.

    Raises:
        PlanError: there is no such rule, or its value is none.
    """

    rule: str = "mixed"
    value: str = ""

    def __post_init__(self) -> None:
        accepts = _VALUES.get(self.rule)
        if accepts is None or not accepts(self.value):
            raise PlanError(f"{str(self)!r} is no rule to hold records out", remedy=f"use one of {RULES}")

    def __str__(self) -> str:
        return f"{self.rule}:{self.value}" if self.value else self.rule

    @classmethod
    def parse(cls, text: str) -> "HoldOut":
        """The rule that a text names.

        Raises:
            PlanError: it names none.
        """
        rule, _, value = text.partition(":")
        return cls(rule, value)

    @property
    def where_possible(self) -> bool:
        """Whether it holds nothing out where there are too few records."""
        return self.rule in ("mixed", "spread")


def _is_share(value: str) -> bool:
    try:
        return 0 < float(value) < 1
    except ValueError:
        return False


_VALUES: dict[str, Callable[[str], bool]] = {
    "mixed": lambda value: not value,
    "spread": lambda value: not value,
    "point": str.isdecimal,
    "level": bool,
    "test": lambda value: value in TESTS,
    "last": _is_share,
}
MIXED = HoldOut()
SPREAD = HoldOut("spread")
"""Holds out none of what was measured last, to decide, as a whole."""
