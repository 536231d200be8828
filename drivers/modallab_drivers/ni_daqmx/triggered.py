"""One record that the device triggers by itself."""

from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from modallab.bench.abilities import ReferenceTrigger
from modallab.core.errors import BenchTimeoutError
from modallab_drivers.ni_daqmx.inputs import Inputs


class TriggeredRecord:
    """A started finite task that waits for a crossing."""

    def __init__(self, inputs: Inputs, trigger: ReferenceTrigger, *, virtual_time: bool) -> None:
        """Wait with `inputs`, which were made with the same trigger and started."""
        self._inputs, self._trigger, self._virtual_time = inputs, trigger, virtual_time
        self._early: NDArray[np.float32] | None = None

    def is_armed(self) -> bool:
        """Whether the pre-trigger is full."""
        if self._virtual_time and self._early is None:
            # There, time goes on only by reading.
            with suppress(BenchTimeoutError):
                self._early = self._inputs.read(self._trigger.count, 0.0)
        return self._early is not None or self._inputs.acquired() >= self._trigger.pre_trigger

    def take(self, timeout_s: float) -> NDArray[np.float32]:
        """The (channels, count) values of the record.

        Raises:
            BenchTimeoutError: no crossing yet.
        """
        early, self._early = self._early, None
        return early if early is not None else self._inputs.read(self._trigger.count, timeout_s)
