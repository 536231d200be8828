"""Addresses of NI devices, and the way to them: this machine's driver, or a gRPC device server."""

import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar
from urllib.parse import parse_qsl, urlsplit

import grpc
import nidaqmx
import nidaqmx.errors
from nidaqmx.system import Device, PhysicalChannel, System

from modallab.bench.protocol import FoundDevice
from modallab.core.errors import ConfigurationError, DeviceBusyError
from modallab_drivers.ni_daqmx.errors import typed_errors

_FILES = ("tls", "cert", "key")
_SWITCHES = ("virtual_time", "local")
_KNOWN = (*_FILES, *_SWITCHES)


@dataclass(frozen=True, slots=True)
class Address:
    """Where a device is.

    Attributes:
        url: as it was given.
        device: name of the device or chassis; of several, the first, whose clock the others follow.
        server: `host:port` of a gRPC device server; empty: this machine.
        certificate: of the authority that signed the server's certificate; None: no TLS.
        own: our certificate and its key, for a server that wants to know who asks.
        others: further devices or chassis of the bench.
        virtual_time: whether the bench's time goes on only by reading, as with a simulated server that is not paced.
        streams: whether bursts stream from this process and end with it: with a driver on this machine, or a simulated
            server in its local mode. A real server keeps them going.
    """

    url: str
    device: str
    server: str = ""
    certificate: Path | None = None
    own: tuple[Path, Path] | None = None
    virtual_time: bool = False
    others: tuple[str, ...] = ()
    streams: bool = False


def parse_address(url: str, *, whole_system: bool = False) -> Address:
    """Read an address strictly; that of a whole system needs to name no device.

    Raises:
        ConfigurationError: it names no device, no server where one is needed, or an unknown parameter.
    """
    parts = urlsplit(url)
    remote = parts.scheme == "nidaqmx+grpc"
    device, *others = (parts.path.strip("/") if remote else parts.netloc).split(",")
    placed = bool(parts.netloc) if remote else not parts.path.strip("/")
    if not placed or not all((device or whole_system, *others)):
        example = "nidaqmx+grpc://host:31763/cDAQ1" if remote else "nidaqmx://cDAQ1"
        raise ConfigurationError(f"no device is named by {url!r}", remedy=f"write {example}")
    given = _parameters(parts.query, url)
    files = {name: Path(given[name]) for name in _FILES if name in given}
    _require_files(files, url)
    own = (files["cert"], files["key"]) if "cert" in files else None
    server = parts.netloc if remote else ""
    virtual_time, local = (given.get(switch) == "1" for switch in _SWITCHES)
    streams = local or not remote
    return Address(url, device, server, files.get("tls"), own, virtual_time, tuple(others), streams=streams)


def _parameters(query: str, url: str) -> dict[str, str]:
    given = dict(parse_qsl(query, keep_blank_values=True))
    if set(given) - set(_KNOWN) or any(given.get(switch, "0") not in ("0", "1") for switch in _SWITCHES):
        raise ConfigurationError(
            f"unknown parameter in {query!r}",
            where=url,
            remedy="allowed: tls=ca.crt, cert=own.crt with key=own.key, virtual_time=1, local=1",
        )
    return given


def _require_files(files: Mapping[str, Path], url: str) -> None:
    for name, path in files.items():
        if not path.is_file():
            raise ConfigurationError(f"{name}: there is no file {path}", where=url, remedy="give its path")
    if ("cert" in files) != ("key" in files) or ("cert" in files and "tls" not in files):
        raise ConfigurationError(
            f"only {', '.join(files)} is given", where=url, remedy="give tls, cert and key together, or tls alone"
        )


T = TypeVar("T")

MESSAGE_BYTES = 256 << 20
BUSY_TRIES = 6
BUSY_WAIT_S = 0.1
ZERO_WAIT_S = 0.01
"""Two who bring the output to 0 V at the same time each hold it for a few milliseconds."""

# A server that is cut off must be noticed: without pings a call would wait for ever.
_OPTIONS = [
    ("grpc.max_receive_message_length", MESSAGE_BYTES),
    ("grpc.max_send_message_length", MESSAGE_BYTES),
    ("grpc.keepalive_time_ms", 10_000),
    ("grpc.keepalive_timeout_ms", 2_000),
]


@dataclass(frozen=True, slots=True)
class DeviceInfo:
    """One device.

    Attributes:
        name: as the system names it.
        product: its type.
        serial: its number, as on the label.
        inputs: physical channels.
        outputs: physical channels.
        input_range_v: largest of its ranges; 0 without inputs.
        output_range_v: largest of its ranges; 0 without outputs.
        unit: the chassis it sits in and whose clock it has, else itself.
        supplies_a: currents it can feed an IEPE sensor with; empty where it lists none.
    """

    name: str
    product: str
    serial: str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    input_range_v: float
    output_range_v: float
    unit: str = ""
    supplies_a: tuple[float, ...] = ()


class Route:
    """Makes tasks and finds devices."""

    def __init__(self, address: Address) -> None:
        self.address = address
        self._channel = _channel(address) if address.server else None

    def task(self, name: str = "", *, attach: bool = False) -> Any:
        """A new task; with `attach` the one of that name another client has made."""
        if self._channel is None:
            return nidaqmx.Task(name)
        behaviour = nidaqmx.SessionInitializationBehavior
        chosen = behaviour.ATTACH_TO_SERVER_SESSION if attach else behaviour.INITIALIZE_SERVER_SESSION
        options = nidaqmx.GrpcSessionOptions(self._channel, name, initialization_behavior=chosen)
        return nidaqmx.Task(name, grpc_options=options)

    def options(self, name: str = "") -> Any:
        """What other objects of the package need to go the same way, by the name of a session; None on this machine."""
        return None if self._channel is None else nidaqmx.GrpcSessionOptions(self._channel, name)

    @property
    def remote(self) -> bool:
        """Whether there is a server between."""
        return self._channel is not None

    def system(self) -> Any:
        """The system."""
        return System.local() if self._channel is None else System.remote(self.options())

    def device(self, name: str) -> Any:
        """A device by its name."""
        return Device(name, grpc_options=self.options()) if self._channel is not None else Device(name)

    def physical_channel(self, name: str) -> Any:
        """An input or output by its name."""
        return (
            PhysicalChannel(name, grpc_options=self.options()) if self._channel is not None else PhysicalChannel(name)
        )

    def devices(self) -> tuple[DeviceInfo, ...]:
        """The devices of the address, or the modules of its chassis, in order.

        Raises:
            ConfigurationError: there is no such device.
            DeviceGoneError: no driver, no server.
        """
        with typed_errors(self.address.url):
            known = list(self.system().devices.device_names)
            named = (self.address.device, *self.address.others)
            if missing := [name for name in named if name not in known]:
                raise ConfigurationError(
                    f"no device {missing[0]!r}; there are {', '.join(known) or 'none'}",
                    where=f"{self.address.url} (rig file field bench)",
                    remedy="name one of them",
                )
            return tuple(info for name in named for info in self._parts_of(name))

    def _parts_of(self, name: str) -> list[DeviceInfo]:
        modules = [module.name for module in self.device(name).chassis_module_devices]
        return [self.describe(part, name) for part in modules or [name]]

    def describe(self, name: str, unit: str = "") -> DeviceInfo:
        """What one device is, of a chassis `unit` if it is a module."""
        device = self.device(name)
        inputs = tuple(device.ai_physical_chans.channel_names)
        outputs = tuple(device.ao_physical_chans.channel_names)
        return DeviceInfo(
            name,
            device.product_type,
            f"{device.serial_num:X}",
            inputs,
            outputs,
            max(device.ai_voltage_rngs, default=0.0) if inputs else 0.0,
            max(device.ao_voltage_rngs, default=0.0) if outputs else 0.0,
            unit or name,
            _supplies(device) if inputs else (),
        )

    def close(self) -> None:
        """Let go of the server."""
        if self._channel is not None:
            self._channel.close()


def retry_while_reserved(call: Callable[[], T], wait_s: float | None = None) -> T:
    """Try again for a while when another program holds what is needed.

    Args:
        call: to make.
        wait_s: the first wait; each next one is that much longer. By default for another program to end.

    Raises:
        DeviceBusyError: it still does; the message names it.
    """
    step_s = BUSY_WAIT_S if wait_s is None else wait_s
    for attempt in range(BUSY_TRIES - 1):
        with suppress(DeviceBusyError):
            return call()
        time.sleep(step_s * (attempt + 1))
    return call()


def found_devices(url: str) -> list[FoundDevice]:
    """Every device of a system, with its address.

    Raises:
        ConfigurationError: the address is not understood.
        DeviceGoneError: no driver, no server.
    """
    address = parse_address(url, whole_system=True)
    route = Route(address)
    scheme, query = url.partition("://")[0], url.partition("?")[1] + url.partition("?")[2]
    base = f"{scheme}://{address.server}/" if address.server else "nidaqmx://"
    try:
        with typed_errors(url):
            names = list(route.system().devices.device_names)
            found = [(name, route.describe(name)) for name in names]
    finally:
        route.close()
    return [FoundDevice(f"{base}{name}{query}", _said(device)) for name, device in found]


def _supplies(device: Any) -> tuple[float, ...]:
    try:
        return tuple(sorted({float(current) for current in device.ai_current_int_excit_discrete_vals if current > 0}))
    except nidaqmx.errors.DaqError:
        # Many a device without a supply rejects the question.
        return ()


def _said(device: DeviceInfo) -> str:
    counted = f"{len(device.inputs)} inputs, {len(device.outputs)} outputs"
    return f"{device.product}, serial {device.serial}, {counted}"


def _channel(address: Address) -> grpc.Channel:
    if address.certificate is None:
        return grpc.insecure_channel(address.server, options=_OPTIONS)
    certificate, key = (None, None) if address.own is None else (path.read_bytes() for path in address.own)
    credentials = grpc.ssl_channel_credentials(address.certificate.read_bytes(), key, certificate)
    return grpc.secure_channel(address.server, credentials, options=_OPTIONS)
