"""The triggers of a hit: in software on the rising force, with hysteresis, and the device's own."""

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from modallab.acquisition.monitor.context import RunContext
from modallab.bench.capabilities import ReferenceTrigger, TriggersInHardware
from modallab.bench.protocol import Bench
from modallab.core.errors import BenchTimeoutError, PlanError
from modallab.core.plan import ImpactPlan, Plan

LOOK_S = 0.2
"""Between two looks whether the run shall go on."""
ARM_LOOK_S = 0.02


class Trigger:
    """Finds the first sample at or above `level` after the signal was below `level - hysteresis`.

    The answer is exact to the sample and does not depend on how the signal is cut into chunks.
    """

    def __init__(self, level: float, hysteresis: float) -> None:
        self._level = level
        self._low = level - hysteresis
        self._armed = False

    def scan(self, signal: NDArray[np.float64]) -> int | None:
        """Index of the trigger in the next (n,) samples, or None. After a trigger it must fall before it can fire."""
        start = 0
        if not self._armed:
            below = np.flatnonzero(signal < self._low)
            if below.size == 0:
                return None
            self._armed = True
            start = int(below[0]) + 1
        above = np.flatnonzero(signal[start:] >= self._level)
        if above.size == 0:
            return None
        self._armed = False
        return start + int(above[0])


def require_trigger(plan: Plan, bench: Bench) -> None:
    """Reject a hardware trigger where there is none.

    Raises:
        PlanError: names the field.
    """
    if isinstance(plan, ImpactPlan) and plan.trigger == "hardware" and not isinstance(bench, TriggersInHardware):
        raise PlanError(
            "trigger: hardware, but this bench has no trigger of its own; allowed: software",
            where="impact plan",
            remedy="change the plan",
        )


def wait_for_record(
    context: RunContext, plan: ImpactPlan, ask: Callable[[], None], interrupted: Callable[[], bool]
) -> int | None:
    """Let the device wait for a hit, and take its record in place of the stream.

    The record holds the window before the hit too, so that the rest before it is judged as with the software trigger.

    Args:
        context: streaming; afterwards its stream holds the record, and must be restarted.
        plan: level and times.
        ask: called once the pre-trigger is full, to ask for the hit.
        interrupted: asked at every look; True ends the wait.

    Returns:
        The sample of the trigger in the record; None if it was interrupted, and the bench streams again.

    Raises:
        BenchTimeoutError: no hit came in time.
    """
    bench, stream = context.bench, context.stream
    assert isinstance(bench, TriggersInHardware)
    before = context.rest_window + stream.samples_of(plan.pre_trigger_s)
    bench.stop()
    bench.arm(_reference_trigger(context, plan, before))
    while not bench.is_armed():
        stream.poll()
        time.sleep(ARM_LOOK_S)
    ask()
    deadline = time.monotonic() + plan.hit_timeout_s
    while True:
        stream.poll()
        if interrupted():
            stream.restart()
            return None
        try:
            stream.replace_by_record(bench.triggered(LOOK_S))
        except BenchTimeoutError:
            if time.monotonic() >= deadline:
                raise
        else:
            return before


def _reference_trigger(context: RunContext, plan: ImpactPlan, before: int) -> ReferenceTrigger:
    per_count = context.conversion.si_per_count[context.conversion.force]
    block = context.block if context.recut is None else context.recut.native
    return ReferenceTrigger(
        channel=context.conversion.force,
        level=float(plan.trigger_n / per_count),
        hysteresis=float(abs(plan.hysteresis_n / per_count)),
        pre_trigger=before,
        count=context.rest_window + block,
    )
