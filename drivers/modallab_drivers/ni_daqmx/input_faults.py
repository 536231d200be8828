"""What a device says of its inputs while it samples: beyond the range, no sensor, no supply."""

import time
from collections.abc import Sequence
from typing import Any

import nidaqmx.errors
import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import BenchError
from modallab_drivers.ni_daqmx.errors import UNSUPPORTED_HERE, typed_error
from modallab_drivers.ni_daqmx.plugs import Plug

FAULT_POLL_S = 1.0

_UNSUPPORTED = (UNSUPPORTED_HERE, -200077, -200197)
"""What a device says that has no such flag."""


class InputFaults:
    """The flags of one task."""

    def __init__(self, task: Any, plugs: Sequence[Plug], where: str) -> None:
        """Look at `task`, whose channels are `plugs`."""
        self._task, self._plugs, self._where = task, tuple(plugs), where
        self._flags = True
        self._fed = any(plug.channel.coupling in ("IEPE", "bridge") for plug in plugs)
        self._polled_s = 0.0
        self._open_unseen = False

    def open_unseen(self) -> tuple[str, ...]:
        """Names of fed channels of which the device cannot say whether a sensor is there; known after a first look."""
        fed = [plug.channel.name for plug in self._plugs if plug.channel.coupling in ("IEPE", "bridge")]
        return tuple(fed) if self._open_unseen else ()

    def overloaded(self) -> NDArray[np.bool_]:
        """(channels,) whether the device saw a channel beyond its range since it was last asked."""
        flags = np.zeros(len(self._plugs), dtype=np.bool_)
        if not self._flags:
            return flags
        try:
            # Asking whether clears the flags, and must come before asking which.
            if self._task.in_stream.overloaded_chans_exist:
                names = set(self._task.in_stream.overloaded_chans)
                flags |= np.array([plug.physical in names for plug in self._plugs])
        except nidaqmx.errors.DaqError as error:
            if int(error.error_code) not in _UNSUPPORTED:
                raise typed_error(error, self._where) from error
            self._flags = False
        return flags

    def require_sensors(self) -> None:
        """Look, once in a while, whether a fed sensor is unplugged or shorted.

        Raises:
            BenchError: names the channels.
        """
        if not self._fed or time.monotonic() - self._polled_s < FAULT_POLL_S:
            return
        self._polled_s = time.monotonic()
        stream = self._task.in_stream
        for what, exist, which in (
            ("open: no sensor is connected", "open_chans_exist", "open_chans"),
            ("without excitation: a short, or no power", "excit_fault_chans_exist", "excit_fault_chans"),
        ):
            try:
                found = list(getattr(stream, which)) if getattr(stream, exist) else []
            except nidaqmx.errors.DaqError as error:
                if int(error.error_code) not in _UNSUPPORTED:
                    raise typed_error(error, self._where) from error
                self._open_unseen |= exist == "open_chans_exist"
                continue
            if found:
                names = [plug.channel.name for plug in self._plugs if plug.physical in found]
                raise BenchError(
                    f"channel {', '.join(names)} is {what}", where=self._where, remedy="look at its cable and sensor"
                )

    def unlocked(self) -> list[str]:
        """Channels whose clock has lost the reference it should follow; empty where the device has no such flag."""
        try:
            stream = self._task.in_stream
            return list(stream.pll_unlocked_chans) if stream.pll_unlocked_chans_exist else []
        except nidaqmx.errors.DaqError as error:
            if int(error.error_code) not in _UNSUPPORTED:
                raise typed_error(error, self._where) from error
            return []
