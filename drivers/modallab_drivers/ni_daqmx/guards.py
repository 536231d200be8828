"""What watches from the device's side: a chassis' watchdog, and a line that toggles for an external relay."""

import time
from contextlib import suppress
from typing import Any

import nidaqmx.errors
from nidaqmx.constants import WatchdogAOExpirState
from nidaqmx.system.watchdog import WatchdogTask
from nidaqmx.types import AOExpirationState

from modallab.core.errors import OutputLostError
from modallab.core.hardware import Excitation
from modallab_drivers.ni_daqmx.errors import translated
from modallab_drivers.ni_daqmx.route import Route

BEAT_S = 0.02


class Watchdog:
    """Brings the output to 0 V when nobody resets it in time, whatever became of us."""

    def __init__(self, route: Route, device: str, output: str, timeout_s: float) -> None:
        """Start it.

        Raises:
            ConfigurationError: the device has none.
        """
        self._where = f"{route.address.url}, rig file field excitation.watchdog_s"
        with translated(self._where):
            # The package says int and takes parts of a second.
            make: Any = WatchdogTask
            self._task: Any = make(device, timeout=timeout_s, grpc_options=route.options())
            self._task.cfg_watchdog_ao_expir_states([AOExpirationState(output, 0.0, WatchdogAOExpirState.VOLTAGE)])
            self._task.start()

    def beat(self) -> None:
        """Reset its timer.

        Raises:
            OutputLostError: it has expired, so that the device holds the output at 0 V, whatever is written to it.
        """
        with translated(self._where):
            if self._task.expired:
                raise OutputLostError(
                    "the watchdog has expired: nothing was read for longer than it allows; the output is held at 0 V",
                    where=self._where,
                    remedy="allow it longer, or use a less busy machine",
                )
            self._task.reset_timer()

    def ready(self) -> None:
        """Before a burst: where it has expired while nothing was driven, let it watch anew."""
        with translated(self._where):
            if self._task.expired:
                self._task.clear_expiration()
            self._task.reset_timer()

    def close(self) -> None:
        """Stop it."""
        with suppress(nidaqmx.errors.Error):
            self._task.stop()
            self._task.close()


class HeartbeatLine:
    """A digital line that changes as long as samples are read."""

    def __init__(self, route: Route, line: str) -> None:
        """Take the line.

        Raises:
            ConfigurationError: there is no such line.
        """
        self._where = f"{route.address.url}, rig file field excitation.heartbeat_line"
        self._level = False
        with translated(self._where):
            self._task: Any = route.task()
            self._task.do_channels.add_do_chan(line)

    def beat(self) -> None:
        """Change the line."""
        self._level = not self._level
        with translated(self._where):
            self._task.write(self._level, auto_start=True)

    def ready(self) -> None:
        """Nothing to do."""

    def close(self) -> None:
        """Let go of the line: it stands still."""
        with suppress(nidaqmx.errors.Error):
            self._task.close()


class Guards:
    """What the rig asks for of both, beaten at most once in BEAT_S."""

    def __init__(self, route: Route, excitation: Excitation | None, output: str | None) -> None:
        self._guards: list[Watchdog | HeartbeatLine] = []
        self._beaten_s = 0.0
        if excitation is None:
            return
        if excitation.watchdog_s is not None and output is not None:
            device = route.address.device
            self._guards.append(Watchdog(route, device, output, excitation.watchdog_s))
        if excitation.heartbeat_line:
            self._guards.append(HeartbeatLine(route, excitation.heartbeat_line))

    def beat(self, *, driving: bool) -> None:
        """All is well.

        Raises:
            OutputLostError: while a burst is on, a watchdog has ended it.
        """
        if not self._guards or time.monotonic() - self._beaten_s < BEAT_S:
            return
        self._beaten_s = time.monotonic()
        for guard in self._guards:
            try:
                guard.beat()
            except OutputLostError:
                if driving:
                    raise

    def ready(self) -> None:
        """A burst comes: all guards must watch."""
        for guard in self._guards:
            guard.ready()

    def close(self) -> None:
        """Stop watching."""
        for guard in self._guards:
            guard.close()
        self._guards = []
