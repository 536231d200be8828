"""Jobs and what comes out of runs: FRFs, models, diagnoses."""

from typing import Annotated, Literal

from pydantic import Field, JsonValue

from modallab.core.frf import FrfQuantity
from modallab.core.frozen import ComplexArray, Frozen, RealArray

JobState = Literal["queued", "running", "done", "failed", "cancelled"]
"""Of a job; the last three are for good."""

JobKind = Literal["identify", "diagnose", "report", "estimate", "blind"]


class JobView(Frozen):
    """A piece of work that is computed beside the service.

    Attributes:
        id: made by the service.
        kind: identify, diagnose, report, blind, or estimate: the modes so far of a run that is on.
        state: `done`, `failed` and `cancelled` are for good.
        parameters: what was asked for.
        inputs: runs it works on.
        progress: 0 to 1.
        attempts: how often it was begun; more than once if a worker was lost.
        created_utc: for people.
        ended_utc: "" until it has ended.
        code_version: of the program that took the order.
        result: what it gave; None unless done, and None in lists.
        error: why it failed.
        stage: what is being done, in words; "" where nothing is.
    """

    id: str
    kind: str
    state: JobState
    parameters: dict[str, JsonValue]
    inputs: tuple[str, ...]
    progress: float = Field(ge=0, le=1)
    attempts: int = Field(ge=0)
    created_utc: str
    ended_utc: str = ""
    code_version: str
    result: JsonValue = None
    error: str | None = None
    stage: str = ""


class JobNew(Frozen):
    """Order work on a campaign's runs; without `runs`, on all of them that are valid.

    Attributes:
        runs: names of runs of the campaign; None: all that are valid.
        parameters: settings of the work, by name.
    """

    runs: Annotated[tuple[Annotated[str, Field(max_length=64)], ...], Field(min_length=1, max_length=200)] | None = None
    parameters: dict[str, JsonValue] = Field(default_factory=dict)


class FrfView(Frozen):
    """FRFs of a run as far as it has come; arrays are (outputs, inputs, lines).

    Attributes:
        run: it is of.
        quantity: mobility.
        unit: of its values.
        frequency_hz: (lines,).
        values: complex.
        coherence: None where nothing was averaged.
        outputs: channel names.
        output_points: None where unknown.
        input_points: points that were driven.
        averages: blocks averaged at each input.
    """

    run: str
    quantity: FrfQuantity
    unit: str
    frequency_hz: RealArray
    values: ComplexArray
    coherence: RealArray | None
    outputs: tuple[str, ...]
    output_points: tuple[int | None, ...]
    input_points: tuple[int | None, ...]
    averages: tuple[int, ...]
