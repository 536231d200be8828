"""What the service knows of other machines: the database's server, and the scheduler with its certificates."""

from typing import TYPE_CHECKING

from sqlalchemy.engine import make_url
from sqlalchemy.exc import ArgumentError

from modallab.core.settings import Settings
from modallab.service.errors import ServiceError
from modallab.storage.address import ADDRESS, database_of, name_database

if TYPE_CHECKING:
    from modallab.jobs.address import Tls


def settle_database(settings: Settings) -> None:
    """Have the data folder name the database of the settings, if it names none yet; what it names is what counts.

    Raises:
        ServiceError: it names another one, or the setting is no address. No password is shown.
        FormatError: it has a catalogue of its own.
    """
    if settings.database is None:
        return
    url = settings.database.get_secret_value()
    if not (settings.data / ADDRESS).exists():
        _shown(url)
        name_database(settings.data, url)
    elif database_of(settings.data) != url:
        raise ServiceError(
            f"the folder names {_shown(database_of(settings.data))}, the setting {_shown(url)}",
            where=str(settings.data / ADDRESS),
            remedy="leave the setting out; to move to another server, see modallab backup and restore",
        )


def tls_of(settings: Settings) -> "Tls | None":
    """The certificates for the scheduler; None if the settings name none, and Dask's own configuration counts.

    Raises:
        ServiceError: only some of the three files are named.
    """
    from modallab.jobs.address import Tls

    ca, cert, key = settings.scheduler_ca, settings.scheduler_cert, settings.scheduler_key
    if ca is not None and cert is not None and key is not None:
        return Tls(ca, cert, key)
    if ca or cert or key:
        raise ServiceError(
            "certificates for the scheduler need all of authority, certificate and key",
            where="scheduler",
            remedy="set MODALLAB_SCHEDULER_CA, MODALLAB_SCHEDULER_CERT and MODALLAB_SCHEDULER_KEY",
        )
    return None


def require_scheduler(settings: Settings) -> None:
    """Look at the scheduler's address and certificates before anything is started.

    Raises:
        JobError: an address that would not be safe, or a file that is not there.
        ServiceError: as `tls_of`.
    """
    if settings.scheduler is None:
        return
    from modallab.jobs.address import Tls, check_address

    tls = tls_of(settings) or Tls.configured()
    check_address(settings.scheduler, tls)
    if tls is not None:
        tls.security()


def _shown(url: str) -> str:
    try:
        return make_url(url).render_as_string(hide_password=True)
    except ArgumentError as error:
        raise ServiceError(
            "the address of the database cannot be understood",
            where="MODALLAB_DATABASE",
            remedy="write it as postgresql://user:password@machine:5432/name",
        ) from error
