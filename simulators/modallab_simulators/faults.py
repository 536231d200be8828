"""What goes wrong on a bench, on purpose: each fault by its name, for the simulated devices.

`apply` reads a line such as `unplugged -201003` and arms the fault in the simulated device; the names are the same
whatever the device is, and a device rejects those it cannot have.
"""

from collections import deque
from dataclasses import dataclass

SAMPLES_LOST = "samples-overwritten"
TIME_OUT = "time-out"
PARTIAL = "partial-read"
UNPLUGGED = "unplugged"
PLUGGED = "plugged"
RESERVED = "reserved"
RELEASED = "released"
CLIPPED = "clipped-set-point"
DEAD_LINE = "dead-line"
WARNING = "warning"
STATUS = "status"
INVALID = "invalid-task"
COERCED = "coerced-set-point"
FRONT_PANEL = "front-panel"
POWER_CYCLE = "power-cycle"
STAYS_ON = "stays-on"
SLOW = "slow-answers"
LATE = "late-answer"
ECHO = "echo"
GARBAGE = "garbage"
CUT_OFF = "cut-off-answers"
TERMINATOR = "wrong-terminator"

DAQ_FAULTS = (
    SAMPLES_LOST, TIME_OUT, PARTIAL, UNPLUGGED, PLUGGED, RESERVED, RELEASED, DEAD_LINE, WARNING, STATUS, INVALID,
)  # fmt: skip
GENERATOR_FAULTS = (
    CLIPPED, DEAD_LINE, UNPLUGGED, TIME_OUT, COERCED, FRONT_PANEL, POWER_CYCLE, STAYS_ON, SLOW, LATE, ECHO, GARBAGE,
    CUT_OFF, TERMINATOR,
)  # fmt: skip


@dataclass(slots=True)
class ArmedFault:
    """A fault that waits for its call.

    Attributes:
        call: name of the call it spoils.
        code: status it gives; 0 if it only spoils what comes back.
        kind: name of the fault.
        times: how often still.
    """

    call: str
    code: int
    kind: str
    times: int = 1


class FaultPlan:
    """Faults armed for calls, in the order they were armed."""

    def __init__(self) -> None:
        self._armed: deque[ArmedFault] = deque()

    def arm(self, fault: ArmedFault) -> None:
        """Let a fault wait."""
        self._armed.append(fault)

    def due(self, call: str) -> ArmedFault | None:
        """The fault for a call that is being made, if one waits for it."""
        for fault in self._armed:
            if fault.call == call and fault.times > 0:
                fault.times -= 1
                if fault.times == 0:
                    self._armed.remove(fault)
                return fault
        return None


def parse_fault(line: str, known: tuple[str, ...]) -> tuple[str, list[str]]:
    """Name and arguments of a fault, as an operator types it.

    Raises:
        ValueError: the device cannot have this fault.
    """
    words = line.split()
    if not words or words[0] not in known:
        raise ValueError(f"unknown fault {line!r}; known: {', '.join(known)}")
    return words[0], words[1:]
