"""How much room a run will need, asked before its first sample."""

from pathlib import Path

from modallab.core.plan import Plan
from modallab.storage.durable import require_space

MARGIN = 1.25
"""Hits that are rejected and bursts that are repeated are kept too."""


def planned_blocks(plan: Plan) -> int:
    """Blocks a plan asks for, if nothing need be repeated."""
    if plan.kind == "impact":
        return len(plan.points) * plan.hits
    return len(plan.frequencies_hz) * len(plan.levels_v)


def require_room(folder: Path, plan: Plan, block_bytes: int) -> None:
    """Reject a run for which there is too little room.

    Args:
        folder: of the samples.
        plan: what will be recorded.
        block_bytes: of one block of all channels.

    Raises:
        DiskFullError: fewer bytes are free than the plan's blocks and a quarter more.
    """
    require_space(folder, int(MARGIN * planned_blocks(plan) * block_bytes))
