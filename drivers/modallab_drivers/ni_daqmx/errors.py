"""What each NI-DAQmx status means for the bench, and what is to be done about it."""

from collections.abc import Generator
from contextlib import contextmanager

import grpc
import nidaqmx.errors

from modallab.core.errors import (
    BenchError,
    BenchTimeoutError,
    ConfigurationError,
    DeviceBusyError,
    DeviceGoneError,
    OutputLostError,
    SamplesLostError,
)

NOT_YET = -200284
NEVER = -200278
HANDLE_DEAD = -200088
RESERVED = -50103
DUPLICATE = -200089
UNSUPPORTED_HERE = -200452
CHASSIS_EXPIRED = -201478

_LOST = "start again, with a gap in the samples; record at a lower rate or on a less busy machine if this repeats"
_GONE = "check the device's power, cable and network; the output is at 0 V or its burst ends; then start a new run"
_CONFIGURATION = "correct the named field of the rig file or the plan; modallab does not retry"
_TOGETHER = "check the connections of the devices: rig file field synchronisation"
_BUSY = (
    "end the program that uses the device, or wait; tasks of a killed modallab (named modallab-...) are "
    "released by: modallab devices ADDRESS --release"
)
_LOG = "look at the server's log"
_EXPIRED = "raise excitation.watchdog_s, or use a less busy machine; the next start resets the chassis"
_NO_WATCHDOG = (
    "this device has no watchdog: leave excitation.watchdog_s out, and give the reason in excitation.watchdog_waived"
)
_OUTPUT = "the output was brought to 0 V; play a shorter burst or use a faster link"


EXPIRED = "the watchdog has expired, since no sample was read within its time; the output is held at 0 V"


class WatchdogExpiredError(OutputLostError):
    """The chassis' watchdog has expired: its outputs are at 0 V, and nothing goes on it until it is reset."""


TABLE: dict[int, tuple[type[BenchError], str]] = {
    NOT_YET: (BenchTimeoutError, "wait longer; samples received so far are kept"),
    -200279: (SamplesLostError, _LOST),
    -200222: (SamplesLostError, _LOST),
    -200361: (SamplesLostError, _LOST),
    NEVER: (SamplesLostError, "the record is short, and is kept; start again"),
    HANDLE_DEAD: (SamplesLostError, "the task was lost on the device's side and is built again at the next start"),
    -201003: (DeviceGoneError, _GONE),
    -88705: (DeviceGoneError, _GONE),
    -88709: (DeviceGoneError, _GONE),
    -88710: (DeviceGoneError, _GONE),
    -50405: (DeviceGoneError, _GONE),
    RESERVED: (DeviceBusyError, _BUSY),
    DUPLICATE: (DeviceBusyError, _BUSY),
    -200077: (ConfigurationError, _CONFIGURATION),
    -200431: (ConfigurationError, _CONFIGURATION),
    -200170: (ConfigurationError, _CONFIGURATION),
    -200220: (ConfigurationError, _CONFIGURATION),
    -200265: (ConfigurationError, _CONFIGURATION),
    -89120: (ConfigurationError, _CONFIGURATION),
    UNSUPPORTED_HERE: (ConfigurationError, _CONFIGURATION),
    CHASSIS_EXPIRED: (WatchdogExpiredError, _EXPIRED),
    -200678: (WatchdogExpiredError, _EXPIRED),
    -200644: (WatchdogExpiredError, _EXPIRED),
    -201477: (DeviceBusyError, _BUSY),
    -200662: (ConfigurationError, _NO_WATCHDOG),
    -200558: (ConfigurationError, _TOGETHER),
    -200852: (ConfigurationError, _TOGETHER),
    -200853: (ConfigurationError, _TOGETHER),
    -200854: (ConfigurationError, _TOGETHER),
    -201090: (ConfigurationError, _TOGETHER),
    -201207: (ConfigurationError, _TOGETHER),
    -201346: (ConfigurationError, _TOGETHER),
    -201347: (ConfigurationError, _TOGETHER),
    -201361: (ConfigurationError, _TOGETHER),
    -209882: (ConfigurationError, _TOGETHER),
    -200290: (OutputLostError, _OUTPUT),
    -200621: (OutputLostError, _OUTPUT),
    -200018: (OutputLostError, _OUTPUT),
}
"""Every status that is expected, its type and its remedy."""


def typed_error(error: Exception, where: str) -> BenchError:
    """The typed error for what the package raised."""
    if isinstance(error, nidaqmx.errors.DaqError):
        return error_of_status(int(error.error_code), str(error), where)
    if isinstance(error, nidaqmx.errors.RpcError) and error.rpc_code == grpc.StatusCode.ALREADY_EXISTS:
        return DeviceBusyError(f"the device server: {error}", where=where, remedy=_BUSY)
    if isinstance(error, nidaqmx.errors.RpcError):
        gone = error.rpc_code in (grpc.StatusCode.UNAVAILABLE, grpc.StatusCode.CANCELLED)
        kind = DeviceGoneError if gone else BenchError
        return kind(f"the device server: {error}", where=where, remedy=_unreached(where) if gone else _LOG)
    if isinstance(error, nidaqmx.errors.DaqNotFoundError | nidaqmx.errors.DaqNotSupportedError):
        return DeviceGoneError(
            "NI-DAQmx is not installed on this machine",
            where=where,
            remedy="install NI-DAQmx, or reach the device's own machine by nidaqmx+grpc://host:port/device",
        )
    return BenchError(f"unexpected {type(error).__name__}: {error}", where=where, remedy="report this with the log")


def _unreached(where: str) -> str:
    if "tls=" in where:
        return f"{_GONE}; or it is not the server whose certificate tls= vouches for, or wants cert= and key= of ours"
    return f"{_GONE}; a server with TLS needs tls=ca.crt in the address"


def error_of_status(code: int, text: str, where: str) -> BenchError:
    """The typed error for a status."""
    kind, remedy = TABLE.get(code, (BenchError, "look the status up in NI's documentation; report it if it recurs"))
    said = " ".join(line.strip() for line in text.splitlines() if line.strip())
    if kind is WatchdogExpiredError:
        said = f"{EXPIRED}: {said}"
    return kind(f"{said}" if str(code) in said else f"{said} ({code})", where=where, remedy=remedy)


@contextmanager
def typed_errors(where: str) -> Generator[None]:
    """Whatever the package raises inside comes out typed.

    Raises:
        BenchError: of the table's type.
    """
    try:
        yield
    except nidaqmx.errors.Error as error:
        raise typed_error(error, where) from error
