"""Jobs: as others see one, when two are the same, and what the runner knows of a kind."""

import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

from pydantic import JsonValue

from modallab.core.documents.results import JobState, JobView
from modallab.core.errors import JobError
from modallab.core.frozen import Frozen

OPEN: frozenset[JobState] = frozenset({"queued", "running"})
"""States a job will leave by itself."""


class Job(JobView):
    """One piece of work; its id sorts by time.

    Attributes:
        revision: of what its inputs held when it was ordered; "" if that cannot change.
    """

    revision: str = ""

    @property
    def has_ended(self) -> bool:
        """Whether its state is for good."""
        return self.state not in OPEN


class JobPage(Frozen):
    """Some jobs, the newest first, and where the next page begins; None after the last."""

    jobs: tuple[Job, ...]
    cursor: str | None


def job_key(kind: str, parameters: dict[str, Any], inputs: Sequence[str], revision: str, code_version: str) -> str:
    """SHA-256 over all that decides a result. The order of inputs counts, the order of parameters does not.

    Raises:
        JobError: a parameter is no JSON value, or is NaN or infinite.
    """
    content = [kind, parameters, list(inputs), revision, code_version]
    try:
        text = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
    except (TypeError, ValueError) as error:
        raise JobError(
            f"the parameters of {kind} cannot be kept: {error}",
            where="parameters",
            remedy="give finite numbers, texts, lists and objects only",
        ) from error
    return hashlib.sha256(text.encode()).hexdigest()


class ProgressCallback(Protocol):
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
class JobDefinition:
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
    compute: Callable[[Any, ProgressCallback], ComputationResult]
    keep: Callable[[str, ComputationResult], JsonValue]
    limit_s: float = 3600.0
    revision: Callable[[tuple[str, ...]], str] = lambda _: ""
