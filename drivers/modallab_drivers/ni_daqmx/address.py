"""Addresses of NI devices."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import parse_qsl, urlsplit

from modallab.core.errors import ConfigurationError

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


def parse(url: str, *, whole_system: bool = False) -> Address:
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
