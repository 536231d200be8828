"""The settings of the service: from the environment (MODALLAB_...), a file, or the command line."""

from pathlib import Path
from typing import Annotated

from pydantic import AfterValidator, AliasChoices, Field, SecretStr
from pydantic_settings import BaseSettings, SettingsConfigDict

LOOPBACK = frozenset({"127.0.0.1", "::1", "localhost"})


RENAMED = ("MODALLAB_HEARTBEAT_TIMEOUT_S", "MODALLAB_SILENCE_S")
"""The time-out of the heartbeat; the second name is what older installations set."""


def _with_index(folder: Path) -> Path:
    if not (folder / "index.html").is_file():
        raise ValueError("holds no index.html; build the manual with `make docs`")
    return folder


class Settings(BaseSettings):
    """Settings of the service.

    Attributes:
        data: folder of the recordings.
        host: address to listen on.
        port: port of the REST service; 0 for any free one.
        stop_port: port of the emergency stop; 0 for any free one.
        stop_url: address of the emergency stop behind a proxy, as reported by `/health`.
        token: token of every request; random by default.
        token_file: file of the token, readable for its owner only (default: `token` in the data folder).
        hosts: host names of the service, besides its own address.
        body_bytes: largest body of a request.
        database: database of a new data folder: `postgresql://...`. This setting is no option of the command line,
            since
            the address may contain a password.
        scheduler: address of a Dask scheduler; none: workers of this machine.
        scheduler_ca: certificate of the authority, for a scheduler at `tls://`; without the three files Dask's own
            configuration counts.
        scheduler_cert: this machine's certificate.
        scheduler_key: key of that certificate.
        jobs: whether this service computes jobs; otherwise jobs wait for another service on the same database.
        workers: number of processes that compute jobs on this machine; none: one less than there are processors.
        heartbeat_timeout_s: longest time without a sign of life of the REST process before a driving test is
            stopped. On a
            busy machine this may take up to five times as long.
        log_level: level of the log on standard error.
        grace_days: days in which a campaign or run that was deleted over REST can be restored.
        tls_cert: certificate of the service, as PEM; REST service and emergency stop then use TLS.
        tls_key: key of that certificate.
        tls_self_signed: whether to make a certificate in the folder `tls` of the data folder, and use it.
        file_bytes: largest recording to import over REST.
        site: folder of the manual that `make docs` built, served at `/manual/`; none: no manual.
        cors: origins of other sites whose pages may use the service, with a token: `https://page.lab:8443`.
    """

    model_config = SettingsConfigDict(env_prefix="MODALLAB_", extra="forbid", frozen=True, populate_by_name=True)

    data: Path = Path("data")
    host: str = "127.0.0.1"
    port: Annotated[int, Field(ge=0, le=65535)] = 8000
    stop_port: Annotated[int, Field(ge=0, le=65535)] = 8001
    stop_url: str | None = None
    token: Annotated[str, Field(min_length=16)] | None = None
    token_file: Path | None = None
    hosts: tuple[str, ...] = ()
    body_bytes: Annotated[int, Field(ge=1024)] = 1 << 20
    database: SecretStr | None = None
    scheduler: str | None = None
    scheduler_ca: Path | None = None
    scheduler_cert: Path | None = None
    scheduler_key: Path | None = None
    jobs: bool = True
    workers: Annotated[int, Field(ge=1)] | None = None
    heartbeat_timeout_s: Annotated[
        float,
        Field(ge=1, le=60, validation_alias=AliasChoices(*RENAMED)),
    ] = 1.0
    log_level: str = "INFO"
    tls_cert: Path | None = None
    tls_key: Path | None = None
    tls_self_signed: bool = False
    file_bytes: Annotated[int, Field(ge=1024)] = 1 << 30
    site: Annotated[Path, AfterValidator(_with_index)] | None = None
    cors: tuple[Annotated[str, Field(pattern=r"^https?://[^/\s]+$")], ...] = ()
    grace_days: Annotated[float, Field(ge=0.04, le=3660)] = 30.0

    @property
    def scheme(self) -> str:
        """`https` with TLS, else `http`."""
        return "http" if self.tls_cert is None else "https"

    @property
    def is_local(self) -> bool:
        """Whether only this machine can reach the service."""
        return self.host in LOOPBACK
