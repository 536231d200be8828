"""Where a gap comes from, part by part, as a document."""

from typing import Literal

from pydantic import Field

from modallab.core.frozen import Frozen

Division = Literal["test", "channel", "band", "mode"]


class BudgetRow(Frozen):
    """A contribution to the gap.

    Attributes:
        kind: a number within its tolerance, an effect, unexplained, or noise.
        name: tolerance in the rig file, or effect; `+` joins those whose shares cancel.
        place: channel, drive point or mode; "" if there is only one.
        said: the contribution in words, with its number.
        sigmas: deviations of the tolerance; of several, the largest.
        share: share of the squares of measured less predicted by the rig file's own twin, with equal weight for all
            records. All shares add up to 1; a negative one reduces the others.
        by: test, channel, band or mode -> name of each -> its part of the share.
    """

    kind: Literal["tolerance", "effect", "model", "noise"]
    name: str
    place: str
    said: str
    sigmas: float | None
    share: float
    by: dict[Division, dict[str, float]] = Field(default_factory=dict[Division, dict[str, float]])


class Budget(Frozen):
    """Contributions to the gap between the rig file's own twin and the records, the largest first.

    Attributes:
        rows: contributions.
        calibrate: what to calibrate or measure first, and why.
        usual: tolerances that the rig file does not state, with the usual values used instead.
    """

    rows: list[BudgetRow]
    calibrate: list[str]
    usual: dict[str, float] = Field(default_factory=dict[str, float])
