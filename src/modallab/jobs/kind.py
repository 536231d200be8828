"""What the runner knows of a kind of job: how it begins, what a worker computes, how its result is kept."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

from pydantic import JsonValue


class Notify(Protocol):
    """How a computation says how far it is. Raises `Interrupted` where the job was cancelled meanwhile."""

    def __call__(self, fraction: float, stage: str = "", /) -> None:
        """Say that `fraction` (0 to 1) is done, and what is being done now, in words."""
        ...


@dataclass(frozen=True, slots=True)
class ComputationResult:
    """What a computation gives back.

    Attributes:
        result: a JSON value.
        blobs: file name -> content, for what is too large or no JSON, such as a report.
    """

    result: JsonValue
    blobs: dict[str, bytes] = field(default_factory=dict[str, bytes])


@dataclass(frozen=True, slots=True)
class Kind:
    """One kind of job.

    `load` and `keep` run beside the runner, where the data are. `compute` runs on a worker, which has neither files nor
    a database: everything goes in by the payload and comes back by the result. It must be a function at the top of
    a module that the worker can import, and give the same for the same payload, since it may run more than once.

    Attributes:
        name: what jobs call it.
        load: (parameters, inputs) -> payload, anything that can be pickled.
        compute: (payload, notify) -> what was found.
        keep: (name, computed) -> the job's result. `name` is another for each attempt, so that two attempts never write
            to the same place.
        revision: inputs -> a text that changes when what they hold does. A job whose inputs have changed between order
            and load fails: its key would say otherwise than its result.
        limit_s: a computation longer than this is given up.
    """

    name: str
    load: Callable[[dict[str, JsonValue], tuple[str, ...]], Any]
    compute: Callable[[Any, Notify], ComputationResult]
    keep: Callable[[str, ComputationResult], JsonValue]
    limit_s: float = 3600.0
    revision: Callable[[tuple[str, ...]], str] = lambda _: ""
