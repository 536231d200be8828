"""Jobs and what comes out of runs: FRFs, models, diagnoses."""

from typing import Annotated, Literal

from pydantic import Field, JsonValue

from modallab.core.frf import FrfQuantity
from modallab.core.frozen import ComplexArray, Frozen, RealArray

JobState = Literal["queued", "running", "done", "failed", "cancelled"]
"""Of a job; the last three are for good."""

JobKind = Literal["identify", "diagnose", "report", "estimate", "blind"]


class JobView(Frozen):
    """A job computed beside the service.

    Attributes:
        id: id, made by the service.
        kind: identify, diagnose, report, blind, or estimate (the modes so far of an active run).
        state: state; `done`, `failed` and `cancelled` are final.
        parameters: parameters of the order.
        inputs: names of its runs.
        progress: 0 to 1.
        attempts: number of attempts; more than one after the loss of a worker.
        created_utc: for people.
        ended_utc: date and time of its end; "" before.
        code_version: version of modallab at the order.
        result: result; None unless done, and None in lists.
        error: reason of the failure.
        stage: present stage in words; "" if none.
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


class JobRequest(Frozen):
    """Order of a job on runs of a campaign (default: all valid runs).

    Attributes:
        runs: names of runs of the campaign; None: all valid ones.
        parameters: parameters of the job, by name.
    """

    runs: Annotated[tuple[Annotated[str, Field(max_length=64)], ...], Field(min_length=1, max_length=200)] | None = None
    parameters: dict[str, JsonValue] = Field(default_factory=dict)


class FrfView(Frozen):
    """FRFs of a run so far; arrays are (outputs, inputs, lines).

    Attributes:
        run: name of the run.
        quantity: mobility.
        unit: unit of the values.
        frequency_hz: (lines,).
        values: complex values.
        coherence: coherence; None without averages.
        outputs: channel names.
        output_points: points of the outputs; None if unknown.
        input_points: driven points.
        averages: number of blocks averaged at each input.
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
