"""The token every request must carry: made at random, kept in a file only its owner can read."""

import os
import secrets
from pathlib import Path

from modallab.core.settings import Settings
from modallab.service.errors import ServiceError

NAME = "token"


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
    if not settings.is_local:
        raise ServiceError(
            f"others can reach {settings.host}, and no token was chosen",
            where="host",
            remedy="set MODALLAB_TOKEN to at least 16 characters, or listen on 127.0.0.1",
        )
    path = token_path(settings)
    try:
        return _read(path) or _make(path)
    except OSError as error:
        raise ServiceError(
            f"the token file cannot be used: {error.strerror}", where=str(path), remedy="name another by --token-file"
        ) from error


def _read(path: Path) -> str:
    if not path.exists():
        return ""
    # A file that others could read in between is no secret any more.
    shared = os.name == "posix" and path.stat().st_mode & 0o077
    return "" if shared else path.read_text(encoding="ascii").strip()


def _make(path: Path) -> str:
    token = secrets.token_urlsafe(32)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.unlink(missing_ok=True)
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    with os.fdopen(descriptor, "w", encoding="ascii") as file:
        file.write(token + "\n")
    return token
