"""What is settled before the service starts: its token, its database, and the scheduler with its certificates."""

import os
import secrets
from pathlib import Path
from typing import TYPE_CHECKING

from sqlalchemy.engine import make_url
from sqlalchemy.exc import ArgumentError

from modallab.core.discovery import require_package
from modallab.core.settings import Settings
from modallab.service.errors import ServiceError
from modallab.storage.engine import ADDRESS, database_of, name_database

if TYPE_CHECKING:
    from modallab.jobs.cluster import TlsFiles


NAME = "token"
LEAST = 16


def token_path(settings: Settings) -> Path:
    """Where the token is kept."""
    return settings.token_file or settings.data / NAME


def require_token(settings: Settings) -> str:
    """The token of the settings, or that of the file, which is made if it is not there.

    Raises:
        ServiceError: others may reach the service and no token was chosen for it; the file cannot be used.
    """
    if settings.token is not None:
        return settings.token
    path = token_path(settings)
    if not settings.is_local and settings.token_file is not None:
        return _chosen_token(settings.token_file)
    if not settings.is_local:
        raise ServiceError(
            f"other computers can reach {settings.host}, but no token was chosen",
            where="host",
            remedy="set MODALLAB_TOKEN to at least 16 characters, name a file that holds them, or listen on 127.0.0.1",
        )
    try:
        return _read_token(path) or _make_token(path)
    except (FileExistsError, NotADirectoryError) as error:
        raise ServiceError(
            "is a file", where=str(path.parent), remedy="name a folder for the recordings by --data"
        ) from error
    except OSError as error:
        raise ServiceError(
            f"the token file cannot be used: {error.strerror}", where=str(path), remedy="name another by --token-file"
        ) from error


def _chosen_token(path: Path) -> str:
    # Named on purpose, as a secret that an engine for containers puts there: who may read it is not ours to say.
    try:
        token = path.read_text(encoding="ascii").strip()
    except (OSError, UnicodeError) as error:
        raise ServiceError(
            f"the token file cannot be used: {error}",
            where=str(path),
            remedy="write the token into that file, in ASCII",
        ) from error
    if len(token) < LEAST:
        raise ServiceError(
            f"the token has {len(token)} characters", where=str(path), remedy=f"choose at least {LEAST} characters"
        )
    return token


def _read_token(path: Path) -> str:
    if not path.exists():
        return ""
    # A file that others could read in between is no secret any more.
    shared = os.name == "posix" and path.stat().st_mode & 0o077
    return "" if shared else path.read_text(encoding="ascii").strip()


def _make_token(path: Path) -> str:
    token = secrets.token_urlsafe(32)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.unlink(missing_ok=True)
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    with os.fdopen(descriptor, "w", encoding="ascii") as file:
        file.write(token + "\n")
    return token


def configure_database(settings: Settings) -> None:
    """Have the data folder name the database of the settings, if it names none yet; what it names is what counts.

    Raises:
        ServiceError: it names another one, or the setting is no address. No password is shown.
        FormatError: it has a catalogue of its own.
    """
    if settings.database is None:
        return
    url = settings.database.get_secret_value()
    if not (settings.data / ADDRESS).exists():
        _show_address(url)
        name_database(settings.data, url)
    elif database_of(settings.data) != url:
        raise ServiceError(
            f"the folder names {_show_address(database_of(settings.data))}, the setting {_show_address(url)}",
            where=str(settings.data / ADDRESS),
            remedy="leave the setting out; to move to another server, see modallab backup and restore",
        )


def scheduler_certificates(settings: Settings) -> "TlsFiles | None":
    """The certificates for the scheduler; None if the settings name none, and Dask's own configuration counts.

    Raises:
        ServiceError: only some of the three files are named.
    """
    from modallab.jobs.cluster import TlsFiles

    ca, cert, key = settings.scheduler_ca, settings.scheduler_cert, settings.scheduler_key
    if ca is not None and cert is not None and key is not None:
        return TlsFiles(ca, cert, key)
    if ca or cert or key:
        raise ServiceError(
            "certificates for the scheduler need all of authority, certificate and key",
            where="scheduler",
            remedy="set MODALLAB_SCHEDULER_CA, MODALLAB_SCHEDULER_CERT and MODALLAB_SCHEDULER_KEY",
        )
    return None


def require_scheduler(settings: Settings) -> None:
    """Look at the scheduler's address and certificates, and for Dask itself, before anything is started.

    Raises:
        MissingPackageError: jobs are to be computed here, and Dask is not installed.
        JobError: an address that would not be safe, or a file that is not there.
        ServiceError: as `tls_of`.
    """
    if settings.jobs:
        require_package("distributed", "computing models and diagnoses in the service (or start with --no-jobs)")
    if settings.scheduler is None:
        return
    from modallab.jobs.cluster import TlsFiles, check_address

    tls = scheduler_certificates(settings) or TlsFiles.configured()
    check_address(settings.scheduler, tls)
    if tls is not None:
        tls.security()


def _show_address(url: str) -> str:
    try:
        return make_url(url).render_as_string(hide_password=True)
    except ArgumentError as error:
        raise ServiceError(
            "the address of the database is not valid",
            where="MODALLAB_DATABASE",
            remedy="write it as postgresql://user:password@machine:5432/name",
        ) from error
