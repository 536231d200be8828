"""What watches from the device's side: a chassis' watchdog, and a line that toggles for an external relay."""

import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any, TypeVar

import nidaqmx.errors
from nidaqmx.constants import WatchdogAOExpirState
from nidaqmx.system.watchdog import WatchdogTask
from nidaqmx.types import AOExpirationState

from modallab.core.hardware import Excitation
from modallab_drivers.ni_daqmx.errors import CHASSIS_EXPIRED, WatchdogExpiredError, error_of_status, typed_errors
from modallab_drivers.ni_daqmx.route import ZERO_WAIT_S, Route, retry_while_reserved

T = TypeVar("T")

BEAT_S = 0.02


def watchdog_name(device: str) -> str:
    """Name under which a server knows a chassis' watchdog, so that a second handle finds it."""
    return f"modallab-{device}-watchdog"


def heartbeat_name(device: str) -> str:
    """Name under which a server knows the task of the heartbeat line: left behind, it would keep a watchdog off."""
    return f"modallab-{device}-heartbeat"


def call_after_reset(route: Route, call: Callable[[], T]) -> T:
    """Make a call; where the chassis' watchdog has expired, reset the chassis first.

    The vendor's rule: after an expiry nothing goes on a chassis until it is reset, and to clear the watchdog's task is
    not enough. A reset ends every task on the chassis and brings its outputs to their power-up state, 0 V.

    Raises:
        BenchError: of the call.
    """
    try:
        return call()
    except WatchdogExpiredError:
        with typed_errors(f"{route.address.url}, reset after its watchdog expired"):
            route.device(route.address.device).reset_device()
        return call()


class Watchdog:
    """Brings the outputs to 0 V when nobody resets it in time, whatever became of us."""

    def __init__(self, route: Route, device: str, outputs: Sequence[str], timeout_s: float) -> None:
        """Start it. Nothing else may be reserved on the chassis: it comes before all other tasks.

        Raises:
            ConfigurationError: the device has none.
            DeviceBusyError: something else goes on on the chassis.
        """
        self._where = f"{route.address.url}, rig file field excitation.watchdog_s"
        self._task = self._made(route, device, timeout_s)
        try:
            with typed_errors(self._where):
                self._task.cfg_watchdog_ao_expir_states(
                    [AOExpirationState(output, 0.0, WatchdogAOExpirState.VOLTAGE) for output in outputs]
                )
                self._task.start()
        except BaseException:
            self.close()
            raise

    def _made(self, route: Route, device: str, timeout_s: float) -> Any:
        name = watchdog_name(device)
        # The package says int and takes parts of a second.
        make: Any = WatchdogTask
        with typed_errors(self._where):
            return make(device, task_name=name, timeout=timeout_s, grpc_options=route.options(name))

    def beat(self) -> None:
        """Reset its timer.

        Raises:
            WatchdogExpiredError: the device holds the output at 0 V, whatever is written to it, until it is reset.
        """
        with typed_errors(self._where):
            if self._task.expired:
                raise error_of_status(CHASSIS_EXPIRED, "", self._where)
            self._task.reset_timer()

    def close(self) -> None:
        """Stop it."""
        for step in (self._task.stop, self._task.close):
            with suppress(nidaqmx.errors.Error):
                step()
        # A reset of the chassis has ended it already.
        self._task._close_on_exit = False


class HeartbeatLine:
    """A digital line that changes as long as samples are read."""

    def __init__(self, route: Route, line: str) -> None:
        """Take the line.

        Raises:
            ConfigurationError: there is no such line.
        """
        self._where = f"{route.address.url}, rig file field excitation.heartbeat_line"
        self._level = False
        with typed_errors(self._where):
            self._task: Any = route.task(heartbeat_name(route.address.device))
            self._task.do_channels.add_do_chan(line)

    def beat(self) -> None:
        """Change the line."""
        self._level = not self._level
        with typed_errors(self._where):
            self._task.write(self._level, auto_start=True)

    def close(self) -> None:
        """Let go of the line: it stands still."""
        with suppress(nidaqmx.errors.Error):
            self._task.close()


class Guards:
    """What the rig asks for of both, beaten at most once in BEAT_S."""

    def __init__(self, route: Route, excitation: Excitation | None, outputs: Sequence[str]) -> None:
        self._guards: list[Watchdog | HeartbeatLine] = []
        self._beaten_s = 0.0
        if excitation is None:
            return
        if excitation.watchdog_s is not None and outputs:
            device = route.address.device
            timeout_s = excitation.watchdog_s
            self._guards.append(retry_while_reserved(lambda: Watchdog(route, device, outputs, timeout_s), ZERO_WAIT_S))
        if excitation.heartbeat_line:
            self._guards.append(HeartbeatLine(route, excitation.heartbeat_line))

    def beat(self, *, now: bool = False) -> None:
        """All is well; `now` even if it was said a moment ago.

        Raises:
            WatchdogExpiredError: a watchdog has ended whatever was on.
        """
        if not self._guards or (time.monotonic() - self._beaten_s < BEAT_S and not now):
            return
        self._beaten_s = time.monotonic()
        for guard in self._guards:
            guard.beat()

    def close(self) -> None:
        """Stop watching."""
        for guard in self._guards:
            guard.close()
        self._guards = []
