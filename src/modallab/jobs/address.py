"""Where a scheduler is, and what shows that both sides are who they should be."""

import ipaddress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self
from urllib.parse import urlsplit

from dask import config
from distributed.security import Security

from modallab.core.errors import JobError


@dataclass(frozen=True, slots=True)
class TlsFiles:
    """Certificate files of one's own machines: each side shows its own and demands one by the same authority."""

    ca: Path
    cert: Path
    key: Path

    @classmethod
    def configured(cls) -> Self | None:
        """The files that Dask's own configuration or environment names for a client; None if it names none."""
        names = ("ca-file", "client.cert", "client.key")
        files = [config.get(f"distributed.comm.tls.{name}", None) for name in names]
        return cls(*(Path(file) for file in files)) if all(files) else None

    def security(self) -> Security:
        """As Dask wants it."""
        names = {"ca_file": self.ca, "client_cert": self.cert, "client_key": self.key}
        missing = [str(path) for path in names.values() if not path.is_file()]
        if missing:
            raise JobError(
                f"no such certificate file: {', '.join(missing)}", where="TLS", remedy="name the files you made"
            )
        files: dict[str, Any] = {f"tls_{name}": str(path) for name, path in names.items()}
        return Security(require_encryption=True, **files)


def check_address(scheduler: str, tls: TlsFiles | None) -> None:
    """Reject an address that would send recordings, and code, in the open.

    Raises:
        JobError: no `tcp://` or `tls://` address with a port; `tcp://` to another machine; `tls://` without files.
    """
    parts = urlsplit(scheduler)
    try:
        known = parts.scheme in ("tcp", "tls") and parts.hostname and parts.port
    except ValueError:
        known = False
    if not known:
        raise JobError(f"{scheduler!r} is no address of a scheduler", where="scheduler", remedy="as tls://machine:8786")
    if parts.scheme == "tcp" and not _is_loopback(parts.hostname or ""):
        raise JobError(
            f"{scheduler} is another machine, and tcp:// is neither encrypted nor asks who is there",
            where="scheduler",
            remedy="start scheduler and workers with certificates, and use tls://",
        )
    if parts.scheme == "tls" and tls is None:
        raise JobError(
            f"{scheduler} needs certificates", where="scheduler", remedy="name authority, certificate and key"
        )


def _is_loopback(host: str) -> bool:
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False
