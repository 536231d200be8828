"""Where a gap comes from, part by part, as a document."""

from typing import Literal

from pydantic import Field

from modallab.core.frozen import Frozen

Division = Literal["test", "channel", "band", "mode"]


class BudgetRow(Frozen):
    """A part of the gap.

    Attributes:
        kind: a number that was free within its tolerance, an effect, what no number explains, or noise.
        name: of the tolerance in the rig file, or of the effect; `+` between those whose shares cancel.
        place: channel, drive point or mode; "" where there is one only.
        said: in words, with the number.
        sigmas: how many deviations of its tolerance it has moved; of several, the most.
        share: of the squares of measured less predicted by the rig file's own twin, each record's response counting
            alike. All shares add up to 1; a negative one works against the others.
        by: test, channel, band or mode -> name of each -> the part of the share that lies there.
    """

    kind: Literal["tolerance", "effect", "model", "noise"]
    name: str
    place: str
    said: str
    sigmas: float | None
    share: float
    by: dict[Division, dict[str, float]] = Field(default_factory=dict[Division, dict[str, float]])


class Budget(Frozen):
    """Where the gap between the rig file's own twin and the records comes from, largest part first.

    Attributes:
        rows: the parts.
        calibrate: what to calibrate or measure first, and why.
        usual: tolerances that the rig file does not state and a lab's usual ones stand for.
    """

    rows: list[BudgetRow]
    calibrate: list[str]
    usual: dict[str, float] = Field(default_factory=dict[str, float])
