"""What the owner knows of the active run, from its events: state, hits so far, frequency i of n, the last block."""

from dataclasses import dataclass, field, replace
from typing import Self

from modallab.core.events import (
    BlockAcknowledged,
    BlockDropped,
    Event,
    HitRejected,
    HitRequested,
    Progress,
    RunState,
    StateChanged,
)


@dataclass(frozen=True, slots=True)
class RunView:
    """The active run, or the last one; each event makes a new view.

    Attributes:
        run: its name.
        state: where it stands.
        done: good hits, or frequencies, so far.
        total: how many are requested.
        what: what was done last, or is waited for.
        requested: the hit that is being waited for.
        rejected: hits rejected so far.
        blocks: names of the blocks that count, in order.
        last_block: name of the last block that was kept, whether it counts or not.
    """

    run: str = ""
    state: RunState = "created"
    done: int = 0
    total: int = 0
    what: str = ""
    requested: HitRequested | None = None
    rejected: int = 0
    blocks: tuple[str, ...] = field(default=())
    last_block: str = ""

    def after(self, event: Event) -> Self:
        """The view once this event has happened."""
        if isinstance(event, StateChanged):
            return replace(self, run=event.run, state=event.state)
        if isinstance(event, HitRequested):
            return replace(self, requested=event)
        if isinstance(event, HitRejected):
            return replace(self, rejected=self.rejected + 1)
        if isinstance(event, BlockAcknowledged):
            counted = (*self.blocks, event.name) if event.accepted else self.blocks
            return replace(self, blocks=counted, last_block=event.name, requested=None)
        if isinstance(event, BlockDropped):
            return replace(self, blocks=tuple(name for name in self.blocks if name != event.name))
        if isinstance(event, Progress):
            return replace(self, done=event.done, total=event.total, what=event.what)
        return self
