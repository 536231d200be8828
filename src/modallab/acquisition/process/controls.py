"""What may be done to a run while it goes on, besides ending it, and what is known of it. From any thread."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Self

from modallab.acquisition.monitor.run_states import AcceptBlock, DropBlock, require_legal
from modallab.acquisition.procedures.target import require_recorded, require_step
from modallab.acquisition.process.owner_link import Message
from modallab.core.block import Block
from modallab.core.documents.runs import PauseRun, RepeatFrequency, ResumeRun
from modallab.core.errors import PlanError
from modallab.core.events import (
    BlockAccepted,
    BlockAcknowledged,
    BlockDropped,
    DecisionRequested,
    Event,
    HitRejected,
    HitRequested,
    RunProgress,
    RunState,
    StateChanged,
)
from modallab.core.plan import BroadbandPlan, ImpactPlan, Plan, SinePlan
from modallab.storage import Store


@dataclass(frozen=True, slots=True)
class RunStatus:
    """The active run, or the last one; each event makes a new view.

    Attributes:
        run: name of the run.
        state: where it stands.
        done: good hits, or frequencies, so far.
        total: how many are requested.
        what: what was done last, or is waited for.
        requested: the hit that is waited for.
        rejected: hits rejected so far.
        blocks: names of the blocks that count, in order.
        last_block: name of the last block that was kept, whether it counts or not.
        undecided: name of the block that the run waits for the operator about; "" if it does not.
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
    undecided: str = ""

    def after_event(self, event: Event) -> Self:
        """The view once this event has happened."""
        if isinstance(event, DecisionRequested):
            return replace(self, undecided=event.name)
        if isinstance(event, StateChanged):
            return replace(self, run=event.run, state=event.state)
        if isinstance(event, HitRequested):
            return replace(self, requested=event)
        if isinstance(event, HitRejected):
            return replace(self, rejected=self.rejected + 1)
        if isinstance(event, BlockAcknowledged):
            counted = (*self.blocks, event.name) if event.accepted else self.blocks
            return replace(self, blocks=counted, last_block=event.name, requested=None, undecided="")
        if isinstance(event, BlockDropped):
            return replace(self, blocks=tuple(name for name in self.blocks if name != event.name))
        if isinstance(event, BlockAccepted):
            return replace(self, blocks=(*self.blocks, event.name), requested=None)
        if isinstance(event, RunProgress):
            return replace(self, done=event.done, total=event.total, what=event.what)
        return self


class RunControls(ABC):
    """The controls of one rig's active run; `RigProcess` sends what they want to its process."""

    def __init__(self, data_folder: Path) -> None:
        self._folder = data_folder
        self._plan: Plan | None = None
        self._view = RunStatus()
        self._running = self._pausing = False

    @property
    def view(self) -> RunStatus:
        """The active run or the last one: state, hits or frequencies so far of how many, the hit that is waited for,
        the blocks that count, the last block's name. From any thread; as new as the last event that `run` yielded."""
        return self._view

    def last_block(self) -> Block | None:
        """The last block that was kept, read back from the disk while the run goes on; None before the first.

        Raises:
            StorageError: it is not what was acknowledged.
        """
        view = self._view
        if not view.last_block:
            return None
        with Store(self._folder) as store:
            return store.block(view.run, view.last_block)

    def pause(self) -> None:
        """`acquiring -> paused` at the next boundary between blocks or bursts, with the excitation at 0 V there.

        A burst that is on is played to its end; a hit that is waited for is no longer. The state says when it is done.

        Raises:
            IllegalTransitionError: the run is not acquiring.
        """
        require_legal(self._view.state, "paused")
        self._pausing = True
        self._send(PauseRun())

    def resume(self) -> None:
        """`paused -> acquiring`: the beam is waited for, then the test goes on; it also takes back a pause to come.

        Raises:
            IllegalTransitionError: the run neither is paused nor was asked to pause.
        """
        if not (self._pausing and self._view.state == "acquiring"):
            require_legal("armed" if self._view.state == "paused" else "created", "acquiring")
        self._pausing = False
        self._send(ResumeRun())

    def repeat(self, frequency_hz: float, level: str = "") -> None:
        """Record a frequency of the running sine test once more, next; once it is kept, the block before is dropped.

        Args:
            frequency_hz: one of the plan's that has been recorded.
            level: one of the plan's; empty: every level it was recorded at.

        Raises:
            PlanError: no sine test is running, it has no such frequency or level, or it is still to come.
        """
        if not self._running or self._plan is None:
            raise PlanError(
                "no run is active", remedy="run a plan with this frequency alone, and drop the earlier block"
            )
        plan = require_step(self._plan, frequency_hz, level)
        require_recorded(plan, frequency_hz, level, self._view.blocks)
        self._send(RepeatFrequency(frequency_hz=frequency_hz, level=level or None))

    def drop(self, block: str, reason: str = "dropped by the operator") -> None:
        """Let a block of this run no longer count, such as one hit; its samples stay on the disk, with the reason.

        While an impact test runs, the hit is asked for again. After the run the block is only left out;
        `Store.drop(run, block, reason)` does the same for any recorded run, without a process.

        Raises:
            PlanError: no block of this name counts in the run.
        """
        if block not in (*self._view.blocks, self._view.undecided):
            counted = ", ".join(self._view.blocks)
            raise PlanError(f"no block {block!r} counts in the run", remedy=f"name one of: {counted or 'none yet'}")
        if self._running:
            self._send(DropBlock(block, reason))
            return
        with Store(self._folder) as store:
            store.drop_block(self._view.run, block, reason)
        self._view = self._view.after_event(BlockDropped(run=self._view.run, name=block, reason=reason))

    def accept(self, block: str, reason: str, operator: str = "") -> None:
        """Let a hit of the running impact test count that was rejected or dropped; it is then no longer asked for.

        Without effect where a later hit already counts in its place.

        Raises:
            PlanError: no impact test is running.
        """
        if not self._running or not isinstance(self._plan, ImpactPlan):
            raise PlanError("no impact test is active", remedy="accept the block once its run has ended")
        self._send(AcceptBlock(block, reason, operator))

    def _begin(self, plan: Plan) -> None:
        self._plan, self._view = plan, RunStatus()
        self._running, self._pausing = True, False

    def _saw(self, event: Event) -> None:
        self._view = self._view.after_event(event)

    @property
    def _driving(self) -> bool:
        return isinstance(self._plan, SinePlan | BroadbandPlan) and self._view.state in ("armed", "acquiring", "paused")

    @abstractmethod
    def _send(self, message: Message) -> None:
        """Send it to the process.

        Raises:
            BenchError: it died.
        """
