"""What goes over the pipe between a rig's process and the one that owns it, besides the events."""

from dataclasses import dataclass

from modallab.acquisition.monitor.requests import AcceptBlock, DropBlock
from modallab.acquisition.procedures.struck_point.participation import ExpectedModes
from modallab.bench.protocol import BenchInfo
from modallab.core.documents.runs import Abort, Pause, Repeat, Resume, Stop
from modallab.core.errors import ModallabError
from modallab.core.events import Event
from modallab.core.plan import Plan


@dataclass(frozen=True, slots=True)
class RunPlan:
    """Begin a run.

    Attributes:
        plan: what to do.
        expected: the modes the structure is believed to have; None if nothing is believed.
    """

    plan: Plan
    expected: ExpectedModes | None = None


@dataclass(frozen=True, slots=True)
class EmergencyStop:
    """As abort; the rig is tripped already."""


@dataclass(frozen=True, slots=True)
class Close:
    """End the run if there is one, release the bench, and leave."""


@dataclass(frozen=True, slots=True)
class OwnerHeartbeat:
    """The owner lives."""


Message = (
    RunPlan | Pause | Resume | Repeat | DropBlock | AcceptBlock | Stop | Abort | EmergencyStop | Close | OwnerHeartbeat
)
"""What the owner sends: an operator's commands as they are in the API, and what only the owner may ask for."""


@dataclass(frozen=True, slots=True)
class BenchOpened:
    """The bench is open, its output at zero."""

    info: BenchInfo


@dataclass(frozen=True, slots=True)
class Ended:
    """No run is active any more; `error` says why, if it is for an error."""

    error: ModallabError | None


Report = Event | BenchOpened | Ended
