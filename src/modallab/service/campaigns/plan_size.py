"""Plans no machine could carry out, rejected before anything is made ready for them."""

from math import isfinite

from modallab.core.errors import PlanError
from modallab.core.plan import Plan, SinePlan
from modallab.core.rig import Rig

MAX_BLOCK_BYTES = 256 << 20
MAX_RATE_HZ = 1e6
MAX_SECONDS = 3600.0
MAX_BLOCKS = 100_000
_BYTES_A_SAMPLE = 8


def require_reasonable(plan: Plan, rig: Rig) -> None:
    """Reject numbers that are not finite, or beyond all that a bench could be asked for.

    Raises:
        PlanError: names every such field.
    """
    numbers = {name: value for name, value in plan.model_dump().items() if isinstance(value, float)}
    problems = [f"{name} is {value}; allowed: finite numbers" for name, value in numbers.items() if not isfinite(value)]
    problems += [
        f"{name} is {value:g}; allowed: up to {MAX_SECONDS:g}"
        for name, value in numbers.items()
        if name.endswith("_s") and value > MAX_SECONDS
    ]
    problems += [
        f"{name} is {value:g}; allowed: up to {MAX_RATE_HZ:g}"
        for name, value in numbers.items()
        if name in ("rate_hz", "delivered_hz") and value > MAX_RATE_HZ
    ]
    if not problems:
        problems = _too_many(plan, rig)
    if problems:
        raise PlanError("; ".join(problems), where=f"{plan.kind} plan", remedy="change the plan")


def _too_many(plan: Plan, rig: Rig) -> list[str]:
    samples = plan.block_s * plan.rate_hz
    found: list[str] = []
    if samples < 16 or samples * len(rig.channels) * _BYTES_A_SAMPLE > MAX_BLOCK_BYTES:
        found.append(f"a block of block_s at rate_hz has {samples:g} samples a channel; allowed: 16 to as many as fit")
    blocks = (
        len(plan.frequencies_hz) * len(plan.levels_v) if isinstance(plan, SinePlan) else len(plan.points) * plan.hits
    )
    if blocks > MAX_BLOCKS:
        found.append(f"{blocks} blocks; allowed: up to {MAX_BLOCKS}")
    return found
