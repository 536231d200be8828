"""Addresses of NI devices."""

from dataclasses import dataclass
from pathlib import Path
from urllib.parse import parse_qsl, urlsplit

from modallab.errors import ConfigurationError

_KNOWN = ("tls", "virtual_time")


@dataclass(frozen=True, slots=True)
class Address:
    """Where a device is.

    Attributes:
        url: as it was given.
        device: name of the device or chassis.
        server: `host:port` of a gRPC device server; empty: this machine.
        certificate: of the authority that signed the server's certificate; None: no TLS.
        virtual_time: whether the bench's time goes on only by reading, as with a simulated server that is not paced.
    """

    url: str
    device: str
    server: str = ""
    certificate: Path | None = None
    virtual_time: bool = False


def parse(url: str) -> Address:
    """Read an address strictly.

    Raises:
        ConfigurationError: it names no device, no server where one is needed, or an unknown parameter.
    """
    parts = urlsplit(url)
    remote = parts.scheme == "nidaqmx+grpc"
    device = parts.path.strip("/") if remote else parts.netloc
    example = "nidaqmx+grpc://host:31763/cDAQ1" if remote else "nidaqmx://cDAQ1"
    if not device or (remote and not parts.netloc) or (not remote and parts.path.strip("/")):
        raise ConfigurationError(f"no device is named by {url!r}", remedy=f"write {example}")
    given = dict(parse_qsl(parts.query, keep_blank_values=True))
    unknown = sorted(set(given) - set(_KNOWN))
    if unknown or given.get("virtual_time", "0") not in ("0", "1"):
        raise ConfigurationError(
            f"unknown parameter in {parts.query!r}", where=url, remedy="allowed: tls=ca.crt, virtual_time=1"
        )
    certificate = Path(given["tls"]) if "tls" in given else None
    if certificate is not None and not certificate.is_file():
        raise ConfigurationError(f"there is no certificate at {certificate}", where=url, remedy="give its path")
    return Address(url, device, parts.netloc if remote else "", certificate, given.get("virtual_time") == "1")
