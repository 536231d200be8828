"""NI-DAQmx status codes, as far as the simulated devices give them."""

import re
from typing import Any

from nidaqmx._stubs import nidaqmx_pb2 as messages

NOT_YET_AVAILABLE = -200284
NO_LONGER_AVAILABLE = -200279
NEVER_AVAILABLE = -200278
INVALID_TASK = -200088
INVALID_VALUE = -200077
NO_SUCH_CHANNEL = -200170
WRONG_MEASUREMENT = -200431
NO_SUCH_DEVICE = -200220
BAD_TRIGGER_SOURCE = -200265
BAD_ROUTE = -89120
NOT_SUPPORTED_HERE = -200452
RESERVED = -50103
DEVICE_GONE = -201003
OUTPUT_UNDERFLOW = -200290
NO_TEDS = -200709
DUPLICATE_TASK = -200089
NOT_FINISHED = -200560
CHASSIS_EXPIRED = -201478
OTHERS_RESERVED = -201477
EXPIRED_NOT_RESET = -200644
NO_WATCHDOG = -200662
MULTI_DEVICES = -200558
BUFFER_TOO_SMALL = -200229
ATTRIBUTE_UNKNOWN = -200197
NO_DEVICE_CONTEXT = -201118
NOT_CAPABLE_WHEN_IDLE = -200983
NO_CHANNELS = -200478
NO_SUCH_SCALE = -200378
NO_SUCH_TASK = -200485
NO_SUCH_GLOBAL_CHANNEL = -200882
BAD_TEDS = -200826
TRIGGER_ON_DEMAND = -200262
CANNOT_CONFIGURE_TEDS = -200791
NO_SUCH_TASK_CHANNEL = -200461
OTHER_SCALE = -200601
NO_TIMESTAMP = -209842
WRONG_CHANNELS = -200524
WRONG_LINES = -200463
NO_SUCH_DESTINATION = -89121
NOT_SIMULATED = -50256
SOFTWARE_FAULT = -50150

_SAID = {
    NOT_YET_AVAILABLE: "Some or all of the samples requested have not yet been acquired.",
    NO_LONGER_AVAILABLE: "The application is not able to keep up with the hardware acquisition.",
    -200222: "Acquisition has been stopped to prevent an input buffer overwrite.",
    -200361: "Onboard device memory overflow.",
    NEVER_AVAILABLE: "Samples will never be available: the acquisition is finite and has ended.",
    INVALID_TASK: "Task specified is invalid or does not exist.",
    INVALID_VALUE: "Requested value is not a supported value for this property.",
    NO_SUCH_CHANNEL: "Physical channel specified does not exist on this device.",
    WRONG_MEASUREMENT: "Selected physical channel does not support the measurement type required.",
    NO_SUCH_DEVICE: "Device identifier is invalid.",
    BAD_TRIGGER_SOURCE: "Source specified for the analog trigger is invalid.",
    BAD_ROUTE: "Source terminal to be routed could not be found on the device.",
    NOT_SUPPORTED_HERE: "Specified property is not supported by the device or is not applicable to the task.",
    RESERVED: "The specified resource is reserved.",
    DEVICE_GONE: "Device cannot be accessed: it is disconnected or powered off.",
    -88705: "The specified device is not present or is not active in the system.",
    -88709: "The operation was aborted: the device was removed.",
    -88710: "The running operation was aborted: the device was removed.",
    -50405: "No transfer is in progress because the transfer was aborted.",
    OUTPUT_UNDERFLOW: "The generation has stopped to prevent the regeneration of old samples.",
    -200621: "Onboard device memory underflow.",
    -200018: "DAC conversion attempted before data to be converted was available.",
    NO_TEDS: "TEDS sensor not detected on physical channel.",
    DUPLICATE_TASK: "Task name specified conflicts with an existing task name.",
    MULTI_DEVICES: "Task contains physical channels on devices that cannot be in one task.",
    BUFFER_TOO_SMALL: "Buffer is too small to fit read data.",
    ATTRIBUTE_UNKNOWN: "Specified property is not supported by the device.",
    NO_DEVICE_CONTEXT: "Operation does not support a device context.",
    NO_CHANNELS: "The operation cannot be performed because there are no channels in the task.",
    NO_SUCH_TASK: "Task specified is invalid because it does not exist in the data neighborhood.",
    NO_SUCH_GLOBAL_CHANNEL: "Global channel specified is invalid.",
    NO_TIMESTAMP: "Timestamp is not enabled for the event.",
    WRONG_CHANNELS: "Write cannot be performed, because the number of channels in the data does not match the "
    "number of channels in the task.",
    WRONG_LINES: "Specified read or write operation failed, because the number of lines in the data for a channel does "
    "not match the number of lines in the channel.",
    OTHER_SCALE: "Specified property is not supported for the type of the scale.",
    NO_SUCH_TASK_CHANNEL: "Specified channel name is not in the task.",
    NOT_CAPABLE_WHEN_IDLE: "Property can only be read while the task is reserved, committed or running.",
    TRIGGER_ON_DEMAND: "A trigger was configured, but the sample timing type is on demand.",
    CANNOT_CONFIGURE_TEDS: "Channel cannot be configured for TEDS.",
    BAD_TEDS: "TEDS sensor data is invalid or cannot be read.",
    NO_SUCH_DESTINATION: "Destination terminal to be routed could not be found on the device.",
    NO_SUCH_SCALE: "Custom scale specified does not exist.",
    CHASSIS_EXPIRED: "The chassis' watchdog timer has expired. Reset the chassis.",
    OTHERS_RESERVED: "The watchdog task cannot be reserved while other tasks on the chassis are reserved.",
    EXPIRED_NOT_RESET: "The watchdog timer has expired and cannot be reset.",
    NO_WATCHDOG: "The device does not support a watchdog timer.",
    NOT_SIMULATED: "The requested feature is not supported: the simulated server lacks it.",
    SOFTWARE_FAULT: "The software has encountered an internal fault.",
    NOT_FINISHED: "Wait Until Done did not indicate that the task was done within the specified timeout.",
}


def describe(code: int) -> str:
    """The text of a status code."""
    return f"{_SAID.get(code, 'An NI-DAQmx error occurred.')}\n\nStatus Code: {code}"


class StatusError(Exception):
    """A negative status, which goes over the wire as one."""

    def __init__(self, code: int, detail: str = "", samples: int | None = None) -> None:
        super().__init__(code)
        self.code = code
        self.samples = samples
        self.text = describe(code) + (f"\n\n{detail}" if detail else "")


class SessionError(Exception):
    """A session that is there and must not be, or the other way round: no status of the driver, one of the server."""

    def __init__(self, text: str, *, exists: bool) -> None:
        super().__init__(text)
        self.text, self.exists = text, exists


_ENUM = re.compile(
    r"(?P<family>\w+?)(?P<kind>Int32Array|UInt32Array|DoubleArray|Int32|UInt32|UInt64|Double|Bool|String|Bytes|"
    r"Timestamp)Attribute"
)
_DESCRIPTOR: Any = messages.DESCRIPTOR

FAMILIES = {
    "SystemInfo": "System", "Chan": "Channel", "PhysicalChan": "PhysicalChannel", "Trig": "Trigger",
    "TimingEx": "Timing", "CalInfo": "CalibrationInfo", "ExportedSignal": "ExportSignal",
    "PersistedChan": "PersistedChannel",
}  # fmt: skip
"""Family of attributes by its short form in a call's name, where the two differ."""


def _read() -> dict[str, dict[int, tuple[str, str]]]:
    found: dict[str, dict[int, tuple[str, str]]] = {}
    for title, enum in _DESCRIPTOR.enum_types_by_name.items():
        match = _ENUM.fullmatch(title)
        if match is None:
            continue
        known = found.setdefault(match["family"], {})
        for value in enum.values:
            if value.number:
                known[value.number] = (value.name.partition("_ATTRIBUTE_")[2], match["kind"])
    return found


_NAMES = _read()
_UNLISTED = {0x31E8: ("DEFAULT_NUMBER_OF_SAMPLES_TO_READ", "UInt32")}
ZEROS: dict[str, Any] = {
    "Int32": 0, "UInt32": 0, "UInt64": 0, "Double": 0.0, "Bool": False, "String": "", "Bytes": b"", "Int32Array": [],
    "UInt32Array": [], "DoubleArray": [],
}  # fmt: skip


def lookup(family: str, number: int) -> tuple[str, str]:
    """Name and type of an attribute; an unknown one has the name ""."""
    return _NAMES.get(family, {}).get(number, _UNLISTED.get(number, ("", "Int32")))


def kind_of(family: str, name: str) -> str:
    """Type of an attribute by its name; "" if there is none."""
    return next((kind for found, kind in _NAMES.get(family, {}).values() if found == name), "")
