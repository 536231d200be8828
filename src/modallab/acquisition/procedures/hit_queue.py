"""The hits that are still requested, those that count, and what the operator wants of them meanwhile."""

from collections import deque
from dataclasses import dataclass, field, replace
from typing import Self

from modallab.acquisition.monitor.context import RunContext
from modallab.acquisition.monitor.requests import AcceptBlock, DropBlock
from modallab.acquisition.procedures.target import Target
from modallab.core.plan import ImpactPlan


@dataclass(slots=True)
class HitQueue:
    """What an impact test still has to do.

    Attributes:
        total: hits that the plan wants.
        todo: hits that are still requested; the first is the present one.
        kept: good hits by the name of their record.
        rejected: hits that did not count, or count no more, by the name of their record.
    """

    total: int
    todo: deque[Target]
    kept: dict[str, Target] = field(default_factory=dict[str, Target])
    rejected: dict[str, Target] = field(default_factory=dict[str, Target])

    @classmethod
    def of(cls, plan: ImpactPlan) -> Self:
        """Everything is still to do."""
        todo = deque(Target(point, hit) for point in plan.points for hit in range(1, plan.hits + 1))
        return cls(len(todo), todo)

    @property
    def present(self) -> Target:
        """The hit that is requested now."""
        return self.todo[0]

    def next_name(self) -> str:
        """Name of the present hit's record, should it be rejected."""
        rejected = f"{self.present.name}_rejected_"
        return f"{rejected}{1 + sum(n.startswith(rejected) for n in self.rejected)}"

    def keep(self) -> None:
        """The present hit counts."""
        target = self.todo.popleft()
        self.kept[target.name] = target

    def reject(self, name: str) -> None:
        """The present hit was recorded under this name and does not count."""
        self.rejected[name] = self.present

    def drop(self, context: RunContext, request: DropBlock) -> bool:
        """A hit counts no longer and is asked for again, at once; whether it did count."""
        if not context.drop(request.block, request.reason):
            return False
        target = self.kept.pop(request.block, None)
        if target is not None:
            again = replace(target, again=target.again + 1)
            self.todo.appendleft(again)
            # Until it is struck again, what was dropped can be taken back.
            self.rejected[request.block] = again
        return True

    def accept(self, context: RunContext, request: AcceptBlock) -> Target | None:
        """A hit that was rejected or dropped counts and is not asked for again; the hit it was, None if there is none.

        A hit that has been kept since under the same target stays the one that counts.
        """
        target = self.rejected.get(request.block)
        if target is None or target not in self.todo:
            return None
        if not context.accept(request.block, request.reason, request.operator):
            return None
        self.todo.remove(target)
        self.kept[request.block] = target
        return target
