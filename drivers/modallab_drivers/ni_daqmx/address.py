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
    example = "nidaqmx+grpc://host:31763/cDAQ1" if remote else "nidaqmx://cDAQ1"
    if (
        not all((device or whole_system, *others))
        or (remote and not parts.netloc)
        or (not remote and parts.path.strip("/"))
    ):
        raise ConfigurationError(f"no device is named by {url!r}", remedy=f"write {example}")
    given = dict(parse_qsl(parts.query, keep_blank_values=True))
    unknown = sorted(set(given) - set(_KNOWN))
    if unknown or any(given.get(switch, "0") not in ("0", "1") for switch in _SWITCHES):
        raise ConfigurationError(
            f"unknown parameter in {parts.query!r}",
            where=url,
            remedy="allowed: tls=ca.crt, cert=own.crt with key=own.key, virtual_time=1, local=1",
        )
    files = {name: Path(given[name]) for name in _FILES if name in given}
    _require_files(files, url)
    own = (files["cert"], files["key"]) if "cert" in files else None
    server = parts.netloc if remote else ""
    virtual_time, local = (given.get(switch) == "1" for switch in _SWITCHES)
    return Address(
        url,
        device,
        server,
        files.get("tls"),
        own,
        virtual_time,
        tuple(others),
        streams=local or not remote,
    )


def _require_files(files: Mapping[str, Path], url: str) -> None:
    for name, path in files.items():
        if not path.is_file():
            raise ConfigurationError(f"{name}: there is no file {path}", where=url, remedy="give its path")
    if ("cert" in files) != ("key" in files) or ("cert" in files and "tls" not in files):
        raise ConfigurationError(
            f"only {', '.join(files)} is given", where=url, remedy="give tls, cert and key together, or tls alone"
        )
